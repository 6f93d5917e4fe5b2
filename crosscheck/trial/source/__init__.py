"""Search for the line of a user's source that must change to make wrong equations right."""
