"""The numbers of the Exudyn tree's meshes, planet by planet, out of the arm's.

(Eq. n) refers to the paper the arm is taken from.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from crosscheck.models.arm.gears import PlanetaryGears, PlanetaryStage
from crosscheck.models.arm.mesh import PlanetMesh
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.exudyn.tree.mesh import MeshLaw
from crosscheck.models.exudyn.tree.stiffness import build_curve, constant_curve
from crosscheck.models.exudyn.tree.wheels import base_radius, equivalent_mass

Side = Literal["sun", "ring"]


def build_mesh_law(joint: PlanetaryStage, chosen: Switches, side: Side, planet: int) -> MeshLaw:
    """The law of the mesh of a planet, counted from 0, with sun or ring."""
    sun = side == "sun"
    mesh = (joint.sun_mesh if sun else joint.ring_mesh).planet_mesh(planet)
    planet_radius, curve = base_radius(joint, joint.planet_teeth), build_curve(mesh.stiffness)
    return MeshLaw(
        wheel_radius=base_radius(joint, joint.sun_teeth if sun else joint.ring_teeth),
        planet_radius=planet_radius if sun else -planet_radius,
        backlash=mesh.backlash_m,
        damping=_damping(joint, side, mesh, curve.mean),
        sharpness=mesh.tanh_sharpness_per_m,
        smooth=float(chosen.dead_zone == "tanh"),
        damped_in_contact_only=float(chosen.damping == "contact"),
        tooth_error=mesh.tooth_error_m,
        error_phase=mesh.tooth_error_phase_rad,
        static_error=mesh.static_error_m,
        phase_rate=_phase_rate(joint, chosen, side),
        phase_offset=_phase_offset(joint, side, planet, mesh.phase_rad),
        clock_phase=float(chosen.phase == "omega_t"),
        curve=curve,
    )


def bounding_law(law: MeshLaw) -> MeshLaw:
    """The linear law that bounds this one: in contact everywhere, at its largest stiffness."""
    return _linear_law(law, law.curve.largest_stiffness)


def mean_spring(law: MeshLaw) -> MeshLaw:
    """The law's mean stiffness alone: in contact everywhere, undamped."""
    return _linear_law(law, law.curve.mean)._replace(damping=0.0)


def _linear_law(law: MeshLaw, stiffness: float) -> MeshLaw:
    return law._replace(
        curve=constant_curve(stiffness),
        tooth_error=0.0,
        backlash=0.0,
        smooth=0.0,
        damped_in_contact_only=0.0,
    )


def _damping(joint: PlanetaryStage, side: Side, mesh: PlanetMesh, stiffness: float) -> float:
    """Damping [N s/m] of one mesh: 1/N of 2 zeta sqrt(N k_m * mass), or of what is given."""
    planets = joint.planet_count
    if mesh.damping_N_s_per_m is not None:
        return mesh.damping_N_s_per_m / planets
    assert mesh.damping_ratio is not None
    sun_mass, planet_mass = equivalent_mass(joint, "sun"), equivalent_mass(joint, "planet")
    mass = sun_mass if side == "sun" else planets * planet_mass
    return 2 * mesh.damping_ratio * float(np.sqrt(planets * stiffness * mass)) / planets


def _phase_rate(joint: PlanetaryGears, chosen: Switches, side: Side) -> float:
    """Teeth passing one planet per radian of the carrier: z_r on both sides, but for Eq. 13."""
    if side == "sun" or chosen.ring_rate == "corrected":
        return float(joint.ring_teeth)
    planet = base_radius(joint, joint.planet_teeth)
    carrier = base_radius(joint, joint.sun_teeth + joint.planet_teeth)  # r_c cos(alpha)
    return joint.planet_teeth * (carrier / planet - 1)


def _phase_offset(joint: PlanetaryStage, side: Side, planet: int, given: float | None) -> float:
    """Constant part of a mesh's phase [rad]: as given, or as the teeth say."""
    if given is not None:
        return given
    turn = 2 * np.pi * pitch_offset(joint, side, planet)
    if side == "ring":
        turn += joint.sun_mesh.planet_mesh(0).phase_rad or 0.0
    return float(turn % (2 * np.pi))


def pitch_offset(joint: PlanetaryGears, side: Side, planet: int) -> float:
    """Part of a pitch, 0 to 1, by which a planet's mesh is ahead of the first planet's sun mesh.

    On its way round the ring a planet passes z_r teeth per turn forwards, and those of the sun,
    which overtakes it, backwards: so many it has passed more that stands n / N of a turn further.
    From the planet's flank at the sun to that at the ring are z_p / 2 - 1/2 pitches, half a turn
    but for the tooth's own thickness. Counted in whole 2N-ths of a pitch, so without rounding.
    """
    parts = 2 * joint.planet_count
    if side == "sun":
        return -2 * joint.sun_teeth * planet % parts / parts
    across = (joint.planet_teeth - 1) * joint.planet_count
    return (2 * joint.ring_teeth * planet + across) % parts / parts
