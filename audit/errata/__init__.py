"""The audit of the paper's equations and text."""
