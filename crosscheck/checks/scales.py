"""Sizes that an arm and its drive give to what is compared, of which differences are parts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.first_principles import composite
from crosscheck.findings import Finding, Subject, make_check
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.gears import PlanetaryGears, PlanetaryStage
from crosscheck.models.arm.layout import MESHES, Layout, Meaning
from crosscheck.models.arm.mesh import PlanetMesh
from crosscheck.models.arm.stiffness import (
    FourierStiffness,
    SineStiffness,
    SquareStiffness,
    StiffnessLaw,
    TableStiffness,
)
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.experiment.scenario import (
    Scenario,
    SinusoidDrive,
    TableDrive,
    expand_to_joints,
)

EPS = float(np.finfo(float).eps)
LOOSEST = 1e-10  # relative tolerance of numbers at states that no rounding excuses
# How far and fast random states go; what is compared there is measured against its own size.
LEAST_PLAY_M, SLIDING_M_PER_S, TURNING_RAD_PER_S = 2e-5, 0.1, 3.0
# What an uncertainty must stay below to mean something, and where there is no play to compare with.
OF_TRAVEL, OF_LOST_MOTION, OF_SIZE = 0.01, 0.001, 0.01
WITHOUT_GEARS_RAD = 1e-6
# Of a mesh's displacement that is read from places: those of planet, wheel and carrier round.
PLACE_ROUNDINGS = 3


class ReasonedLimit(NamedTuple):
    """A limit with the reason for it."""

    value: float
    basis: str


def geared_joints(arm: Arm) -> list[tuple[int, Planetary]]:
    """The joints with gears, by number from 0."""
    return [(n, joint) for n, joint in enumerate(arm.joints) if isinstance(joint, Planetary)]


def gear_arc(arm: Arm) -> float:
    """Arc of the largest ring per radian [m]: displacements are differences of such arcs."""
    return max((j.module_m * j.ring_teeth / 2 for _, j in geared_joints(arm)), default=0.0)


def arm_reach(arm: Arm) -> float:
    """Length of the arm stretched out [m], of which the places of its bodies have roundings."""
    return sum(link.length_m for link in arm.links)


def largest_stiffness(arm: Arm) -> float:
    """Upper bound of the stiffness of any mesh at any phase [N/m]."""
    return max((_joint_stiffness_bound(joint) for _, joint in geared_joints(arm)), default=0.0)


def meshes(joint: Planetary) -> list[PlanetMesh]:
    """The meshes of every planet, with the sun and with the ring in turn."""
    planets, sides = range(joint.planet_count), (joint.sun_mesh, joint.ring_mesh)
    return [side.planet_mesh(planet) for planet in planets for side in sides]


def largest_displacement(arm: Arm) -> float:
    """Largest mesh displacement of random states [m]: teeth on either flank or out of contact."""
    contacts = [mesh for _, joint in geared_joints(arm) for mesh in meshes(joint)]
    clearance = max((mesh.backlash_m for mesh in contacts), default=0.0)
    offset = max((abs(mesh.static_error_m) for mesh in contacts), default=0.0)
    return 3 * max(clearance, LEAST_PLAY_M) + offset


def _joint_stiffness_bound(joint: Planetary) -> float:
    """Upper bound of the stiffness of a joint's stiffest mesh [N/m]."""
    return max(stiffness_bound(mesh.stiffness) for mesh in meshes(joint))


def stiffness_bound(law: StiffnessLaw) -> float:
    """Upper bound of a law's stiffness [N/m]."""
    if isinstance(law, SineStiffness):
        return law.mean_N_per_m + law.amplitude_N_per_m
    if isinstance(law, FourierStiffness):
        waves = (*law.cosine_N_per_m, *law.sine_N_per_m)
        return law.mean_N_per_m + sum(map(abs, waves))
    if isinstance(law, SquareStiffness):  # the series overshoots by a fifth of the swing at most
        return law.largest_N_per_m + 0.2 * (law.largest_N_per_m - law.least_N_per_m)
    return max(law.stiffness_N_per_m)


def mean_stiffness(law: StiffnessLaw) -> float:
    """Mean of a stiffness law over a period of the mesh [N/m]."""
    if isinstance(law, TableStiffness):
        from scipy.interpolate import CubicSpline  # a third of a second, for tables alone

        spline = CubicSpline(law.phase_cycles, law.stiffness_N_per_m, bc_type="periodic")
        return float(spline.integrate(0, 1))
    if isinstance(law, SquareStiffness):
        share = law.contact_ratio - 1
        return law.least_N_per_m * (1 - share) + law.largest_N_per_m * share
    return law.mean_N_per_m


def equivalent_mass(joint: PlanetaryGears, gear: Literal["sun", "planet"]) -> float:
    """Equivalent mass of a gear, J / r^2 [kg], r its base radius."""
    sun = gear == "sun"
    mass = joint.sun_equivalent_mass_kg if sun else joint.planet_equivalent_mass_kg
    inertia = joint.sun_inertia_kg_m2 if sun else joint.planet_inertia_kg_m2
    teeth = joint.sun_teeth if sun else joint.planet_teeth
    return mass if mass is not None else (inertia or 0.0) / base_radius(joint, teeth) ** 2


def mesh_damping(joint: PlanetaryStage, name: Meaning, planet: int) -> float:
    """Damping of one planet's mesh [N s/m]: an N-th of that of N equal planets."""
    sun = name == MESHES[0]
    side, count = joint.sun_mesh if sun else joint.ring_mesh, joint.planet_count
    mesh = side.planet_mesh(planet)
    if mesh.damping_N_s_per_m is not None:
        return mesh.damping_N_s_per_m / count
    mass = equivalent_mass(joint, "sun") if sun else count * equivalent_mass(joint, "planet")
    ratio = mesh.damping_ratio or 0.0
    return 2 * ratio * float(np.sqrt(count * mean_stiffness(mesh.stiffness) * mass)) / count


