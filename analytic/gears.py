"""The gears of an arm as flat arrays for the compiled kernel."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from analytic.kinematics import stage_geometry
from analytic.mesh_force import EXACT, TANH
from analytic.mesh_frequency import ANGLE, OMEGA_T, ring_mesh_rate, sun_mesh_rate
from models.arm import Arm, Joint
from models.switches import Switches


class Gears(NamedTuple):
    """Per mesh, in the order sun-planet 1, planet-ring 1, sun-planet 2, ...; SI units.

    where: index of the mesh displacement in q; theta: index of its joint's angle; k_m, k_a, E, b,
    sigma: Eqs. 5, 6, 8, 14; rate, offset: phase per joint angle, and its constant; d: damping of
    all planets together. phase, dead_zone: law codes; damps_apart: whether dampers act out of
    contact.
    """

    where: np.ndarray
    theta: np.ndarray
    k_m: np.ndarray
    k_a: np.ndarray
    E: np.ndarray
    b: np.ndarray
    sigma: np.ndarray
    rate: np.ndarray
    offset: np.ndarray
    d: np.ndarray
    phase: int
    dead_zone: int
    damps_apart: bool


def no_gears() -> Gears:
    """A rigid arm: no mesh."""
    nowhere, none = np.zeros(0, dtype=np.int64), np.zeros(0)
    return Gears(
        nowhere, nowhere, none, none, none, none, none, none, none, none, ANGLE, EXACT, True
    )


def gears(arm: Arm, switches: Switches) -> Gears:
    """The meshes of a geared arm in the paper's coordinates."""
    meshes = range(2 * len(arm.joints))
    twice = [joint for joint in arm.joints for _ in range(2)]

    def each(values: Iterable[float]) -> np.ndarray:
        return np.array(list(values), dtype=float)

    return Gears(
        where=np.array([mesh + mesh // 2 for mesh in meshes], dtype=np.int64),
        theta=np.array([3 * (mesh // 2) + 2 for mesh in meshes], dtype=np.int64),
        k_m=each(joint.mesh_stiffness_N_per_m for joint in twice),
        k_a=each(joint.mesh_stiffness_amplitude_N_per_m for joint in twice),
        E=each(joint.tooth_error_m for joint in twice),
        b=each(joint.backlash_m for joint in twice),
        sigma=each(joint.tanh_sharpness_per_m for joint in twice),
        rate=each(rate for joint in arm.joints for rate in _rates(joint, switches)),
        offset=each(o for joint in arm.joints for o in (0.0, joint.ring_mesh_phase_rad)),
        d=each(d for joint in arm.joints for d in damping(joint)),
        phase=OMEGA_T if switches.phase == "omega_t" else ANGLE,
        dead_zone=TANH if switches.dead_zone == "tanh" else EXACT,
        damps_apart=switches.damping == "always",
    )


def _rates(joint: Joint, switches: Switches) -> tuple[float, float]:
    geometry = stage_geometry(joint)
    return (
        sun_mesh_rate(joint, geometry),
        ring_mesh_rate(joint, geometry, switches.ring_rate),
    )


def damping(joint: Joint) -> tuple[float, float]:
    """(d_sp, d_pr) [N s/m], all planets together: the diagonal of D that the paper leaves open.

    From the damping ratio of each mesh against its own equivalent mass, where not given directly.
    """
    direct = (joint.sun_planet_damping_N_s_per_m, joint.planet_ring_damping_N_s_per_m)
    if direct[0] is not None and direct[1] is not None:
        return direct[0], direct[1]
    assert joint.damping_ratio is not None  # the arm's own validation
    planets = joint.planet_count
    stiffness = planets * joint.mesh_stiffness_N_per_m
    return (
        2 * joint.damping_ratio * math.sqrt(stiffness * joint.sun_equivalent_mass_kg),
        2 * joint.damping_ratio * math.sqrt(stiffness * planets * joint.planet_equivalent_mass_kg),
    )
