"""An arm of two stages whose planets all differ, and its teeth's forces and energy by hand.

Neither set of teeth is in phase: 28 sun teeth do not go by three planets, nor 31 by four.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from crosscheck.models.arm.arm import Arm
from tests.mixed_arms import LAWS, PLANET_M, Data, arm_of, geared, mean_stiffness, stiffness

RATIOS = (0.04, 0.06, 0.05)  # of the shoulder's ring meshes
ANGLES = (9, 10)  # places of the joints' angles; x_s and every x_pr stand before, 4 and 5


class Teeth(NamedTuple):
    """One planet's mesh. Error's wave and what of it stands [m], damper [N s/m], angles [rad].

    phase: of the mesh at zero angles, counted by hand.
    """

    law: str
    backlash: float
    error: float
    error_phase: float
    static: float
    damping: float
    phase: float


class GearStage(NamedTuple):
    """Mesh phase per joint angle, and the meshes, planet by planet."""

    ring_teeth: int
    sun: tuple[Teeth, ...]
    ring: tuple[Teeth, ...]


def by_ratio(place: int, law: str) -> float:
    """An N-th of 2 zeta sqrt(N k N M_p) [N s/m], of three planets."""
    return 2 * RATIOS[place] * float(np.sqrt(mean_stiffness(law) * PLANET_M))


# The sun's 28 teeth are 9 1/3 a planet: each lags a third of a pitch behind the one before, as the
# ring's 92, 30 2/3 a planet, say too. 15 1/2 pitches lie between the flanks of a planet's 32 teeth.
THIRD = 2 * np.pi / 3
SHOULDER = GearStage(
    92,
    sun=(
        Teeth("table", 4e-5, 2e-5, 0.3, 1e-6, 500.0, 0.0),
        Teeth("fourier", 5e-5, 1e-5, -0.8, -7e-6, 300.0, -THIRD),
        Teeth("square", 3e-5, 1.5e-5, 1.9, 4e-6, 700.0, -2 * THIRD),
    ),
    ring=(
        Teeth("sine", 3.5e-5, 9e-6, 0.0, 3e-6, by_ratio(0, "sine"), np.pi),
        Teeth("table", 2e-5, 1.2e-5, 2.2, -5e-6, by_ratio(1, "table"), np.pi - THIRD),
        Teeth("fourier", 4.5e-5, 6e-6, -1.1, 8e-6, by_ratio(2, "fourier"), np.pi - 2 * THIRD),
    ),
)
# 31 teeth are 7 3/4 a planet, a quarter short of eight; 15 whole pitches lie between the flanks of
# a planet's 31. The sun's phase is given, and the ring's goes with it.
QUARTER = np.pi / 2
ELBOW = GearStage(
    93,
    sun=tuple(
        Teeth("sine", 2e-5 + 1e-5 * n, 1e-5, 0.2, 2e-6 * n, 275.0, 0.7 + QUARTER * n)
        for n in range(4)
    ),
    ring=tuple(
        Teeth("square", 3e-5, 1e-5 - 2e-6 * n, 0.4 * n, -1e-6, 325.0, 0.7 + QUARTER * n)
        for n in range(4)
    ),
)
STAGES = (SHOULDER, ELBOW)


def unlike_arm() -> Arm:
    """Shoulder and elbow with planets of their own, in free fall."""
    ratios = {"damping_N_s_per_m": None, "damping_ratio": RATIOS}
    given = {"phase_rad": [own.phase for own in ELBOW.sun]}
    shoulder, elbow = (
        geared(
            sun_teeth=sun,
            planet_teeth=planet,
            ring_teeth=stage.ring_teeth,
            planet_count=len(stage.sun),
            sun_mesh={**mesh_data(stage.sun), **at_sun},
            ring_mesh={**mesh_data(stage.ring), **at_ring},
        )
        for sun, planet, stage, at_sun, at_ring in (
            (28, 32, SHOULDER, {}, ratios),
            (31, 31, ELBOW, given, {}),
        )
    )
    return arm_of(shoulder, elbow, gravity=(0.0, 0.0))


def mesh_data(teeth: tuple[Teeth, ...]) -> Data:
    return {
        "stiffness": [LAWS[own.law] for own in teeth],
        "backlash_m": [own.backlash for own in teeth],
        "tooth_error_m": [own.error for own in teeth],
        "tooth_error_phase_rad": [own.error_phase for own in teeth],
        "static_error_m": [own.static for own in teeth],
        "phase_rad": "from-teeth",
        "damping_N_s_per_m": [len(teeth) * own.damping for own in teeth],
    }


class Spot(NamedTuple):
    """A mesh in a state: x and x' [m, m/s], its phase [rad], and the places in q that make x.

    x is what the first of them is ahead, and what the others are not.
    """

    teeth: Teeth
    x: float
    x_dot: float
    phase: float
    places: tuple[int, ...]

    @property
    def travel(self) -> float:
        """Eq. 5 [m]."""
        own = self.teeth
        gap = self.x - own.static - own.error * float(np.sin(self.phase + own.error_phase))
        return float(np.sign(gap) * max(abs(gap) - own.backlash, 0))

    @property
    def stiffness(self) -> float:
        return stiffness(self.teeth.law, self.phase)

    @property
    def force(self) -> float:
        """Of the spring [N]."""
        return self.stiffness * self.travel


def spots(q: np.ndarray, v: np.ndarray) -> Iterator[Spot]:
    """Every mesh of ``unlike_arm``, joint by joint, of each planet the sun's and the ring's."""
    first = 0
    for stage, theta in zip(STAGES, ANGLES, strict=True):
        turned = stage.ring_teeth * q[theta]
        for n, (sun, ring) in enumerate(zip(stage.sun, stage.ring, strict=True), first + 1):
            x_sp, rate = q[first] - q[n], v[first] - v[n]
            yield Spot(sun, x_sp, rate, turned + sun.phase, (first, n))
            yield Spot(ring, q[n], v[n], turned + ring.phase, (n,))
        first += 1 + len(stage.sun)


def tooth_forces(q: np.ndarray, v: np.ndarray, damping: str = "always") -> np.ndarray:
    """What springs and dampers do to every coordinate; nothing to the angles."""
    forces = np.zeros(len(q))
    for spot in spots(q, v):
        damps = damping == "always" or spot.travel != 0
        force = spot.force + damps * spot.teeth.damping * spot.x_dot
        forces[spot.places[0]] -= force
        forces[list(spot.places[1:])] += force
    return forces


def spring_energy(q: np.ndarray) -> float:
    """k f^2 / 2 of all teeth [J]."""
    return sum(spot.stiffness * spot.travel**2 / 2 for spot in spots(q, 0 * q))


def first_touch() -> np.ndarray:
    """q at which every ring mesh touches, and the first of each sun's."""
    q = np.zeros(ANGLES[-1] + 1)
    first = 0
    for stage in STAGES:
        after = first + 1 + len(stage.sun)
        on_ring = np.array([own.backlash + own.static for own in stage.ring])
        on_sun = [own.backlash + own.static for own in stage.sun]
        q[first + 1 : after] = on_ring
        q[first] = min(on_ring + on_sun)
        first = after
    return q


