"""What the paper's text gives that its equations and Table I do not, as data."""

INITIAL_VALUES = ("b", "b", "0", "b", "b", "0", "0", "0", "0", "0", "0")  # Section 3
DEVIATIONS_RAD = (0.02, 0.01)  # Section 3.1: what both joints deviate by
