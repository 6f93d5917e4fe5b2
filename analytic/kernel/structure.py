"""The structure that fixes a kernel's code: all of an arm and its experiment but the numbers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.paper.mesh_force import TANH
from crosscheck.analytic.paper.mesh_frequency import OMEGA_T
from crosscheck.analytic.paper.stiffness import SINE, TABLE
from crosscheck.models.experiment.drive import DriveData

SAME_RATE = 4 * np.finfo(float).eps  # relative: both rates are the ring's teeth, to rounding
Lines = Iterator[str]


class StageShape(NamedTuple):
    """A stage with mesh displacements.

    planets: coordinates x_pr, one if the planets are lumped; shared_rate: sun and ring meshes have
    one frequency, so that their sines are one; harmonics: waves of the stiffness; pieces: rows of
    its longest table, filled up to a power of two, 0 without one; has_cosines: a phase that is not
    the joint's own asks for cosines too; equal_planets: planets have the same meshes.
    """

    planets: int
    shared_rate: bool
    harmonics: int
    pieces: int
    has_cosines: bool
    equal_planets: bool

    def numbers_name(self, side: str, joint: int, planet: int) -> str:
        """Name by which the numbers of a mesh, ``sp`` or ``pr`` of a planet, are called."""
        return f"{side}{joint}" if self.equal_planets else f"{side}{joint}_{planet}"


@dataclass(frozen=True)
class Structure(ABC):
    """The structure of a model; models of one structure can run side by side.

    stages: of every joint, None where it has no mesh displacements; drive: law code of
    models.experiment.drive; omega_t, tanh, damps_without_contact, conservative: the laws of the
    meshes.
    """

    stages: tuple[StageShape | None, ...]
    drive: int
    omega_t: bool
    tanh: bool
    damps_without_contact: bool
    conservative: bool

    @property
    @abstractmethod
    def coordinates(self) -> tuple[str, ...]:
        """Names of the kernel's own coordinates; those of angles begin with ``theta``."""

    @abstractmethod
    def acceleration(self) -> Lines:
        """Lines from coordinates and rates to their accelerations and the mesh forces."""

    def turns(self, joint: int, side: str) -> str:
        """Phase [turns] of a side's meshes, ``sp`` or ``pr``, as text, but for their constants."""
        driven = f"v_theta{joint} * t" if self.omega_t else f"q_theta{joint}"
        return f"rate_{side}{joint} * ({driven})"

    @property
    def joints(self) -> range:
        """The joints, counted from 1."""
        return range(1, len(self.stages) + 1)

    @property
    def driven_joints(self) -> range:
        """The joints with a motor's torque, the first ones."""
        return self.joints

    @cached_property
    def geared_joints(self) -> list[tuple[int, StageShape]]:
        """The joints with mesh displacements, counted from 1."""
        return [(j, s) for j, s in zip(self.joints, self.stages, strict=True) if s is not None]

    @cached_property
    def meshes(self) -> tuple[str, ...]:
        """Names of the meshes: sun and ring mesh of planet after planet.

        Their order is that of analytic.derivation.gears.
        """
        return tuple(
            f"{side}{j}_{n}"
            for j, stage in self.geared_joints
            for n in range(1, stage.planets + 1)
            for side in ("sp", "pr")
        )


def common_structure(
    theta: Sequence[int], gears: Gears, drive: DriveData
) -> tuple[tuple[StageShape | None, ...], int, bool, bool, bool, bool]:
    """The fields of a model that every Structure has; theta: places of the joints' angles in q."""
    laws = gears.phase == OMEGA_T, gears.dead_zone == TANH
    switches = bool(gears.damps_without_contact), bool(gears.conservative)
    return _stages(theta, gears), int(drive.code), *laws, *switches


def _stages(theta: Sequence[int], gears: Gears) -> tuple[StageShape | None, ...]:
    law, rows, tabled = gears.law, np.diff(gears.law.first), gears.law.code == TABLE
    with_cosines = (gears.error_phase != 0) | (law.code != SINE)  # at the joint's own phase
    waves = np.where(law.code == SINE, 1, np.where(tabled, 0, rows))  # of each mesh's stiffness
    shapes: list[StageShape | None] = [None] * len(theta)
    for joint, place in enumerate(theta):
        meshes = np.flatnonzero(gears.theta == place)
        if not meshes.size:
            continue
        sun, ring = gears.rate[meshes[0]], gears.rate[meshes[1]]
        longest = int((rows * tabled)[meshes].max())
        shapes[joint] = StageShape(
            planets=meshes.size // 2,
            shared_rate=bool(abs(sun - ring) <= SAME_RATE * abs(sun)),
            harmonics=int(waves[meshes].max()),
            pieces=2 ** (longest - 1).bit_length() if longest else 0,
            has_cosines=bool((gears.offset[meshes] != 0).any() or with_cosines[meshes].any()),
            equal_planets=all(_are_meshes_equal(gears, meshes[side::2]) for side in (0, 1)),
        )
    return tuple(shapes)


def _are_meshes_equal(gears: Gears, meshes: np.ndarray) -> bool:
    """Whether no number of these meshes differs."""
    if len(meshes) == 1:
        return True
    waves = gears.k_m, gears.k_a, gears.E, gears.error_phase, gears.static_error, gears.offset
    fields = *waves, gears.b, gears.sigma, gears.d
    laws = [gears.law.rows[gears.law.first[i] : gears.law.first[i + 1]] for i in meshes]
    same_laws = len({law.tobytes() for law in laws}) == 1
    return same_laws and all((field[meshes] == field[meshes[0]]).all() for field in fields)
