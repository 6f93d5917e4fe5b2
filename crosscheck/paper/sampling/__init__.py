"""Every experiment of the paper from many starts, and what is measured of its runs."""
