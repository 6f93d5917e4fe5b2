"""Commands that write a file: one to begin with, or one for other programs."""
