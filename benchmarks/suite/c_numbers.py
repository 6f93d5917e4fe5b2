"""What the C references are given: an arm's structure as macros, its numbers as in arm.h."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.derivation.bodies import carried_bodies, link_bodies
from crosscheck.analytic.derivation.chain import build_exact_chain
from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.derivation.stage import equivalent_masses
from crosscheck.analytic.model import AnalyticModel
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.analytic.paper.mesh_frequency import OMEGA_T
from crosscheck.analytic.paper.stiffness import SINE
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.experiment.drive import CONSTANT, PD

TURN, QUARTER = 2 * np.pi, 0.25


class NotCovered(Exception):
    """The C references have no code for such an arm, law or drive."""


class Structure(NamedTuple):
    """Everything that the compiled code is made for; lists as in arm.h."""

    planets: tuple[int, ...]
    phases: tuple[int, ...]
    sun: tuple[int, ...]
    ring: tuple[int, ...]
    drive: str
    omega_t: bool

    def macros(self) -> list[str]:
        """Of the compiler's command line."""
        counts = {"JOINTS": len(self.planets), "BODIES": sum(self.planets)}
        lists: dict[str, Iterable[int]] = {
            "FIRST": np.cumsum([0, *self.planets]),
            "PHASE_FIRST": np.cumsum([0, *self.phases]),
            "SUN": self.sun,
            "RING": self.ring,
        }
        given = [f"-D{name}={count}" for name, count in counts.items()]
        given.append(f"-DPHASES={sum(self.phases)}")
        given += [f"-D{n}={{{','.join(map(str, each))}}}" for n, each in lists.items()]
        return [*given, f"-D{self.drive}", *(["-DOMEGA_T"] if self.omega_t else [])]


class Phases(NamedTuple):
    """The different phases (rate, offset) of all meshes, how many each joint has, and which of them
    every mesh takes."""

    values: list[tuple[float, float]]
    counts: tuple[int, ...]
    places: list[int]


def make_structure(model: AnalyticModel) -> Structure:
    """Raises NotCovered."""
    _require_covered(model)
    phases = group_phases(model.gears)
    drive = {PD: "PD", CONSTANT: "CONSTANT"}[model.drive.code]
    return Structure(
        planet_bodies(model),
        phases.counts,
        tuple(phases.places[::2]),
        tuple(phases.places[1::2]),
        drive,
        model.gears.phase == OMEGA_T,
    )


def _require_covered(model: AnalyticModel) -> None:
    gears, arm = model.gears, model.arm
    covered = (
        all(isinstance(joint, Planetary) for joint in arm.joints)
        and model.drive.code in (PD, CONSTANT)
        and (gears.law.code == SINE).all()
        and not gears.error_phase.any()
        and gears.dead_zone == 0
        and gears.damps_without_contact
        and not gears.conservative
        and not any(arm.gravity_m_per_s2)
    )
    if not covered:
        raise NotCovered(f"{arm.name}, {model.switches}")


def planet_bodies(model: AnalyticModel) -> tuple[int, ...]:
    """Of every joint: one for all its planets, or one each."""
    return tuple(j.planet_count if model.layout.free else 1 for j in model.arm.joints)


def group_phases(gears: Gears) -> Phases:
    """Meshes of one joint whose rate and constant agree share a sine."""
    values: list[tuple[int, float, float]] = []
    for joint in dict.fromkeys(gears.theta):
        of_joint = np.flatnonzero(gears.theta == joint)
        values += dict.fromkeys((joint, gears.rate[i], gears.offset[i]) for i in of_joint)
    mesh_phases = zip(gears.theta, gears.rate, gears.offset, strict=True)
    counts = tuple(sum(v[0] == joint for v in values) for joint in dict.fromkeys(gears.theta))
    return Phases([v[1:] for v in values], counts, [values.index(each) for each in mesh_phases])


