"""Faults in what the gear tree makes of single planets, and how far first principles see each."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.models.experiment.switches import switches
from crosscheck.models.pinocchio.gears import PinocchioGears
from tests.faults.faults import ACCELERATION, FORCE, Fault, Plant, edit
from tests.planet_meshes import ROD, arm_of, expected_force, stage, state, undriven, unlike_mesh

LISTED = {"damping_ratio": None, "damping_N_s_per_m": [800.0, 1500.0, 300.0]}
# The first stage's phases are all its teeth's; in the second one the ring follows a given sun.
ARM = arm_of(
    stage(sun_mesh=unlike_mesh(), ring_mesh=unlike_mesh(backlash_m=[1e-5, 2e-5, 4e-5])),
    stage(sun_mesh=unlike_mesh(phase_rad=0.9), ring_mesh=unlike_mesh(**LISTED)),
    links=[ROD, ROD],
)
CONSERVATIVE = switches(planets="free", mesh_work="conservative")
NEIGHBOURS = (
    "(joint.sun_mesh if external else joint.ring_mesh).backlash_m"
    "[(stage.planets.index(planet) + 1) % 3]"
)
SEEN, ROUNDING = 1e-6, 1e-10


def change(function: str, old: str, new: str) -> Plant:
    return edit(f"crosscheck.models.pinocchio.gears:{function}", old, new)


def remesh(function: str, old: str, new: str) -> Plant:
    return edit(f"crosscheck.models.pinocchio.meshes:{function}", old, new)


def stiffen(function: str, old: str, new: str) -> Plant:
    return edit(f"crosscheck.models.pinocchio.stiffness:{function}", old, new)


FAULTS = [
    Fault(
        "the first planet's mesh everywhere",
        remesh("contacts_of", "of_planet(number)", "of_planet(0)"),
        FORCE,
    ),
    Fault(
        "a neighbour's mesh",
        remesh("contacts_of", "of_planet(number)", "of_planet((number + 1) % 3)"),
        FORCE,
    ),
    Fault("a neighbour's clearance", remesh("_mesh", "mesh.backlash_m", NEIGHBOURS), FORCE),
    Fault("planets placed backwards", remesh("_place", "atan2(y, x)", "atan2(-y, x)"), FORCE),
    Fault(
        "the sun's teeth come forward",
        remesh("_phase_from_teeth", "-joint.sun_teeth", "joint.sun_teeth"),
        FORCE,
    ),
    Fault(
        "the carrier leaves the ring's teeth behind it",
        remesh("_phase_from_teeth", "(joint.ring_teeth *", "(-joint.ring_teeth *"),
        FORCE,
    ),
    Fault("all planets of a stage in phase", remesh("_place", "atan2(y, x)", "0.0"), FORCE),
    Fault(
        "no half pitch across the planet",
        remesh("_phase_from_teeth", " + _across_planet(joint)", ""),
        FORCE,
    ),
    Fault(
        "teeth without thickness",
        remesh("_across_planet", "(joint.planet_teeth - 1)", "joint.planet_teeth"),
        FORCE,
    ),
    Fault(
        "the ring does not follow the sun's phase",
        remesh("_phase_from_teeth", " + given", ""),
        FORCE,
    ),
    Fault(
        "static error dropped",
        change("PinocchioGears._engagement", "mesh.static_error + ", ""),
        FORCE,
    ),
    Fault(
        "static error's sign",
        change("PinocchioGears._engagement", "mesh.static_error + ", "-mesh.static_error + "),
        FORCE,
    ),
    Fault(
        "the tooth errors in phase with the stiffness",
        change("PinocchioGears._engagement", " + mesh.error_phase", ""),
        FORCE,
    ),
    Fault(
        "every planet damps for all",
        remesh("_mesh", "_stage_damping(contact) / joint.planet_count", "_stage_damping(contact)"),
        FORCE,
    ),
    Fault(
        "the first planet's dampers everywhere",
        remesh("_stage_damping", ", contact.mesh", ", contact.joint.ring_mesh.of_planet(0)"),
        FORCE,
    ),
    Fault(
        "damping ratio over one planet's stiffness",
        remesh("_stage_damping", "sqrt(planets * mean * mass)", "sqrt(mean * mass)"),
        FORCE,
    ),
    Fault(
        "no work on the phase",
        change("PinocchioGears._joint_torques", '== "conservative"', '== "never"'),
        FORCE,
    ),
    Fault(
        "work on the phase taken from the link",
        change("PinocchioGears._phase_torques", "return mesh.rate", "return -mesh.rate"),
        FORCE,
    ),
    Fault(
        "work on the phase turns the planet",
        change("PinocchioGears._joint_torques", "self._meshes.link - 1", "self._meshes.planet - 1"),
        FORCE,
    ),
    Fault(
        "one mesh of a stage alone works on the phase",
        change(
            "PinocchioGears._joint_torques",
            "np.add.at(torques, self._meshes.link - 1, self._phase_torques(teeth))",
            "torques[self._meshes.link - 1] += self._phase_torques(teeth)",
        ),
        FORCE,
    ),
    Fault(
        "stored energy without its half",
        change("PinocchioGears._phase_torques", "teeth.reach**2 / 2", "teeth.reach**2"),
        FORCE,
    ),
    Fault(
        "energy of the whole gap",
        change("PinocchioGears._phase_torques", "teeth.reach**2", "teeth.gap**2"),
        FORCE,
    ),
    Fault(
        "the error works on nothing",
        change("PinocchioGears._phase_torques", "mesh.error * np", "0 * np"),
        FORCE,
    ),
    Fault(
        "the error's work in phase with the stiffness",
        change("PinocchioGears._phase_torques", " + mesh.error_phase", ""),
        FORCE,
    ),
    Fault("harmonics as slow as the first", stiffen("_counted", " * sizes", " * 0 + sizes"), FORCE),
    Fault(
        "slope of cosines",
        stiffen("StiffnessWaves.slope", "return rising -", "return rising +"),
        FORCE,
    ),
    Fault("slope of a table per cycle", stiffen("Spline.slope", "1)) / (2 * pi)", "1))"), FORCE),
    Fault(
        "every planet turns as the first",
        edit("crosscheck.models.pinocchio.tree:map_to_tree", '"x_pr", i, number)', '"x_pr", i, 0)'),
        FORCE,
    ),
    Fault(
        "the sun's advance forgets the carrier",
        change("PinocchioGears._displacements", "[r_s * sun - r_r * theta, *", "[r_s * sun, *"),
        ACCELERATION,
    ),
    Fault(
        "planets in the wrong order on the way back",
        change("PinocchioGears._displacements", "r_p * planets)]", "r_p * planets[::-1])]"),
        ACCELERATION,
    ),
]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_first_principles_see_a_fault_of_single_planets(fault: Fault):
    assert off_first_principles(fault.red_check) < ROUNDING
    with pytest.MonkeyPatch.context() as patch:
        fault.plant(patch)
        assert off_first_principles(fault.red_check) > SEEN


def off_first_principles(quantity: str) -> float:
    """Force, or M a + bias, off what the laws say, over the largest force of its kind."""
    model = PinocchioGears(ARM, undriven(), CONSERVATIVE)
    q, v = state(model.layout, 5)
    expected = expected_force(ARM, CONSERVATIVE, model.layout, 0.0, q, v)
    if quantity == FORCE:
        found = model.generalized_force(0.0, q, v)
    else:
        found = model.mass_matrix(q) @ model.acceleration(0.0, q, v) + model.bias(q, v)
    off = np.abs(found - expected)
    kinds = (model.layout.angular, ~model.layout.angular)
    return float(max(off[kind].max() / np.abs(expected[kind]).max() for kind in kinds))
