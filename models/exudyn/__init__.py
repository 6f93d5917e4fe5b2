"""Models in Exudyn: a kinematic tree of an arm or a robot, and an arm's separate bodies."""
