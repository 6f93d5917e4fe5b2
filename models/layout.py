"""What the coordinates of an arm are: asked by every model, check and view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from models.arm import Arm

Meaning = Literal["theta", "x_sp", "x_pr"]
MESHES: tuple[Meaning, Meaning] = ("x_sp", "x_pr")


@dataclass(frozen=True)
class Coordinate:
    """One generalized coordinate: what it means, of which joint (from 1).

    ``theta`` [rad] is the joint's angle relative to the previous link; ``x_sp`` and ``x_pr`` [m]
    are the mesh displacements of Eqs. 2 and 3, alike for all planets of the joint.
    """

    meaning: Meaning
    joint: int

    @property
    def name(self) -> str:
        """For people and files; nothing reads it back."""
        return f"{self.meaning}_{self.joint}" if self.is_angle else f"{self.meaning}{self.joint}"

    @property
    def is_angle(self) -> bool:
        """Whether it is an angle [rad]; else it is a displacement [m]."""
        return self.meaning == "theta"


@dataclass(frozen=True)
class Layout:
    """The coordinates of a model, in their order."""

    coordinates: tuple[Coordinate, ...]

    def __len__(self) -> int:
        return len(self.coordinates)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all coordinates."""
        return tuple(coordinate.name for coordinate in self.coordinates)

    @cached_property
    def angular(self) -> np.ndarray:
        """Which coordinates (n,) are angles."""
        return np.array([coordinate.is_angle for coordinate in self.coordinates])

    @cached_property
    def theta(self) -> np.ndarray:
        """Places (joints,) of the joint angles."""
        return self.of("theta")

    @property
    def meshing(self) -> list[int]:
        """The joints, counted from 0, that have mesh displacements."""
        return [c.joint - 1 for c in self.coordinates if c.meaning == "x_sp"]

    def of(self, meaning: Meaning) -> np.ndarray:
        """Places of the coordinates of one meaning, joint by joint."""
        places = [k for k, c in enumerate(self.coordinates) if c.meaning == meaning]
        return np.array(places, dtype=np.int64)

    def at(self, meaning: Meaning, joint: int) -> int:
        """Place of a coordinate of a joint, counted from 0. Raises ValueError if it has none."""
        return self.coordinates.index(Coordinate(meaning, joint + 1))


def lumped_layout(arm: Arm) -> Layout:
    """The paper's coordinates (Eq. 20), joint by joint: x_sp, x_pr of geared ones, and theta."""
    return layout_of([joint.kind == "planetary" for joint in arm.joints])


def rigid_layout(arm: Arm) -> Layout:
    """The rigid arm's coordinates (Eq. 1): theta, joint by joint."""
    return layout_of([False] * len(arm.joints))


def layout_of(meshing: Sequence[bool]) -> Layout:
    """Coordinates of joints of which each has mesh displacements or has none."""
    found: list[Coordinate] = []
    for number, has_meshes in enumerate(meshing, start=1):
        meanings: tuple[Meaning, ...] = (*MESHES, "theta") if has_meshes else ("theta",)
        found += [Coordinate(meaning, number) for meaning in meanings]
    return Layout(tuple(found))
