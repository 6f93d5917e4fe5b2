"""The trial of a user's own equations of motion: what is wrong, in which entry, in which term."""
