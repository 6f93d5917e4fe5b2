"""What a robot's runs come to: the end effector's distances."""

from __future__ import annotations

import numpy as np

from crosscheck.models.robot.interface import RobotModel


def tip_distances(model: RobotModel, ends: np.ndarray, planned: np.ndarray) -> np.ndarray:
    """Distances (runs,) [m] of the end effector from its plan (runs, 3), infinite where it left."""
    distances, alive = np.full(len(ends), np.inf), np.isfinite(ends).all(axis=1)
    distances[alive] = np.linalg.norm(model.tip(ends[alive]) - planned[alive], axis=1)
    return distances
