"""Supplied equations as a table of answers, which takes no code: what is asked and answered."""
