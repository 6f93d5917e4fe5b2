"""What a cross-check runs and compares, planned before anything runs."""
