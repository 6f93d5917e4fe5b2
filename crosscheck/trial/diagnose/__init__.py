"""Which term of a wrong entry is wrong."""
