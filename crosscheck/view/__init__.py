"""A run as a page: the arm in three dimensions, its gears turning."""
