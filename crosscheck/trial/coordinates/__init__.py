"""A user's coordinates beside the project's."""