def largest_torques(arm: Arm, scenario: Scenario) -> np.ndarray:
    """Largest torque of the drive plus moment of weight, of every joint [N m], (joints,)."""
    joints, law = len(arm.joints), scenario.drive
    drive = drive_data(scenario, joints)
    if isinstance(law, SinusoidDrive):
        torques = drive.gains[:, 0]
    elif isinstance(law, TableDrive):
        torques = np.abs(drive.table_torque).max(axis=1)
    else:  # a controller asks the most where it starts
        start = np.array([expand_to_joints(scenario.start.theta_rad, joints)])
        torques = torques_along(drive, np.zeros(1), start, 0 * start)[0]
    return np.abs(torques) + largest_weights(arm)


def find_parts(arm: Arm) -> tuple[composite.Content, list[composite.CompositePart]]:
    """The fields of an arm, and all its bodies."""
    content = arm.model_dump()
    return content, composite.build_parts(content)


def weight_moments(arm: Arm, theta: np.ndarray) -> np.ndarray:
    """Moment of weight [N m] about every joint's axis, (joints,), at relative angles theta."""
    content, parts = find_parts(arm)
    return composite.weight(parts, composite.arm_pose(content, theta), content)


def largest_weights(arm: Arm) -> np.ndarray:
    """Bound of the moments of weight about the joints [N m], (joints,): the arm lies across it."""
    pull = math.hypot(*arm.gravity_m_per_s2)
    across = arm.model_copy(update={"gravity_m_per_s2": (0.0, pull)})
    return weight_moments(across, np.zeros(len(arm.joints)))


def mesh_travels(arm: Arm, scenario: Scenario) -> Iterator[tuple[Planetary, float]]:
    """Each geared joint, and how far its mesh moves [m]: half the backlash, or what bends it."""
    torques = largest_torques(arm, scenario)
    for number, joint in geared_joints(arm):
        force = torques[number] / motor_lever(joint)
        stiffness = joint.planet_count * _joint_stiffness_bound(joint)
        play = max(mesh.backlash_m for mesh in meshes(joint))
        yield joint, max(play, force / stiffness)


def base_radius(joint: PlanetaryGears, teeth: int) -> float:
    """Base radius of a wheel of the joint [m]."""
    return joint.module_m * teeth / 2 * math.cos(math.radians(joint.pressure_angle_deg))


def motor_lever(joint: PlanetaryGears) -> float:
    """Torque on the output side over the force on the sun's teeth [m]: its radius by the ratio."""
    return base_radius(joint, joint.sun_teeth) * (1 + joint.ring_teeth / joint.sun_teeth)


def sun_advance(layout: Layout, joint: int) -> np.ndarray:
    """Row (n,) that gives x_sp + x_pr of a joint, counted from 0; the same for each planet."""
    x_sp, x_pr = (layout.displacement(mesh, joint, 0) for mesh in MESHES)
    return x_sp + x_pr


def motor_forces(arm: Arm, layout: Layout, torques: np.ndarray) -> np.ndarray:
    """Forces of motors on the displacements of a geared model [N], (states, n).

    torques (states, joints): on the output side [N m]. Each turns a sun, which x_sp + x_pr of any
    planet advance, and so enters as T / (n r_s) (Eq. 22).
    """
    forces = np.zeros((len(torques), len(layout)))
    for number, joint in geared_joints(arm) if layout.mesh_joints else ():
        forces += torques[:, number, None] / motor_lever(joint) * sun_advance(layout, number)
    return forces


def acceptance_limit(quantity: str, arm: Arm, scenario: Scenario, size: float) -> ReasonedLimit:
    """The acceptance limit of an uncertainty; size: the quantity's in its run."""
    if quantity in ("x_sp", "x_pr"):
        travel = min(travel for _, travel in mesh_travels(arm, scenario))
        return ReasonedLimit(OF_TRAVEL * travel, f"a hundredth of a mesh's travel, {travel:.2g} m")
    if quantity != "theta":
        return ReasonedLimit(OF_SIZE * size, f"a hundredth of its largest value, {size:.3g}")
    travels = mesh_travels(arm, scenario)
    lost = [2 * travel / base_radius(j, j.sun_teeth + j.planet_teeth) for j, travel in travels]
    if not lost:
        return ReasonedLimit(WITHOUT_GEARS_RAD, "a millionth of a radian")
    least = min(lost)
    basis = f"a thousandth of a joint's lost motion, {least:.2g} rad"
    return ReasonedLimit(OF_LOST_MOTION * least, basis)


def rounding(arm: Arm) -> float:
    """Rounding of a mesh displacement [m], which engines read from gears' arcs of a radian."""
    return EPS * gear_arc(arm)


def share_of(difference: np.ndarray, size: np.ndarray) -> float:
    """The largest part of its size that a difference is, 1e300 at most.

    0 for none; no number where a value is none, or two runs diverged; that one did is huge.
    """
    difference = np.abs(difference)
    with np.errstate(invalid="ignore"):
        parts = np.where(difference == 0, 0.0, difference / np.maximum(size, 1e-300))
    return float(np.minimum(parts, 1e300).max(initial=0.0))


def check_share(about: Subject, measured: float, tolerance: float, basis: str) -> Finding:
    """The Finding of a difference that is a part of a size."""
    return make_check(about, measured=measured, tolerance=tolerance, basis=basis, relative=measured)