def collect_numbers(model: AnalyticModel) -> np.ndarray:
    """All numbers of `arm` of arm.h, in its order."""
    gears, phases = model.gears, group_phases(model.gears)
    rate, offset = np.array(phases.values).T / TURN
    offset = offset - QUARTER  # a sine is the cosine of a quarter turn before
    masses, diagonal = _inertia(model.arm, model)
    gains = model.drive.gains if model.drive.code == PD else model.drive.gains * [1, 0, 0]
    meshes = (gears.planets * gears.k_m, gears.planets * gears.k_a)
    laws = (gears.E, gears.static_error, gears.b, gears.d)
    friction = [joint.friction_N_m_s_per_rad for joint in model.arm.joints]
    return np.concatenate(
        [
            *(rate, offset, *meshes, *laws, *_gear_numbers(model), friction, *gains.T),
            *(diagonal, masses.ravel(), [1 / diagonal[0]]),
        ]
    )


def _gear_numbers(model: AnalyticModel) -> list[np.ndarray]:
    """per_sun ... torque_before of arm.h."""
    per_sun, per_planet, sun_row, planet_row, torque_sun, torque_before = ([] for _ in range(6))
    for joint, bodies in zip(model.arm.joints, planet_bodies(model), strict=True):
        assert isinstance(joint, Planetary)
        geometry, (sun, planet, _) = stage_geometry(joint), equivalent_masses(joint)
        per_sun.append(1 / sun)
        per_planet += [bodies / (joint.planet_count * planet)] * bodies
        sun_row += [geometry.r_s - 2 * geometry.r_cp, 2 * geometry.r_cp]
        planet_row += [-(geometry.r_p + geometry.r_cp), geometry.r_cp]
        torque_sun.append(1 / (geometry.r_s * geometry.n))
        torque_before.append(-1 / geometry.n)
    return [
        np.array(v) for v in (per_sun, per_planet, sun_row, planet_row, torque_sun, torque_before)
    ]


def _inertia(arm: Arm, model: AnalyticModel) -> tuple[np.ndarray, np.ndarray]:
    """m (joints, joints), and the diagonal of S (joints,), over absolute angles.

    Everything but the spin of suns and planets, which has coordinates of its own.
    """
    chain, joints = build_exact_chain(arm, model.layout), len(arm.joints)
    masses, constant = np.zeros((joints, joints)), np.zeros(joints)
    absolute = np.array(chain.angles[1:], dtype=float)
    for joint in chain.numbers:
        for body in (*link_bodies(chain, joint), *carried_bodies(chain, joint)):
            centre = np.zeros(joints)
            centre[: len(body.centre)] = [float(c) for c in body.centre]
            masses += float(body.mass) * np.outer(centre, centre)
            turns = [(absolute[k] == body.angle.astype(float)).all() for k in range(joints)]
            constant[turns] += float(body.inertia)
    return masses, np.diag(masses) + constant


def state_of(model: AnalyticModel, q: np.ndarray) -> np.ndarray:
    """Coordinates q (..., n) of the layout as (Theta, x_s, x_pr) of arm.h."""
    return q @ _change_matrix(model).T


def layout_of(model: AnalyticModel, y: np.ndarray) -> np.ndarray:
    """The reverse."""
    return y @ np.linalg.inv(_change_matrix(model)).T


def _change_matrix(model: AnalyticModel) -> np.ndarray:
    layout, joints = model.layout, range(len(model.arm.joints))
    rows = [np.zeros(len(layout)) for _ in joints]
    for j in joints:
        rows[j][layout.theta[: j + 1]] = 1.0
    if layout.free:
        rows += [np.eye(len(layout))[layout.at("x_s", j)] for j in joints]
    else:
        rows += [
            layout.displacement("x_sp", j, 0) + layout.displacement("x_pr", j, 0) for j in joints
        ]
    for j, bodies in zip(joints, planet_bodies(model), strict=True):
        rows += [layout.displacement("x_pr", j, planet) for planet in range(bodies)]
    return np.array(rows)
