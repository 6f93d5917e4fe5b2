"""What the signals of a run are of its coordinates and its meshes' forces: of arms and robots."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import MESHES, Layout, Meaning
from crosscheck.models.experiment.drive import DriveData, torques_along
from crosscheck.models.robot.robot import JointStage, Level, Robot

FORCES = "F_sp", "F_pr"


@dataclass(frozen=True)
class SignalMap:
    """Rows that give the signals of joints and meshes.

    rows: theta of all joints that move (joints, n), by the coordinates, x_sp and x_pr of planets
    (joints, planets, n), x_mesh of rotors (joints, n); elastic forces F_sp, F_pr and F_mesh, by
    those of the model's meshes in place of coordinates; NaN where a joint has none. offsets
    (joints,): of theta; free: numbers of the joints that follow no other.
    """

    rows: dict[str, np.ndarray]
    offsets: np.ndarray
    free: Sequence[int]

    @cached_property
    def _summands(self) -> dict[str, list[tuple[np.ndarray, np.ndarray | None]]]:
        """Of each signal, places and factors of what its rows sum up: most of them are 0."""
        return {name: _list_summands(rows) for name, rows in self.rows.items()}

    def read(self, name: str, x: np.ndarray) -> np.ndarray:
        """A signal (records, joints, [planets,] members), without offsets.

        x (records, n, members): coordinates, their rates or accelerations, or forces of meshes.
        """
        shape = (len(x), *self.rows[name].shape[:-1], x.shape[2])
        parts = [
            x[:, places] if factors is None else factors[:, np.newaxis] * x[:, places]
            for places, factors in self._summands[name]
        ]
        return sum(parts[1:], parts[0]).reshape(shape) if parts else np.full(shape, np.nan)

    def find_torques(
        self, drive: DriveData, time: np.ndarray, theta: np.ndarray, theta_dot: np.ndarray
    ) -> np.ndarray:
        """Driving torques (times, joints) [N m], [N], of angles and rates; 0 of followers."""
        torques, free = np.zeros_like(theta), list(self.free)
        torques[:, free] = torques_along(drive, time, theta[:, free], theta_dot[:, free])
        return torques

    def record_run(
        self,
        drive: DriveData,
        time: np.ndarray,
        motion: tuple[np.ndarray, np.ndarray, np.ndarray],
        forces: np.ndarray | None = None,
    ) -> dict[str, np.ndarray]:
        """The signals of one run by name, over time (times,) [s].

        motion: coordinates, rates and accelerations (times, n); forces (times, meshes) [N]: where
        the model has them.
        """
        q, v, a = motion

        def read(name: str, x: np.ndarray) -> np.ndarray:
            return np.moveaxis(self.read(name, x.T[np.newaxis])[0], -1, 0).copy()

        theta, theta_dot = read("theta", q) + self.offsets, read("theta", v)
        signals = {"theta": theta, "theta_dot": theta_dot, "theta_ddot": read("theta", a)}
        signals["torque"] = self.find_torques(drive, time, theta, theta_dot)
        there = [name for name, rows in self.rows.items() if not np.isnan(rows).all()]
        for name in there:
            if name.startswith("x"):
                signals |= {name: read(name, q), f"{name}_dot": read(name, v)}
            elif name.startswith("F") and forces is not None:
                signals[name] = read(name, forces)
        return signals


def _list_summands(rows: np.ndarray) -> list[tuple[np.ndarray, np.ndarray | None]]:
    """Places and factors of each summand of rows (..., n), unless the factors are all 1."""
    flat = rows.reshape(math.prod(rows.shape[:-1]), rows.shape[-1])
    factors = np.where(np.isnan(flat) & (np.arange(flat.shape[1]) > 0), 0.0, flat)
    order = np.argsort(factors == 0, axis=1, kind="stable")
    most = np.count_nonzero(factors, axis=1).max(initial=0)
    summands = ((places, factors[np.arange(len(flat)), places]) for places in order.T[:most])
    return [(places, None if (each == 1).all() else each) for places, each in summands]


class MeshedStage(NamedTuple):
    """A planetary stage whose meshes have coordinates.

    forced: how many of its planets have forces of their own at sun and ring, one for all or each;
    displacement: the row (n,) of a planet's mesh.
    """

    joint: int
    planets: int
    forced: int
    displacement: Callable[..., np.ndarray]


def map_arm(arm: Arm, layout: Layout) -> SignalMap:
    """The signals of an arm in a layout; forces are planet by planet, or of the one for all."""
    theta, joints = np.eye(len(layout))[layout.theta], len(arm.joints)
    stages = []
    for joint in layout.mesh_joints:
        planets = arm.joints[joint].planet_count
        row = partial(layout.displacement, joint=joint)
        stages.append(MeshedStage(joint, planets, planets if layout.free else 1, row))
    rows = {"theta": theta, **_map_meshes(stages, theta.shape)}
    return SignalMap(rows, np.zeros(joints), range(joints))


def map_robot(robot: Robot, level: Level, labels: Sequence[int] | None = None) -> SignalMap:
    """The signals of a robot at a level, in the robot's coordinates.

    labels: of all joints, by which a kernel sorts the forces of stages, one where planets move as
    one; else every planet has its own, stage by stage.
    """
    factors, offsets = robot.joint_map
    is_geared = level == "geared"
    springs = np.zeros((len(factors), robot.mesh_coordinates if is_geared else 0))
    theta = np.hstack([factors, springs])
    placed = list(zip(robot.stages, robot.stage_columns, strict=True)) if is_geared else []
    if labels is not None:
        placed.sort(key=lambda each: labels[each[0].joint])
    stages = []
    for stage, columns in placed:
        planets = stage.gears.planet_count
        row = partial(_place_row, stage, columns, theta.shape[1])
        forced = planets if labels is None else len(stage.groups)
        stages.append(MeshedStage(stage.joint, planets, forced, row))
    rotors = [rotor.joint for rotor, _ in robot.meshes if is_geared]
    rows = {"theta": theta, **_map_meshes(stages, theta.shape, rotors, factors.shape[1])}
    return SignalMap(rows, offsets, robot.coordinates)


def _place_row(
    stage: JointStage, columns: slice, size: int, *, mesh: Meaning, planet: int
) -> np.ndarray:
    """The row (size,) of a planet's mesh by all coordinates, those of its stage at columns."""
    row = np.zeros(size)
    row[columns] = stage.displacement(mesh, planet)
    return row


