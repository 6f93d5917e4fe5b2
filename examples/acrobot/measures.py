"""What the claims ask of a run, beside the quantities of studies."""

import numpy as np

GOAL_M = 1.0  # above the bar: the length of a link


def tip(run):
    """Height of the tip above the bar, at most [m]; when it first exceeds the goal [s]."""
    first, second = run["theta"].values.T
    height = -np.cos(first) - np.cos(first + second)
    goal = np.flatnonzero(height > GOAL_M)
    return {"height": height.max(), "reached": run["time"].values[goal[0]] if goal.size else None}
