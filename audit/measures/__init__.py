"""What is measured of a run, and what shares of runs can tell."""
