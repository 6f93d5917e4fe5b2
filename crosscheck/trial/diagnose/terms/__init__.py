"""Terms of entries: what belongs there, and which errors in them make a difference."""
