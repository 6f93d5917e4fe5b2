"""Inertia and weight of an arm by first principles, from the content of its file alone.

No validated arm is read here: what goes wrong on the way from the file into the models, in one of
them or in what all of them share, does not reach these numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.arm.layout import MESHES, Layout

Content = Mapping[str, Any]  # of an arm's file, of either version


class MeshTurn(NamedTuple):
    """How a gear turns by the displacements of a planet's meshes, beyond rolling with the joint.

    joint, planet: counted from 0; turns: along x_sp and x_pr [rad/m].
    """

    joint: int
    planet: int
    turns: tuple[float, float]


class CompositePart(NamedTuple):
    """A body, or the part of a body that turns by itself.

    mass [kg] at a distance [m] along a link, counted from 0; inertia [kg m^2] about its centre;
    turns (joints,): how often it turns with every joint, all gears rolling; mesh_turn: of a gear.
    """

    mass: float
    inertia: float
    link: int
    along: float
    turns: np.ndarray
    mesh_turn: MeshTurn | None = None


class Pose(NamedTuple):
    """Poses of an arm, complex: links from axis to axis [m], their directions, (..., joints)."""

    links: np.ndarray
    directions: np.ndarray


def build_parts(content: Content, level: str = "coupled") -> list[CompositePart]:
    """The bodies that a rigid level has; of ``coupled``, and of a geared arm, all of them."""
    links, joints = content["links"], content["joints"]
    after = np.tril(np.ones((len(links), len(links))))  # what turns with link k
    parts = []
    for k, link in enumerate(links):
        if link.get("mass_kg") is not None:
            mass, inertia = float(link["mass_kg"]), float(link["inertia_kg_m2"])
        else:  # of a slender rod
            length = float(link["length_m"])
            mass = length * link["cross_section_m2"] * link["density_kg_per_m3"]
            inertia = mass * length * length / 12
        parts.append(CompositePart(mass, inertia, k, float(link["com_m"]), after[k]))
    last = len(links) - 1
    payload, tip = float(content["payload_mass_kg"]), float(links[-1]["length_m"])
    parts.append(CompositePart(payload, 0.0, last, tip, after[last]))
    for k, joint in enumerate(joints) if level != "links" else ():
        parts += _joint_parts(joint, k, after, level)
    return parts


def _joint_parts(joint: Content, k: int, after: np.ndarray, level: str) -> Iterator[CompositePart]:
    """The parts of a joint: motor or gears, their masses at the axis."""
    before, unit = after[k] - np.eye(len(after))[k], np.eye(len(after))[k]
    if joint["kind"] == "direct":
        motor, rotor = float(joint["motor_mass_kg"]), float(joint["rotor_inertia_kg_m2"])
        yield CompositePart(motor, rotor, k, 0.0, after[k])
        return
    count, suns, planets, rings = (int(joint.get(name, 3)) for name in ("planet_count", *TEETH))
    orbit = (suns + planets) * joint["module_m"] / 2
    sun, planet, carrier = (gear_inertia(joint, gear) for gear in ("sun", "planet", "carrier"))
    carried = count * joint["planet_mass_kg"]
    masses = joint["sun_mass_kg"] + carried + joint["carrier_mass_kg"] + joint["ring_mass_kg"]
    yield CompositePart(masses, 0.0, k, 0.0, after[k])
    yield CompositePart(0.0, carrier + carried * orbit**2, k, 0.0, after[k])
    yield CompositePart(0.0, float(joint.get("ring_inertia_kg_m2", 0.0)), k, 0.0, before)
    base = {"armature": 0 * unit, "coupled": before}.get(level)
    if base is None:
        return
    # x_sp + x_pr of any planet are an arc of the sun, x_pr is one of the planet, the other way.
    by_sun, by_planet = (1 / base_radius(joint, teeth) for teeth in (suns, planets))
    turns = base + (1 + rings / suns) * unit
    yield CompositePart(0.0, sun, k, 0.0, turns, MeshTurn(k, 0, (by_sun, by_sun)))
    turns = base + (1 - rings / planets) * unit
    for number in range(count):
        mesh_turn = MeshTurn(k, number, (0.0, -by_planet))
        yield CompositePart(0.0, planet, k, 0.0, turns, mesh_turn)


TEETH = ("sun_teeth", "planet_teeth", "ring_teeth")


def gear_inertia(joint: Content, gear: str) -> float:
    """Inertia J of a sun, a planet or a carrier about its axis [kg m^2], as given or M r^2."""
    inertia = joint.get(f"{gear}_inertia_kg_m2")
    if inertia is not None:
        return float(inertia)
    teeth = joint["sun_teeth"] + joint["planet_teeth"]
    teeth = {"sun": joint["sun_teeth"], "planet": joint["planet_teeth"]}.get(gear, teeth)
    return float(joint[f"{gear}_equivalent_mass_kg"]) * base_radius(joint, teeth) ** 2


def base_radius(joint: Content, teeth: int) -> float:
    """Base radius of a wheel of the joint [m]."""
    pitch = float(joint["module_m"]) * teeth / 2
    return pitch * math.cos(math.radians(joint["pressure_angle_deg"]))


def arm_pose(content: Content, theta: np.ndarray) -> Pose:
    """The pose of an arm at relative angles theta (..., joints) [rad]."""
    directions = np.exp(1j * np.cumsum(theta, axis=-1))
    lengths = np.array([float(link["length_m"]) for link in content["links"]])
    return Pose(lengths * directions, directions)


def mass_matrix(parts: Sequence[CompositePart], pose: Pose, layout: Layout) -> np.ndarray:
    """Mass matrix by the parallel axis theorem, shape (..., n, n), in a layout's coordinates."""
    levers = np.zeros((*pose.links.shape[:-1], len(parts), len(layout)), dtype=complex)
    levers[..., layout.theta] = _levers(parts, pose)
    turns = np.zeros((len(parts), len(layout)))
    turns[:, layout.theta] = [part.turns for part in parts]
    for row, part in zip(turns, parts, strict=True):
        if part.mesh_turn and layout.mesh_joints:
            joint, planet, by = part.mesh_turn
            for mesh, turn in zip(MESHES, by, strict=True):
                row += turn * layout.displacement(mesh, joint, planet)
    masses, inertias = (np.array([getattr(p, n) for p in parts]) for n in ("mass", "inertia"))
    shifted = np.swapaxes(np.conj(levers), -1, -2) @ (masses[:, None] * levers)
    return np.asarray(shifted.real + (turns.T * inertias) @ turns)


