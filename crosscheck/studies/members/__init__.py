"""The members of a study, made into cases."""
