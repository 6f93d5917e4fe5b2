"""Checks of a robot's models: each module asks, plans and judges, and is found by lying here."""
