"""The gears of an arm as flat arrays for the compiled kernel."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from analytic.kinematics import stage_geometry
from analytic.mesh_force import EXACT, TANH
from analytic.mesh_frequency import ANGLE, OMEGA_T, ring_mesh_rate, sun_mesh_rate
from analytic.stage import equivalent_masses
from analytic.stiffness import StiffnessData, mean_stiffness, stiffness_data
from models.arm import Arm, Mesh, Planetary
from models.layout import Layout
from models.switches import Switches


class Gears(NamedTuple):
    """Per mesh, in the order sun-planet 1, planet-ring 1, sun-planet 2, ...; SI units.

    where: index of the mesh displacement in q; theta: index of its joint's angle; k_m: mean
    stiffness; k_a: amplitude of Eq. 8, 0 where another law holds; law: the others, see
    analytic.stiffness; E, b, sigma: Eqs. 5, 6, 14; rate, offset: phase per joint angle, and its
    constant; d: damping of all planets together. phase, dead_zone: law codes; damps_apart: whether
    dampers act out of contact.
    """

    where: np.ndarray
    theta: np.ndarray
    k_m: np.ndarray
    k_a: np.ndarray
    law: StiffnessData
    E: np.ndarray
    b: np.ndarray
    sigma: np.ndarray
    rate: np.ndarray
    offset: np.ndarray
    d: np.ndarray
    phase: int
    dead_zone: int
    damps_apart: bool


class StageMesh(NamedTuple):
    """A mesh, its joint (from 0) and place in q, its rate and the damping of all planets."""

    mesh: Mesh
    joint: int
    where: int
    rate: float
    damping: float


def gears(arm: Arm, layout: Layout, switches: Switches) -> Gears:
    """The meshes that have coordinates in the layout: all of the arm, or none of a rigid one."""
    meshes = [
        mesh
        for number in layout.meshing
        for mesh in _meshes_of(arm.joints[number], number, layout, switches)
    ]

    def each(values: Iterable[float]) -> np.ndarray:
        return np.array(list(values), dtype=float)

    return Gears(
        where=np.array([mesh.where for mesh in meshes], dtype=np.int64),
        theta=np.array([layout.theta[mesh.joint] for mesh in meshes], dtype=np.int64),
        k_m=each(mean_stiffness(entry.mesh.stiffness) for entry in meshes),
        k_a=each(_amplitude(entry.mesh) for entry in meshes),
        law=stiffness_data([entry.mesh.stiffness for entry in meshes]),
        E=each(entry.mesh.tooth_error_m for entry in meshes),
        b=each(entry.mesh.backlash_m for entry in meshes),
        sigma=each(entry.mesh.tanh_sharpness_per_m for entry in meshes),
        rate=each(entry.rate for entry in meshes),
        offset=each(entry.mesh.phase_rad for entry in meshes),
        d=each(entry.damping for entry in meshes),
        phase=OMEGA_T if switches.phase == "omega_t" else ANGLE,
        dead_zone=TANH if switches.dead_zone == "tanh" else EXACT,
        damps_apart=switches.damping == "always",
    )


def _meshes_of(joint: object, number: int, layout: Layout, switches: Switches) -> list[StageMesh]:
    assert isinstance(joint, Planetary)  # as joints with mesh displacements are
    geometry = stage_geometry(joint)
    rates = sun_mesh_rate(joint, geometry), ring_mesh_rate(joint, geometry, switches.ring_rate)
    sun, ring = damping(joint)
    return [
        StageMesh(joint.sun_mesh, number, layout.at("x_sp", number), rates[0], sun),
        StageMesh(joint.ring_mesh, number, layout.at("x_pr", number), rates[1], ring),
    ]


def _amplitude(mesh: Mesh) -> float:
    law = mesh.stiffness
    return law.amplitude_N_per_m if law.law == "sine" else 0.0


def damping(joint: Planetary) -> tuple[float, float]:
    """(d_sp, d_pr) [N s/m], all planets together: the diagonal of D that the paper leaves open.

    From the damping ratio of each mesh against its own equivalent mass, where not given directly.
    """
    sun, planet, _ = equivalent_masses(joint)
    masses = sun, joint.planet_count * planet
    d_sp, d_pr = (
        _damping(mesh, joint.planet_count, mass)
        for mesh, mass in zip((joint.sun_mesh, joint.ring_mesh), masses, strict=True)
    )
    return d_sp, d_pr


def _damping(mesh: Mesh, planets: int, mass: float) -> float:
    if mesh.damping_N_s_per_m is not None:
        return mesh.damping_N_s_per_m
    assert mesh.damping_ratio is not None  # the arm's own validation
    stiffness = planets * mean_stiffness(mesh.stiffness)
    return 2 * mesh.damping_ratio * math.sqrt(stiffness * mass)
