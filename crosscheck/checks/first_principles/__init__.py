"""Mechanics of an arm from first principles and its data alone, without any model."""
