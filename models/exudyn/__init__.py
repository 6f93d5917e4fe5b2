"""Models of the arm in Exudyn: a kinematic tree, and separate bodies on constraints."""
