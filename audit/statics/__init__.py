"""What follows from the arm's data alone, for claims and errata."""
