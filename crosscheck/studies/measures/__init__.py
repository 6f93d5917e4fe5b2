"""What is measured of members while they run."""