def states_in(run: xr.Dataset) -> np.ndarray:
    """q of every record (times, n), by each stage's first planet where the sun is concerned."""
    x_sp, x_pr, theta = (run[name].values for name in ("x_sp", "x_pr", "theta"))
    columns = []
    for joint, stage in enumerate(STAGES):
        own = x_pr[:, joint, : len(stage.ring)]
        columns += [x_sp[:, joint, :1] + own[:, :1], own]
    return np.hstack([*columns, theta])


def recorded_forces(q: np.ndarray) -> np.ndarray:
    """F_sp and F_pr [N], (2, joints, planets), where a trajectory has them; NaN elsewhere."""
    forces = np.full((2, len(STAGES), max(len(stage.sun) for stage in STAGES)), np.nan)
    found = iter(spots(q, 0 * q))
    for joint, stage in enumerate(STAGES):
        for planet in range(len(stage.sun)):
            forces[:, joint, planet] = next(found).force, next(found).force
    return forces


def energy_slopes(q: np.ndarray) -> np.ndarray:
    """Derivatives of ``spring_energy`` by differences of fourth order."""
    slopes = np.empty(len(q))
    for place in range(len(q)):
        size = 1e-5 if place in ANGLES else 1e-9
        step = size * np.eye(len(q))[place]
        near, far = (
            (spring_energy(q + n * step) - spring_energy(q - n * step)) / (2 * n * size)
            for n in (1, 2)
        )
        slopes[place] = (4 * near - far) / 3
    return slopes
