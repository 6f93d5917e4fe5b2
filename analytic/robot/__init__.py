"""Equations of motion of a robot in space, derived by Kane's method."""
