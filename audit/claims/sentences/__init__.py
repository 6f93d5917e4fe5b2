"""The paper's sentences as data, in the paper's order."""
