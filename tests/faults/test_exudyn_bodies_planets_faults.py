"""Faults in what Exudyn's bodies have for each planet, and what sees them by first principles."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pytest

from crosscheck.models.experiment.switches import switches
from crosscheck.models.exudyn.bodies import contact as exudyn_contact
from crosscheck.models.exudyn.bodies.bodies import ExudynBodies
from tests.faults.bodies_interpreted import interpret
from tests.faults.faults import CONTACT, Fault, Laws, edit
from tests.mixed_arms import random_states, scenario
from tests.outside_truth.bodies_planets import (
    ANGLES,
    energy_slopes,
    first_touch,
    recorded_forces,
    states_in,
    tooth_forces,
    unlike_arm,
)

BODIES, MESH = (
    "crosscheck.models.exudyn.bodies.bodies:ExudynBodies.",
    "crosscheck.models.exudyn.bodies.contact:",
)
STIFFNESS, POSES = (
    "crosscheck.models.exudyn.bodies.stiffness:",
    "crosscheck.models.exudyn.bodies.poses:",
)
FORCES, WORK, REACTIONS = "planets/forces", "planets/work", "planets/reactions"
MOTION, START, RECORDS = "planets/motion", "planets/start", "planets/records"
OWN = "(joint.sun_mesh if sun else joint.ring_mesh)"
SPIN = np.where(np.isin(np.arange(ANGLES[-1] + 1), ANGLES), 1.0, 1e3)  # rates that are felt


def of_neighbour(field: str) -> str:
    return f"={OWN}.of_planet(planet - 1).{field}"


NUMBERS = [
    Fault("first planet's mesh", edit(MESH + "mesh_of", "planet(planet)", "planet(0)"), FORCES),
    *(
        Fault(
            f"neighbour's {field}",
            edit(MESH + "mesh_of", f"=own.{field},", of_neighbour(field) + ","),
            FORCES,
        )
        for field in ("backlash_m", "tooth_error_m", "tooth_error_phase_rad", "static_error_m")
    ),
    Fault(
        "neighbour's stiffness",
        edit(MESH + "mesh_of", "(own.stiffness)", f"({OWN}.of_planet(planet - 1).stiffness)"),
        FORCES,
    ),
    Fault(
        "first planet's damping ratio",
        edit(
            MESH + "damping_of",
            "own.damping_ratio * ",
            "joint.ring_mesh.of_planet(0).damping_ratio * ",
        ),
        FORCES,
    ),
    Fault(
        "damping of the sun's mass",
        edit(MESH + "damping_of", 'side == "ring"', 'side == "sun"'),
        FORCES,
    ),
    Fault("given damping of all planets", edit(MESH + "damping_of", " / count", ""), FORCES),
    Fault("static error lost", edit(MESH + "gap_of", " - mesh.runout", ""), FORCES),
    Fault("static error added", edit(MESH + "gap_of", "- mesh.runout", "+ mesh.runout"), FORCES),
    Fault("error in phase", edit(MESH + "gap_of", " + mesh.error_phase", ""), FORCES),
    Fault(
        "contact without static error",
        edit(MESH + "damping_force", "contact), m", "contact) + mesh.runout, m"),
        FORCES,
        CONTACT,
    ),
]

PHASES = [
    Fault("all in phase", edit(MESH + "mesh_of", "side, direction)", "side, 0.0)"), FORCES),
    Fault("sun's teeth the wrong way", edit(MESH + "teeth_passed", "-joint", "joint"), FORCES),
    Fault(
        "ring's teeth the wrong way",
        edit(MESH + "teeth_passed", "= joint.ring", "= -joint.ring"),
        FORCES,
    ),
    Fault(
        "no half pitch between a planet's flanks",
        edit(MESH + "teeth_passed", " + (joint.planet_teeth - 1) % 2 * np.pi", ""),
        FORCES,
    ),
    Fault(
        "half a pitch between the flanks of odd teeth",
        edit(MESH + "teeth_passed", "planet_teeth - 1", "planet_teeth"),
        FORCES,
    ),
    Fault(
        "ring without the sun's phase",
        edit(MESH + "teeth_passed", "joint.sun_mesh.of_planet(0).phase_rad or 0.0", "0.0"),
        FORCES,
    ),
    Fault(
        "ring with another planet's sun phase",
        edit(MESH + "teeth_passed", "of_planet(0)", "of_planet(1)"),
        FORCES,
    ),
]

ON_ANGLES = [
    Fault("no work on the angle", edit(MESH + "mesh_forces", "mesh.conservative", "False"), WORK),
    Fault("work's sign", edit(MESH + "carrier_torque", "return m", "return -m"), WORK),
    Fault("stiffness does no work", edit(MESH + "carrier_torque", " - stiffening", ""), WORK),
    Fault("error does no work", edit(MESH + "carrier_torque", "closing * elas", "0 * elas"), WORK),
    Fault("twice the stiffening", edit(MESH + "carrier_torque", "**2 / 2", "**2"), WORK),
    Fault(
        "work of an error in phase", edit(MESH + "carrier_torque", " + mesh.error_phase", ""), WORK
    ),
    Fault("a tooth's work per turn", edit(MESH + "carrier_torque", "mesh.teeth * ", ""), WORK),
    Fault(
        "torque on the carrier alone",
        edit(MESH + "mesh_forces", "forces[3 * PREVIOUS + 2] -= torque", "pass"),
        REACTIONS,
    ),
    Fault(
        "torque on the previous link alone",
        edit(MESH + "mesh_forces", "forces[3 * CARRIER + 2] += torque", "pass"),
        REACTIONS,
    ),
    Fault("sign of a sine's slope", edit(STIFFNESS + "slope_at", "return n", "return -n"), WORK),
    Fault("orders forgotten", edit(STIFFNESS + "waves_slope", "order * (numb", "1 * (numb"), WORK),
    Fault(
        "cosines' slopes forward",
        edit(STIFFNESS + "waves_slope", "- numbers[row, 0]", "+ numbers[row, 0]"),
        WORK,
    ),
    Fault(
        "slope of the square wave's rise alone",
        edit(STIFFNESS + "square_slope", "- np.cos(order * (2", "- 0 * np.cos(order * (2"),
        WORK,
    ),
    Fault("slope per cycle", edit(STIFFNESS + "slope_at", " / (2 * np.pi)", ""), WORK),
    Fault(
        "slope of a table at its rows alone",
        edit(STIFFNESS + "cubic_slope", "6 * s * (1 - s) * rise + ", ""),
        WORK,
    ),
]

COORDINATES = [
    Fault(
        "sun by another planet",
        edit(POSES + "turns_of", "+ along_planets[0]", "+ along_planets[1]"),
        FORCES,
    ),
    Fault(
        "sun's advance against the carrier once",
        edit(POSES + "turned_back", "2 * carried", "carried"),
        MOTION,
    ),
    Fault(
        "planets in the reverse order",
        edit(POSES + "turned_back", "unit[list(stage.planets)]", "unit[list(stage.planets[::-1])]"),
        MOTION,
    ),
    Fault("sun at the last contact", edit(BODIES + "_place_planets", ".min()", ".max()"), START),
    Fault(
        "sun not taken along by the ring's offset",
        edit(BODIES + "_place_planets", "apart + from_ring", "apart"),
        START,
    ),
    Fault(
        "sun taken along by its planets' offsets",
        edit(BODIES + "_place_planets", "(x_pr + x_sp)", "(q[rings] - from_ring + x_sp)"),
        START,
    ),
    Fault(
        "no offsets of planets",
        edit(BODIES + "_place_planets", "+= planet_offsets(start, place, len(rings))", "+= 0.0"),
        START,
    ),
    Fault("start without static error", edit(MESH + "touching", " + mesh.runout", ""), START),
    Fault(
        "records of the neighbour",
        edit(BODIES + "_mesh_records", "joint, planet] =", "joint, len(toothed) - 1 - planet] ="),
        RECORDS,
    ),
]

FAULTS = [*NUMBERS, *PHASES, *ON_ANGLES, *COORDINATES]


OFFSETS = {
    "sun_planet_offset_m": [3e-6, 5e-6],
    "planet_ring_offset_m": [2e-5, 4e-6],
    "planet_offset_m": [[1e-6, -2e-6, 3e-6], [-9e-6, 5e-6, 0.0, -4e-6]],
}
OFFSET = np.array([23e-6, 21e-6, 18e-6, 23e-6, 9e-6, -5e-6, 9e-6, 4e-6, 0, 0, 0])


class Check(NamedTuple):
    """What is off, over its size, and how much of it is rounding."""

    measure: Callable[[ExudynBodies], float]
    tolerance: float


def _forces(model: ExudynBodies) -> float:
    slides = ~model.layout.angular
    off = []
    for q, v in random_states(model.layout, 5):
        force = model.generalized_force(0.0, q, SPIN * v)
        expected = tooth_forces(q, SPIN * v, model.switches.damping)
        off.append(abs(force - expected)[slides].max() / abs(expected).max())
    return max(off)


def _work(model: ExudynBodies) -> float:
    off = []
    for q, _ in random_states(model.layout, 5):
        force, slopes = model.generalized_force(0.0, q, 0 * q), energy_slopes(q)
        off.append(abs(force + slopes)[list(ANGLES)].max() / abs(slopes[list(ANGLES)]).max())
    return max(off)


def _reactions(model: ExudynBodies) -> float:
    draw, off = np.random.default_rng(5), []
    for toothed in (of for sides in model.meshes for side in sides for of in side):
        pose, velocity = draw.normal(size=(2, 3 * len(toothed.bodies)))
        forces, at = (
            exudyn_contact.mesh_forces(toothed.mesh, 0.2, pose, velocity).reshape(-1, 3),
            pose.reshape(-1, 3),
        )
        turning = at[:, 0] * forces[:, 1] - at[:, 1] * forces[:, 0] + forces[:, 2]
        off.append(abs(turning.sum()) / abs(forces).max())
    return max(off)


def _motion(model: ExudynBodies) -> float:
    off = []
    for q, v in random_states(model.layout, 5):
        a, force = model.acceleration(0.0, q, v), model.generalized_force(0.0, q, v)
        balance = model.mass_matrix(q) @ a + model.bias(q, v) - force
        off.append(abs(balance).max() / abs(force).max())
    return max(off)


def _start(model: ExudynBodies) -> float:
    return float(abs(model.start()[0] - first_touch() - OFFSET).max())


def _records(model: ExudynBodies) -> float:
    run = model.simulate()
    recorded = np.stack([run.F_sp.values, run.F_pr.values], axis=1)
    expected = np.array([recorded_forces(q) for q in states_in(run)])
    return float(np.nanmax(abs(recorded - expected)) / np.nanmax(expected))


CHECKS = {
    FORCES: Check(_forces, 1e-10),  # deflections out of places near 1 m, times 1e8 N/m
    WORK: Check(_work, 1e-7),  # differences of joules over 1e-5 rad
    REACTIONS: Check(_reactions, 1e-13),  # arms of a few metres
    MOTION: Check(_motion, 1e-9),  # gears of 0.5 kg on a heavy arm
    START: Check(_start, 1e-18),  # of 1e-4 m
    RECORDS: Check(_records, 1e-10),
}


def verdict(fault: Fault) -> str:
    """Of its check, with whatever is planted in the bodies."""
    chosen = switches(planets="free", mesh_work="conservative", **dict(fault.laws))
    run = scenario(duration_s=3e-6, record_every=1, start=OFFSETS)
    check = CHECKS[fault.red_check]
    off = check.measure(ExudynBodies(unlike_arm(), run, chosen))
    return "agree" if off < check.tolerance else "differ"


@lru_cache
def _control(red_check: str, laws: Laws) -> str:
    with pytest.MonkeyPatch.context() as patch:
        interpret(patch)
        return verdict(Fault("none", lambda patch: None, red_check, laws))


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_fault_turns_its_check_red(fault: Fault, monkeypatch: pytest.MonkeyPatch):
    assert _control(fault.red_check, fault.laws) == "agree"
    interpret(monkeypatch)
    fault.plant(monkeypatch)
    assert verdict(fault) == "differ"
