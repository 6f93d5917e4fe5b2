"""Plan of all runs and comparisons of a cross-check, made before anything runs."""
