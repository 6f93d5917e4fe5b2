"""Plots of the report: the arm's scheme, signals to look into, and when each is made."""
