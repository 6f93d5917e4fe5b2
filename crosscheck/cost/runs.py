"""What a robot's runs come to: the end effector's distances, and how fast meshes swing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.cost.springs import tooth_springs
from crosscheck.models.robot.integration import conditioning_error
from crosscheck.models.robot.interface import RobotModel


def tip_distances(model: RobotModel, ends: np.ndarray, planned: np.ndarray) -> np.ndarray:
    """Distances (runs,) [m] of the end effector from its plan (runs, 3), infinite where it left."""
    distances, alive = np.full(len(ends), np.inf), np.isfinite(ends).all(axis=1)
    distances[alive] = np.linalg.norm(model.tip(ends[alive]) - planned[alive], axis=1)
    return distances


class MeshRates(NamedTuple):
    """Rates of swings on meshes [rad/s] (states, meshes), as if other joints' meshes were apart.

    A stage has two, of which the faster one stands at its sun mesh. fastest: of all swings and
    of their dying out [1/s] while all are in contact.
    """

    swings: np.ndarray
    fastest: float


def mesh_rates(model: RobotModel, mass_matrices: np.ndarray) -> MeshRates:
    """Rates of the swings on a robot's meshes; mass_matrices: M at each state, (states, n, n).

    Raises InputError for a robot whose mass matrix cannot be inverted.
    """
    try:
        inverse = np.linalg.inv(mass_matrices)
    except np.linalg.LinAlgError:
        raise conditioning_error(model.robot) from None
    free = len(model.robot.coordinates)
    inverse = inverse[:, free:, free:]
    if not (inverse.diagonal(axis1=1, axis2=2) > 0).all():
        raise conditioning_error(model.robot)
    joints, stiffness, stiffest, damping = np.transpose(
        [
            (mesh.joint, mesh.stiffness, mesh.stiffest, mesh.damping)
            for mesh in tooth_springs(model.robot)
        ]
    )

    def modes(indices: np.ndarray, sizes: np.ndarray) -> np.ndarray:
        """Eigenvalues (states, own), the smallest first, of springs, or dampers, at places."""
        root = np.sqrt(sizes[indices])
        block = inverse[:, indices[:, None], indices] * np.outer(root, root)
        return np.maximum(np.linalg.eigvalsh(block), 0.0)

    swings, every = np.zeros((len(inverse), joints.size)), np.arange(joints.size)
    for joint in joints:
        mesh = np.flatnonzero(joints == joint)
        swings[:, mesh] = np.sqrt(modes(mesh, stiffness))[:, ::-1]
    fastest = max(np.sqrt(modes(every, stiffest).max()), modes(every, damping).max())
    return MeshRates(swings, float(fastest))
