"""Runs with another clock, phase or sensor than a scenario can state."""
