"""A recorded motion compared with models of the arm: which explains it, and within what noise."""