def weight(parts: Sequence[CompositePart], pose: Pose, content: Content) -> np.ndarray:
    """Moment of weight about every axis of the arm [N m], shape (..., joints)."""
    pull = complex(*content.get("gravity_m_per_s2", (0.0, 0.0)))
    moments = (np.conj(_levers(parts, pose)) * pull).imag
    return np.asarray(np.array([part.mass for part in parts]) @ moments)


def _levers(parts: Sequence[CompositePart], pose: Pose) -> np.ndarray:
    """Levers from each axis that carries a part to its centre [m], complex, else 0.

    Shape (..., parts, joints). Summed from the part inwards, so that a lever has no rounding of
    longer links before its axis.
    """
    joints, places = np.arange(pose.links.shape[-1]), np.array([part.link for part in parts])
    between = np.where(joints < places[:, None], pose.links[..., None, :], 0.0)
    levers = np.cumsum(between[..., ::-1], axis=-1)[..., ::-1]
    along = np.array([part.along for part in parts]) * pose.directions[..., places]
    return np.where(joints <= places[:, None], levers + along[..., None], 0.0)


def find_centres(parts: Sequence[CompositePart], pose: Pose) -> np.ndarray:
    """Places of the parts' centres in the base's frame [m], complex, shape (..., parts)."""
    return _levers(parts, pose)[..., 0]
