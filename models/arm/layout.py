"""The coordinates of an arm, which every model, check and view shares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Switches

Meaning = Literal["theta", "x_s", "x_sp", "x_pr"]
MESHES: tuple[Meaning, Meaning] = ("x_sp", "x_pr")


@dataclass(frozen=True)
class Coordinate:
    """One generalized coordinate: its meaning, joint (from 1) and planet (from 1).

    ``theta`` [rad] is the joint's angle relative to the previous link; ``x_sp`` and ``x_pr`` [m]
    are the mesh displacements of Eqs. 2 and 3, of all planets (planet 0) or of one; ``x_s`` [m] is
    the sun's advance x_sp + x_pr, which all planets share.
    """

    meaning: Meaning
    joint: int
    planet: int = 0

    @property
    def name(self) -> str:
        """Name for people and files, such as ``theta_1`` or ``x_pr2_3``; nothing reads it back."""
        if self.is_angle:
            return f"{self.meaning}_{self.joint}"
        return f"{self.meaning}{self.joint}" + (f"_{self.planet}" if self.planet else "")

    @property
    def is_angle(self) -> bool:
        """Whether the coordinate is an angle [rad]; else it is a displacement [m]."""
        return self.meaning == "theta"


@dataclass(frozen=True)
class Layout:
    """The coordinates of a model, in their order."""

    coordinates: tuple[Coordinate, ...]

    def __len__(self) -> int:
        return len(self.coordinates)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all coordinates, in their order."""
        return tuple(coordinate.name for coordinate in self.coordinates)

    @cached_property
    def angular(self) -> np.ndarray:
        """Whether each coordinate is an angle, shape (n,)."""
        return np.array([coordinate.is_angle for coordinate in self.coordinates])

    @cached_property
    def theta(self) -> np.ndarray:
        """Places of the joint angles among the coordinates, shape (joints,)."""
        return self.indices("theta")

    @cached_property
    def places(self) -> dict[Coordinate, int]:
        """The place of each coordinate."""
        return {coordinate: place for place, coordinate in enumerate(self.coordinates)}

    @cached_property
    def mesh_joints(self) -> list[int]:
        """The joints, counted from 0, that have mesh displacements."""
        joints = (c.joint - 1 for c in self.coordinates if c.meaning == "x_pr")
        return list(dict.fromkeys(joints))

    @cached_property
    def free(self) -> bool:
        """Whether every planet has a coordinate of its own."""
        return any(c.meaning == "x_s" for c in self.coordinates)

    def indices(self, meaning: Meaning) -> np.ndarray:
        """Places of the coordinates of one meaning, joint by joint, planet by planet."""
        places = [k for k, c in enumerate(self.coordinates) if c.meaning == meaning]
        return np.array(places, dtype=np.int64)

    def at(self, meaning: Meaning, joint: int, planet: int | None = None) -> int:
        """Place of a coordinate of a joint and planet, both counted from 0; None: of all planets.

        Raises ValueError if there is none.
        """
        coordinate = Coordinate(meaning, joint + 1, 0 if planet is None else planet + 1)
        if coordinate not in self.places:
            raise ValueError(f"no {coordinate.name}")
        return self.places[coordinate]

    def displacement(self, mesh: Meaning, joint: int, planet: int) -> np.ndarray:
        """Row (n,) that gives x_sp or x_pr of a planet; joint and planet counted from 0.

        Of free planets x_sp is x_s - x_pr.
        """
        row = np.zeros(len(self))
        if not self.free:
            row[self.at(mesh, joint)] = 1.0
            return row
        if mesh == "x_sp":
            row[self.at("x_s", joint)] = 1.0
        row[self.at("x_pr", joint, planet)] = -1.0 if mesh == "x_sp" else 1.0
        return row


def geared_layout(arm: Arm, chosen: Switches) -> Layout:
    """Coordinates of an arm's geared models, with planets lumped or free by the switch."""
    return free_layout(arm) if chosen.planets == "free" else lumped_layout(arm)


def lumped_layout(arm: Arm) -> Layout:
    """The paper's coordinates (Eq. 20), joint by joint: x_sp, x_pr of geared ones, and theta."""
    return make_layout([joint.kind == "planetary" for joint in arm.joints])


def free_layout(arm: Arm) -> Layout:
    """x_s and an x_pr for each planet, joint by joint, and then the thetas.

    In this order elimination leaves gears uncoupled: each of them knows the thetas alone.
    """
    coordinates: list[Coordinate] = []
    for number, joint in enumerate(arm.joints, start=1):
        if joint.planet_count:
            coordinates.append(Coordinate("x_s", number))
        coordinates += [Coordinate("x_pr", number, p + 1) for p in range(joint.planet_count)]
    thetas = [Coordinate("theta", number + 1) for number in range(len(arm.joints))]
    return Layout((*coordinates, *thetas))


def rigid_layout(arm: Arm) -> Layout:
    """The rigid arm's coordinates (Eq. 1): theta, joint by joint."""
    return make_layout([False] * len(arm.joints))


def make_layout(meshing: Sequence[bool]) -> Layout:
    """Coordinates of joints of which each has mesh displacements or has none."""
    coordinates: list[Coordinate] = []
    for number, has_meshes in enumerate(meshing, start=1):
        meanings: tuple[Meaning, ...] = (*MESHES, "theta") if has_meshes else ("theta",)
        coordinates += [Coordinate(meaning, number) for meaning in meanings]
    return Layout(tuple(coordinates))
