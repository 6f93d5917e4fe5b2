"""What the code of a kernel depends on: all of an arm and its experiment but the numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from analytic.gears import Gears
from analytic.mesh_force import TANH
from analytic.mesh_frequency import OMEGA_T
from analytic.stiffness import SINE, TABLE
from models.arm import Arm
from models.drive import DriveData
from models.layout import Layout

SAME_RATE = 4 * np.finfo(float).eps  # relative: both rates are the ring's teeth, to rounding


@dataclass(frozen=True)
class StageShape:
    """A stage with mesh displacements.

    planets: coordinates x_pr, one if the planets are lumped; one_rate: sun and ring meshes have one
    frequency, so that their sines are one; harmonics: waves of the stiffness; turned: a phase that
    is not the joint's own asks for cosines too; alike: planets have the same meshes.
    """

    planets: int
    one_rate: bool
    harmonics: int
    turned: bool
    alike: bool

    def numbers_of(self, side: str, joint: int, planet: int) -> str:
        """What the numbers of a mesh, ``sp`` or ``pr`` of a planet, are called by."""
        return f"{side}{joint}" if self.alike else f"{side}{joint}_{planet}"


@dataclass(frozen=True)
class Structure:
    """The structure of a model; models of one structure can run side by side.

    stages: of every joint, None where it has no mesh displacements; spread: the constant inertia
    couples neighbouring links; drive: law code of models.drive.
    """

    stages: tuple[StageShape | None, ...]
    spread: bool
    gravity: bool
    friction: bool
    drive: int
    omega_t: bool
    tanh: bool
    damps_apart: bool
    conservative: bool

    @property
    def joints(self) -> range:
        """Counted from 1."""
        return range(1, len(self.stages) + 1)

    @cached_property
    def geared(self) -> list[tuple[int, StageShape]]:
        """The joints with mesh displacements, counted from 1."""
        return [(j, s) for j, s in zip(self.joints, self.stages, strict=True) if s is not None]

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """x_s and every planet's x_pr of stage after stage, then theta of joint after joint."""
        gears = [
            name
            for j, stage in self.geared
            for name in (f"x_s{j}", *(f"x_pr{j}_{n}" for n in range(1, stage.planets + 1)))
        ]
        return (*gears, *(f"theta{j}" for j in self.joints))

    @cached_property
    def meshes(self) -> tuple[str, ...]:
        """In the order of analytic.gears: sun and ring mesh of planet after planet."""
        return tuple(
            f"{side}{j}_{n}"
            for j, stage in self.geared
            for n in range(1, stage.planets + 1)
            for side in ("sp", "pr")
        )


def structure_of(
    arm: Arm, layout: Layout, gears: Gears, drive: DriveData, spread: bool
) -> Structure | None:
    """That of a model, or None if it has a part that no specialised kernel knows: a table."""
    if (gears.law.code == TABLE).any():
        return None
    return Structure(
        stages=_stages(arm, layout, gears),
        spread=spread,
        gravity=any(arm.gravity_m_per_s2),
        friction=any(joint.friction_N_m_s_per_rad for joint in arm.joints),
        drive=int(drive.code),
        omega_t=gears.phase == OMEGA_T,
        tanh=gears.dead_zone == TANH,
        damps_apart=bool(gears.damps_apart),
        conservative=bool(gears.conservative),
    )


def _stages(arm: Arm, layout: Layout, gears: Gears) -> tuple[StageShape | None, ...]:
    shapes: list[StageShape | None] = [None] * len(arm.joints)
    for joint in layout.meshing:
        meshes = np.flatnonzero(gears.theta == layout.theta[joint])
        sun, ring = gears.rate[meshes[0]], gears.rate[meshes[1]]
        shapes[joint] = StageShape(
            planets=meshes.size // 2,
            one_rate=bool(abs(sun - ring) <= SAME_RATE * abs(sun)),
            harmonics=max(waves_of(gears, int(mesh)) for mesh in meshes),
            turned=bool((gears.offset[meshes] != 0).any() or _turned(gears, meshes)),
            alike=all(_alike(gears, meshes[side::2]) for side in (0, 1)),
        )
    return tuple(shapes)


def waves_of(gears: Gears, mesh: int) -> int:
    """Waves of a mesh's stiffness."""
    if gears.law.code[mesh] == SINE:
        return 1
    return int(gears.law.first[mesh + 1] - gears.law.first[mesh])


def _turned(gears: Gears, meshes: np.ndarray) -> bool:
    return bool((gears.lead[meshes] != 0).any() or (gears.law.code[meshes] != SINE).any())


def _alike(gears: Gears, meshes: np.ndarray) -> bool:
    """Whether no number of these meshes differs."""
    waves = gears.k_m, gears.k_a, gears.E, gears.lead, gears.static, gears.offset
    fields = *waves, gears.b, gears.sigma, gears.d
    laws = [gears.law.rows[gears.law.first[i] : gears.law.first[i + 1]] for i in meshes]
    same_laws = len({law.tobytes() for law in laws}) == 1
    return same_laws and all((field[meshes] == field[meshes[0]]).all() for field in fields)
