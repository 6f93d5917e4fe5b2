"""What the usual shortcuts in the model of a robot's gears cost: torques and end effector."""
