"""Models of the arm in Pinocchio: the rigid levels, and a tree with the gears as bodies."""
