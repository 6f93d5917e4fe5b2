"""Random maps, and states to hold a terms against the compiled models at."""

import random
from dataclasses import dataclass

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.interface import Model
from crosscheck.models.loading import load_scenario
from crosscheck.registry import build
from crosscheck.trial.changes.arms.mesh_forces import ForceStates, compute_signals
from crosscheck.trial.changes.arms.segments import rate_name
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.input.equations import Coordinates


@dataclass(frozen=True)
class Sample:
    """A model and states in the user's coordinates: x and v (K, n), joint angles (K, joints)."""

    model: Model
    frame: Frame
    x: np.ndarray
    v: np.ndarray
    angles: np.ndarray
    signals: dict[str, np.ndarray]
    time: np.ndarray

    def mass(self) -> np.ndarray:
        """J^T M J (K, n, n)."""
        J = self.frame.matrix
        return np.array([J.T @ self.model.mass_matrix(J @ x) @ J for x in self.x])

    def bias(self) -> np.ndarray:
        """J^T h (K, n)."""
        J = self.frame.matrix
        return np.array(
            [J.T @ self.model.bias(J @ x, J @ v) for x, v in zip(self.x, self.v, strict=True)]
        )

    def force(self) -> np.ndarray:
        """J^T f (K, n)."""
        J = self.frame.matrix
        each = zip(self.time, self.x, self.v, strict=True)
        return np.array([J.T @ self.model.generalized_force(t, J @ x, J @ v) for t, x, v in each])


def drawn_coordinates(chooser: random.Random, gearing: str, n: int) -> Coordinates:
    """Named coordinates of any kind, or whole or any numbers of a matrix."""
    kind = chooser.choice(("named", "named", "named", "whole", "numbers"))
    if kind == "named":
        links = chooser.choice(("relative", "absolute"))
        gears = (
            chooser.choice(("displacements", "angles")) if gearing != "rigid" else "displacements"
        )
        return Coordinates(gearing, links, gears)
    generator = np.random.default_rng(chooser.randrange(2**32))
    upper = np.triu(generator.integers(-1, 2, (n, n)), 1) + np.eye(n)
    matrix = upper if kind == "whole" else upper * generator.uniform(0.5, 2.0, (n, n))
    return Coordinates(gearing, matrix=matrix)


def sample(
    arm: Arm, name: str, coordinates: Coordinates, chosen: Switches, count: int, seed: int
) -> Sample:
    """At random states with teeth in contact and apart, torques of a PD law."""
    scenario: Scenario = load_scenario("pd")
    model = build(name, arm, scenario, chosen)
    frame = build_frame(coordinates, arm)
    generator = np.random.default_rng(seed)
    n, layout = len(frame.layout), frame.layout
    q, v = generator.uniform(-3, 3, (2, count, n))
    q[:, ~layout.angular] *= 3e-5
    v[:, ~layout.angular] *= 1e-2
    inverse = np.linalg.inv(frame.matrix)
    x, rates = q @ inverse.T, v @ inverse.T
    q, v = x @ frame.matrix.T, rates @ frame.matrix.T
    time = generator.uniform(0, 2, count)
    torque = np.array(
        [
            [torque_of(model, j, *state) for j in range(len(arm.joints))]
            for state in zip(time, q, v, strict=True)
        ]
    )
    signals = compute_signals(arm, layout, model.switches, ForceStates(time, q, v, torque))
    signals |= {rate_name(own): rates[:, k] for k, own in enumerate(frame.names)}
    return Sample(model, frame, x, rates, q[:, layout.theta], signals, time)


def torque_of(model: Model, joint: int, t: float, q: np.ndarray, v: np.ndarray) -> float:
    """Of the scenario's drive [N m]."""
    from crosscheck.models.experiment.drive import joint_torque

    drive, sensed = model.drive, model.layout.theta[joint]
    table = drive.table_time, drive.table_torque[joint]
    return joint_torque(drive.code, drive.gains[joint], *table, t, q[sensed], v[sensed])
