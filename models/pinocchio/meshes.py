"""The tooth contacts of Pinocchio's gear tree as numbers, each planet's from its own mesh."""

from __future__ import annotations

from collections.abc import Iterable
from math import cos, pi, radians, sin, sqrt, tau
from typing import NamedTuple

import numpy as np

from crosscheck.models.arm.gears import PlanetaryGears, PlanetaryStage
from crosscheck.models.arm.mesh import PlanetMesh
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.pinocchio.stiffness import build_curve, build_mesh_stiffness
from crosscheck.models.pinocchio.tree import TreeStage, base_radii, equivalent_masses

BODIES = ("central", "planet", "link")  # those fields of Meshes that are no numbers but bodies


class Contact(NamedTuple):
    """The contact of a planet of a joint with its sun (side +1) or its ring (side -1).

    ``planet`` is its body, ``place`` [rad] where that sits on the carrier, from the first planet's.
    """

    joint: PlanetaryStage
    stage: TreeStage
    planet: int
    place: float
    side: int
    mesh: PlanetMesh

    @property
    def external(self) -> bool:
        """Whether the contact is the sun's."""
        return self.side > 0


class Engagement(NamedTuple):
    """How the teeth of all meshes stand in a state, each of shape (meshes,).

    ``gap`` [m] is x - e, ``reach`` [m] what of it lies beyond the backlash.
    """

    phase: np.ndarray
    gap: np.ndarray
    stiffness: np.ndarray
    reach: np.ndarray


class Meshes(NamedTuple):
    """All meshes of the arm, as columns of shape (meshes,), each of a planet and a central gear.

    ``side`` is +1 where the central gear is the sun (external mesh), -1 where it is the ring.
    ``central`` is the body that carries the central gear's teeth. Radii [m] are base radii.
    """

    side: np.ndarray
    central: np.ndarray
    planet: np.ndarray
    link: np.ndarray
    central_radius: np.ndarray
    planet_radius: np.ndarray
    pitch: np.ndarray  # pitch point over centre distance, from the central gear
    cosine: np.ndarray  # of the pressure angle
    sine: np.ndarray
    rate: np.ndarray  # mesh phase over joint angle
    phase: np.ndarray
    error: np.ndarray
    error_phase: np.ndarray
    static_error: np.ndarray
    backlash: np.ndarray
    sharpness: np.ndarray
    damping: np.ndarray


class MeshForces:
    """What the teeth of all contacts exert, from their phases and how far they came together."""

    def __init__(self, contacts: list[Contact], chosen: Switches) -> None:
        self.meshes = build_meshes(contacts, chosen)
        self._stiffness = build_mesh_stiffness([contact.mesh.stiffness for contact in contacts])
        self._switches = chosen

    def engage(self, phase: np.ndarray, x: np.ndarray) -> Engagement:
        """Engagement of the teeth, their error e = static error + E sin(phi + error phase)."""
        mesh = self.meshes
        gap = x - mesh.static_error - mesh.error * np.sin(phase + mesh.error_phase)
        law = _exact_dead_zone if self._switches.dead_zone == "exact" else _tanh_dead_zone
        return Engagement(phase, gap, self._stiffness.value(phase), law(mesh, gap))

    def forces(self, teeth: Engagement, rates: np.ndarray) -> np.ndarray:
        """Force [N] of every mesh, k f_k(x - e) + d x', positive if the central gear pushes."""
        damping = self.meshes.damping
        if self._switches.damping == "contact":
            damping = np.where(np.abs(teeth.gap) > self.meshes.backlash, damping, 0.0)
        return teeth.stiffness * teeth.reach + damping * rates

    def phase_torques(self, teeth: Engagement) -> np.ndarray:
        """What every mesh's spring exerts on the link against the previous body [N m], (meshes,).

        With x held, the phase still changes the energy k f^2 / 2 stored: it rises with k, and a
        growing error takes away from x - e. The link, which turns the phase, must supply it.
        """
        mesh = self.meshes
        error_slope = mesh.error * np.cos(teeth.phase + mesh.error_phase)
        stiffening = self._stiffness.slope(teeth.phase) * teeth.reach**2 / 2
        return mesh.rate * (teeth.stiffness * teeth.reach * error_slope - stiffening)


def _exact_dead_zone(mesh: Meshes, x: np.ndarray) -> np.ndarray:
    """Eq. 5: what of x [m] reaches beyond the backlash."""
    return x - np.clip(x, -mesh.backlash, mesh.backlash)


