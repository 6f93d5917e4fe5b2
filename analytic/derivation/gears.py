"""The gears of an arm as flat arrays for the compiled kernel."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.derivation.stage import gear_masses
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.analytic.paper.mesh_force import EXACT, TANH
from crosscheck.analytic.paper.mesh_frequency import (
    ANGLE,
    OMEGA_T,
    mesh_phases,
    ring_mesh_rate,
    sun_mesh_rate,
)
from crosscheck.analytic.paper.stiffness import StiffnessData, mean_stiffness, stiffness_data
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.gears import PlanetaryStage
from crosscheck.models.arm.layout import Layout
from crosscheck.models.arm.mesh import PlanetMesh
from crosscheck.models.experiment.scenario import Switches

NO_COORDINATE = -1  # number in place of a coordinate


class Gears(NamedTuple):
    """Numbers per mesh, in the order sun-planet 1, planet-ring 1, sun-planet 2, ...; SI units.

    Lumped, a stage has two meshes, each of ``planets`` planets; free, two for every planet.
    x_index: index of the mesh displacement in q, or of x_s, of which the coordinate at
    ``subtract_index`` (-1: none) is taken away; theta: index of its joint's angle; k_m: mean
    stiffness; k_a: amplitude of Eq. 8, 0 where another law holds; law: the others, see
    analytic.paper.stiffness; E, lead, static_error: of the tooth error, see
    analytic.paper.mesh_force; b, sigma: Eqs. 5, 6; rate, offset: phase per joint angle, and its
    constant; d: damping of those planets together. phase, dead_zone: codes; damps_without_contact:
    whether dampers act out of contact; conservative: whether the potentials act on the joint
    angles.
    """

    x_index: np.ndarray
    subtract_index: np.ndarray
    planets: np.ndarray
    theta: np.ndarray
    k_m: np.ndarray
    k_a: np.ndarray
    law: StiffnessData
    E: np.ndarray
    error_phase: np.ndarray
    static_error: np.ndarray
    b: np.ndarray
    sigma: np.ndarray
    rate: np.ndarray
    offset: np.ndarray
    d: np.ndarray
    phase: int
    dead_zone: int
    damps_without_contact: bool
    conservative: bool


class StageMesh(NamedTuple):
    """A mesh, its joint (from 0), places in q, planets, phase rate and constant, and damping."""

    mesh: PlanetMesh
    joint: int
    x_index: int
    subtract_index: int
    planets: int
    rate: float
    offset: float
    damping: float


class PlacedStage(NamedTuple):
    """A stage, its joint (from 0), and where its coordinates begin in q.

    These are x_sp and x_pr, or of free planets x_s and every x_pr.
    """

    gears: PlanetaryStage
    joint: int
    first: int
    is_free: bool


def build_gears(arm: Arm, layout: Layout, switches: Switches) -> Gears:
    """The meshes that have coordinates in the layout: all of the arm, or none of a rigid one."""
    stages = [
        PlacedStage(joint, number, layout.at("x_s" if layout.free else "x_sp", number), layout.free)
        for number, joint in enumerate(arm.joints)
        if isinstance(joint, Planetary) and number in layout.mesh_joints
    ]
    return gather_gears(stages, layout.theta.tolist(), switches)


def gather_gears(stages: Sequence[PlacedStage], theta: Sequence[int], switches: Switches) -> Gears:
    """The arrays of these stages' meshes; theta: places of the joints' angles in q."""
    meshes = [mesh for stage in stages for mesh in _list_meshes(stage, switches)]
    floats, integers = partial(np.fromiter, dtype=float), partial(np.fromiter, dtype=np.int64)
    return Gears(
        x_index=integers(entry.x_index for entry in meshes),
        subtract_index=integers(entry.subtract_index for entry in meshes),
        planets=floats(entry.planets for entry in meshes),
        theta=integers(theta[entry.joint] for entry in meshes),
        k_m=floats(mean_stiffness(entry.mesh.stiffness) for entry in meshes),
        k_a=floats(amplitude(entry.mesh) for entry in meshes),
        law=stiffness_data([entry.mesh.stiffness for entry in meshes]),
        E=floats(entry.mesh.tooth_error_m for entry in meshes),
        error_phase=floats(entry.mesh.tooth_error_phase_rad for entry in meshes),
        static_error=floats(entry.mesh.static_error_m for entry in meshes),
        b=floats(entry.mesh.backlash_m for entry in meshes),
        sigma=floats(entry.mesh.tanh_sharpness_per_m for entry in meshes),
        rate=floats(entry.rate for entry in meshes),
        offset=floats(entry.offset for entry in meshes),
        d=floats(entry.damping for entry in meshes),
        phase=OMEGA_T if switches.phase == "omega_t" else ANGLE,
        dead_zone=TANH if switches.dead_zone == "tanh" else EXACT,
        damps_without_contact=switches.damping == "always",
        conservative=switches.mesh_work == "conservative",
    )


def displacement_rows(gears: Gears, n: int) -> np.ndarray:
    """Every mesh's displacement by the n coordinates, (meshes, n)."""
    rows, number = np.zeros((gears.x_index.size, n)), np.arange(gears.x_index.size)
    rows[number, gears.x_index] = 1.0
    of_two = gears.subtract_index >= 0
    rows[number[of_two], gears.subtract_index[of_two]] = -1.0
    return rows


