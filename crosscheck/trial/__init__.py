"""A user's own equations of motion on trial: what is wrong, in which entry, in which term."""
