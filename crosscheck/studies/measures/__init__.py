"""Measurements on members while they run."""
