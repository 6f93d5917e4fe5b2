"""Costs of the usual shortcuts in modelling a robot's gears: torques and end effector."""
