"""A study as data: its file, axes and quantities."""
