"""Studies of thousands of members: what is varied, what is measured, run in batches anywhere."""
