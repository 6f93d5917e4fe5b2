"""Hypotheses H2 to H6 and the unknown damping."""
