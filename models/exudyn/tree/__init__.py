"""The kinematic tree in minimal coordinates with custom mesh springs."""
