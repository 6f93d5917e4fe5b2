"""The runs and measures behind the hypotheses."""