def _map_meshes(
    stages: Sequence[MeshedStage],
    shape: tuple[int, ...],
    rotors: Sequence[int] = (),
    first: int = 0,
) -> dict[str, np.ndarray]:
    """Rows of meshes by the names of signals; shape: (joints, n).

    rotors: joints of rotors that have a mesh, first: the place of the first one's coordinate.
    Forces are those of rotors, then of planet after planet with sun and ring.
    """
    joints, size = shape
    planets = max((stage.planets for stage in stages), default=0)
    forces = len(rotors) + 2 * sum(stage.forced for stage in stages)
    x, force = np.eye(size), np.eye(forces)
    rows: dict[str, np.ndarray] = {"x_mesh": np.full(shape, np.nan)}
    rows |= {name: np.full((joints, planets, size), np.nan) for name in MESHES}
    rows |= {name: np.full((joints, planets, forces), np.nan) for name in FORCES}
    rows["F_mesh"] = np.full((joints, forces), np.nan)
    for place, joint in enumerate(rotors):
        rows["x_mesh"][joint], rows["F_mesh"][joint] = x[first + place], force[place]
    place = len(rotors)
    for stage in stages:
        for planet in range(stage.planets):
            first_force = place + 2 * (planet if stage.forced > 1 else 0)
            for side, name in enumerate(MESHES):
                rows[name][stage.joint, planet] = stage.displacement(mesh=name, planet=planet)
                rows[FORCES[side]][stage.joint, planet] = force[first_force + side]
        place += 2 * stage.forced
    return rows
