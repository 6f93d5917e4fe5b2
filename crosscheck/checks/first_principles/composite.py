"""Inertia and weight of an arm by first principles, from the content of its file alone.

No validated arm is read here: what goes wrong on the way from the file into the models, in one of
them or in what all of them share, does not reach these numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

Content = Mapping[str, Any]  # of an arm's file, of either version


class CompositePart(NamedTuple):
    """A body, or the part of a body that turns by itself.

    mass [kg] at a distance [m] along a link, counted from 0; inertia [kg m^2] about its centre;
    geared, locked (joints,): how often it turns with every joint, the gears of that joint rolling
    or standing still on each other.
    """

    mass: float
    inertia: float
    link: int
    along: float
    geared: np.ndarray
    locked: np.ndarray


class Pose(NamedTuple):
    """Poses of an arm, complex: axes, ends of links [m], links' directions, each (..., joints)."""

    axes: np.ndarray
    ends: np.ndarray
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
        parts.append(CompositePart(mass, inertia, k, float(link["com_m"]), after[k], after[k]))
    last = len(links) - 1
    payload, tip = float(content["payload_mass_kg"]), float(links[-1]["length_m"])
    parts.append(CompositePart(payload, 0.0, last, tip, after[last], after[last]))
    for k, joint in enumerate(joints) if level != "links" else ():
        parts += _joint_parts(joint, k, after, level)
    return parts


def _joint_parts(joint: Content, k: int, after: np.ndarray, level: str) -> Iterator[CompositePart]:
    """The parts of a joint: motor or gears, their masses at the axis."""
    before, unit = after[k] - np.eye(len(after))[k], np.eye(len(after))[k]
    if joint["kind"] == "direct":
        motor, rotor = float(joint["motor_mass_kg"]), float(joint["rotor_inertia_kg_m2"])
        yield CompositePart(motor, rotor, k, 0.0, after[k], after[k])
        return
    count, suns, planets, rings = (int(joint.get(name, 3)) for name in ("planet_count", *TEETH))
    orbit = (suns + planets) * joint["module_m"] / 2
    sun, planet, carrier = (gear_inertia(joint, gear) for gear in ("sun", "planet", "carrier"))
    carried = count * joint["planet_mass_kg"]
    masses = joint["sun_mass_kg"] + carried + joint["carrier_mass_kg"] + joint["ring_mass_kg"]
    yield CompositePart(masses, 0.0, k, 0.0, after[k], after[k])
    yield CompositePart(0.0, carrier + carried * orbit**2, k, 0.0, after[k], after[k])
    yield CompositePart(0.0, float(joint.get("ring_inertia_kg_m2", 0.0)), k, 0.0, before, before)
    base = {"armature": 0 * unit, "coupled": before}.get(level)
    if base is not None:
        yield CompositePart(0.0, sun, k, 0.0, base + (1 + rings / suns) * unit, after[k])
        yield CompositePart(
            0.0, count * planet, k, 0.0, base + (1 - rings / planets) * unit, after[k]
        )


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
    ends = np.cumsum(lengths * directions, axis=-1)
    axes = np.concatenate([np.zeros_like(ends[..., :1]), ends[..., :-1]], axis=-1)
    return Pose(axes, ends, directions)


def inertia(parts: Sequence[CompositePart], pose: Pose, *, locked: bool) -> np.ndarray:
    """Mass matrix [kg m^2] by the parallel axis theorem, shape (..., joints, joints).

    locked: the matrix is twice as large; after the joints with their gears rolling come the joints
    with their gears locked, which turns everything beyond an axis as one body.
    """
    levers, turns = _levers(parts, pose), np.array([part.geared for part in parts])
    if locked:
        levers = np.concatenate([levers, levers], axis=-1)
        turns = np.hstack([turns, [part.locked for part in parts]])
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

    Shape (..., parts, joints).
    """
    carries = np.arange(pose.axes.shape[-1]) <= np.array([part.link for part in parts])[:, None]
    levers = find_centres(parts, pose)[..., None] - pose.axes[..., None, :]
    return np.where(carries, levers, 0.0)


def find_centres(parts: Sequence[CompositePart], pose: Pose) -> np.ndarray:
    """Places of the parts' centres in the base's frame [m], complex, shape (..., parts)."""
    links, along = (np.array([getattr(part, n) for part in parts]) for n in ("link", "along"))
    return np.asarray(pose.axes[..., links] + along * pose.directions[..., links])
