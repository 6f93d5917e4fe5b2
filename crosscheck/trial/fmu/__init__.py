"""Functional mock-up units as supplied equations, by FMPy."""