def _tanh_dead_zone(mesh: Meshes, x: np.ndarray) -> np.ndarray:
    """Eq. 6, as printed: what of x [m] reaches beyond the backlash, with tanh corners."""
    b = mesh.backlash
    left, right = np.tanh(mesh.sharpness * (x - b)), np.tanh(mesh.sharpness * (x + b))
    return x + x / 2 * (left - right) - b / 2 * (left + right)


def find_contacts(stages: Iterable[tuple[PlanetaryStage, TreeStage]]) -> list[Contact]:
    """All tooth contacts of stages and their bodies, planet by planet, each sun before ring."""
    return [
        Contact(
            gears, bodies, planet, tau * number / gears.planet_count, side, mesh.planet_mesh(number)
        )
        for gears, bodies in stages
        for number, planet in enumerate(bodies.planets)
        for side, mesh in ((+1, gears.sun_mesh), (-1, gears.ring_mesh))
    ]


def build_meshes(contacts: list[Contact], chosen: Switches) -> Meshes:
    """Numbers of the contacts' meshes, in the contacts' order."""
    rows = [_mesh(contact, chosen) for contact in contacts]
    return Meshes(
        **{
            field: np.array([row[field] for row in rows], dtype=int if field in BODIES else float)
            for field in Meshes._fields
        }
    )


def _mesh(contact: Contact, chosen: Switches) -> dict[str, float]:
    """Numbers of one contact's mesh, by the field names of Meshes."""
    joint, stage, planet, _, side, mesh = contact
    external = contact.external
    r_s, r_p, r_r = base_radii(joint)
    teeth = joint.sun_teeth if external else joint.ring_teeth
    alpha = radians(joint.pressure_angle_deg)
    return {
        "side": side,
        "central": stage.driven if external else stage.previous,
        "planet": planet,
        "link": stage.link,
        "central_radius": r_s if external else r_r,
        "planet_radius": r_p,
        "pitch": teeth / (joint.sun_teeth + joint.planet_teeth),
        "cosine": cos(alpha),
        "sine": sin(alpha),
        "rate": joint.ring_teeth if external else _ring_mesh_rate(joint, chosen),
        "phase": _phase_from_teeth(contact) if mesh.phase_rad is None else mesh.phase_rad,
        "error": mesh.tooth_error_m,
        "error_phase": mesh.tooth_error_phase_rad,
        "static_error": mesh.static_error_m,
        "backlash": mesh.backlash_m,
        "sharpness": mesh.tanh_sharpness_per_m,
        "damping": _stage_damping(contact) / joint.planet_count,
    }


def _phase_from_teeth(contact: Contact) -> float:
    """Mesh phase [rad] of a planet at theta = 0, from where its body sits.

    Had the first planet's carrier turned there, with the sun and the ring at rest, the sun's teeth
    would have fallen back behind it by that angle, and it would have passed the ring's.
    """
    joint = contact.joint
    if contact.external:
        return -joint.sun_teeth * contact.place % tau
    given = joint.sun_mesh.planet_mesh(0).phase_rad or 0.0
    return (joint.ring_teeth * contact.place + _ring_sun_phase(joint) + given) % tau


def _ring_sun_phase(joint: PlanetaryGears) -> float:
    """Phase [rad] of a planet's ring mesh after its sun mesh.

    Sun and ring push the same way on either side of the planet, hence on opposite flanks: from one
    to the other it is half a turn of pitches, less the half pitch that a tooth is thick.
    """
    return pi * (joint.planet_teeth - 1)


def _ring_mesh_rate(joint: PlanetaryGears, chosen: Switches) -> int:
    """Teeth of the ring that pass a planet per turn of the link; or what Eq. 13 has in its place.

    Of the sun as many pass: z_s (z_r / z_s + 1 - 1).
    Eq. 13: z_p (r_cp / r_p - 1), and r_cp / r_p = (z_s + z_p) / z_p.
    """
    return joint.ring_teeth if chosen.ring_rate == "corrected" else joint.sun_teeth


def _stage_damping(contact: Contact) -> float:
    """Damping [N s/m] of all contacts of its kind in a joint together, were all like this one.

    From a damping ratio: 2 zeta sqrt(k m) of all meshes' mean stiffness over the sun's, or all the
    planets', equivalent mass.
    """
    joint, mesh = contact.joint, contact.mesh
    if mesh.damping_ratio is None:
        return mesh.damping_N_s_per_m or 0.0
    sun, planet = equivalent_masses(joint)
    planets = joint.planet_count
    mass = sun if contact.external else planets * planet
    mean = build_curve(mesh.stiffness).mean
    return 2 * mesh.damping_ratio * sqrt(planets * mean * mass)
