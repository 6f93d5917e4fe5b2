"""Which line of a user's source must change so that wrong equations become right."""