def _list_meshes(placed: PlacedStage, switches: Switches) -> Iterator[StageMesh]:
    """Sun and ring mesh of a stage's planets together, or planet after planet."""
    stage, joint, first, is_free = placed
    geometry, count = stage_geometry(stage), stage.planet_count
    rates = sun_mesh_rate(stage, geometry), ring_mesh_rate(stage, geometry, switches.ring_rate)
    for planet in range(count if is_free else 1):
        x_pr = first + 1 + planet
        sides = (
            (stage.sun_mesh.planet_mesh(planet), stage.ring_mesh.planet_mesh(planet)),
            ((first, x_pr if is_free else NO_COORDINATE), (x_pr, NO_COORDINATE)),
            rates,
            mesh_phases(stage, planet),
            damping(stage, planet),
        )
        for mesh, places, rate, gamma, of_all in zip(*sides, strict=True):
            planets, d = (1, of_all / count) if is_free else (count, of_all)
            yield StageMesh(mesh, joint, *places, planets, rate, gamma, d)


def amplitude(mesh: PlanetMesh) -> float:
    """Amplitude k_a [N/m] of Eq. 8; 0 of other laws."""
    law = mesh.stiffness
    return law.amplitude_N_per_m if law.law == "sine" else 0.0


def damping(joint: PlanetaryStage, planet: int = 0) -> tuple[float, float]:
    """Damping (d_sp, d_pr) [N s/m] of N planets like this one: D, which the paper leaves open.

    From the damping ratio of each mesh against its own equivalent mass, where not given directly.
    """
    sun_mass, planet_mass = gear_masses(joint)
    masses = sun_mass, joint.planet_count * planet_mass
    meshes = joint.sun_mesh.planet_mesh(planet), joint.ring_mesh.planet_mesh(planet)
    d_sp, d_pr = (
        _damping(mesh, joint.planet_count, mass) for mesh, mass in zip(meshes, masses, strict=True)
    )
    return d_sp, d_pr


def _damping(mesh: PlanetMesh, planets: int, mass: float) -> float:
    if mesh.damping_N_s_per_m is not None:
        return mesh.damping_N_s_per_m
    assert mesh.damping_ratio is not None  # the arm's own validation
    stiffness = planets * mean_stiffness(mesh.stiffness)
    return 2 * mesh.damping_ratio * math.sqrt(stiffness * mass)
