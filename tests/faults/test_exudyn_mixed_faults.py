"""Faults in what only arms of the second version have, seen by Exudyn's other tier."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import pytest

from crosscheck.models.exudyn.bodies.bodies import ExudynBodies
from crosscheck.models.exudyn.tree.tree import ExudynTree
from tests.faults.bodies_interpreted import interpret as interpret_bodies
from tests.faults.faults import Plant, edit, interpret
from tests.mixed_arms import MIXED, random_states, scenario

TREE, LAWS = "crosscheck.models.exudyn.tree.tree:", "crosscheck.models.exudyn.tree.laws:"
LOADS = "crosscheck.models.exudyn.tree.loads:"
PARTS, CURVE = "crosscheck.models.exudyn.tree.parts:", "crosscheck.models.exudyn.tree.stiffness:"
BODIES, CONTACT = (
    "crosscheck.models.exudyn.bodies.bodies:",
    "crosscheck.models.exudyn.bodies.contact:",
)
POSES, SPRING = (
    "crosscheck.models.exudyn.bodies.poses:",
    "crosscheck.models.exudyn.bodies.stiffness:",
)
ENGINE = "crosscheck.models.exudyn.bodies.engine:BodyEngine."
MASS, FORCE = "mass_matrix", "generalized_force"


class MixedFault(NamedTuple):
    """A fault and the answer in which the tiers must then differ."""

    name: str
    plant: Plant
    answer: str = FORCE


IN_TREE = [
    MixedFault("motor without mass", edit(PARTS + "_far_end", "outer.motor_mass_kg", "0.0"), MASS),
    MixedFault(
        "rotor without inertia",
        edit(PARTS + "_link_parts", "joint.rotor_inertia", "0 * joint.rotor_inertia"),
        MASS,
    ),
    MixedFault(
        "body's centre",
        edit(PARTS + "_link", "link.mass_kg, link.com_m", "link.mass_kg, 0.3"),
        MASS,
    ),
    MixedFault("J for M", edit(LAWS + "inertia", "return given", "return given * radius**2"), MASS),
    MixedFault("direct motor by a ratio", edit(LOADS + "_ratio", "return 1.0", "return 2.0")),
    MixedFault("friction drives", edit(LOADS + "add_joints", "forces[link] -=", "forces[link] +=")),
    MixedFault(
        "friction of the shoulder", edit(LOADS + "add_joints", "friction[joint]", "friction[0]")
    ),
    MixedFault(
        "friction on the motor", edit(LOADS + "add_joints", "forces[link] -=", "forces[driven] -=")
    ),
    MixedFault(
        "weight upwards",
        edit("crosscheck.models.exudyn.engine:_tree", "[*gravity", "[-gravity[0], gravity[1]"),
    ),
    MixedFault(
        "one stiffness for both meshes",
        edit(LAWS + "mesh_law", "curve_of(mesh.", "curve_of(joint.sun_mesh."),
    ),
    MixedFault(
        "one play for both meshes",
        edit(LAWS + "mesh_law", "mesh.backlash_m", "joint.sun_mesh.backlash_m"),
    ),
    MixedFault("M by J", edit(LAWS + "equivalent_mass", "given / radius**2", "given / radius")),
    MixedFault(
        "sign of the cosines", edit(CURVE + "waves_at", "total += law[row]", "total -= law[row]")
    ),
    MixedFault("first order only", edit(CURVE + "waves_at", "along, across = along", "_ = along")),
    MixedFault("square wave in mirror", edit(CURVE + "_square", "1 - np.cos", "1 + np.cos")),
    MixedFault(
        "spline of straight lines",
        edit(CURVE + "spline_at", "straight + bent", "straight + 0 * bent"),
    ),
    MixedFault(
        "ends of the spline free",
        edit(CURVE + "_spline", "spsolve(system,", "0.9 * spsolve(system,"),
    ),
    MixedFault(
        "mean of the rows", edit(CURVE + "_spline", "float(area.sum())", "float(stiffness.mean())")
    ),
]

IN_BODIES = [
    MixedFault(
        "motor without mass", edit(POSES + "link_parts", "outer.motor_mass_kg", "0.0"), MASS
    ),
    MixedFault(
        "rotor without inertia",
        edit(POSES + "link_parts", "joint.rotor_inertia_kg_m2", "0.0"),
        MASS,
    ),
    MixedFault(
        "body taken for a rod",
        edit(POSES + "_bare_link", "link.inertia_kg_m2", "link.mass_kg"),
        MASS,
    ),
    MixedFault(
        "J for M", edit(POSES + "gear_inertia", "return inertia", "return 2 * inertia"), MASS
    ),
    MixedFault("direct motor by a ratio", edit(BODIES + "motor", "else 1.0", "else 2.0")),
    MixedFault(
        "friction drives", edit(BODIES + "motor", "torques[link] -= drag", "torques[link] += drag")
    ),
    MixedFault(
        "friction against the ground", edit(BODIES + "motor", "drag - on_driven", "-on_driven")
    ),
    MixedFault(
        "weight upwards", edit(ENGINE + "_add_weight", "[*gravity", "[-gravity[0], gravity[1]")
    ),
    MixedFault(
        "first parts alone have weight", edit(ENGINE + "_add_bodies", "in parts:", "in parts[:1]:")
    ),
    MixedFault(
        "one stiffness for both meshes",
        edit(CONTACT + "mesh_of", "spring_of(own.", "spring_of(joint.sun_mesh.of_planet(0)."),
    ),
    MixedFault("M by J", edit(POSES + "equivalent_mass", "gear) ** 2", "gear)")),
    MixedFault("order of the waves", edit(SPRING + "waves", "(row + 1) * phase", "row * phase")),
    MixedFault(
        "last harmonic lost", edit(SPRING + "square", "int(harmonics) + 1", "int(harmonics)")
    ),
    MixedFault("slopes of straight lines", edit(SPRING + "_table", "range(PASSES)", "range(1)")),
    MixedFault("sign of a slope", edit(SPRING + "cubic", "- (1 - s) * width", "+ (1 - s) * width")),
    MixedFault(
        "mean of the rows",
        edit(SPRING + "_table", "float(width @ means)", "float(stiffness.mean())"),
    ),
]


def differences(answer: str) -> Iterator[float]:
    """Of the tiers' answers over the largest entry, arm by arm and state by state."""
    for arm in MIXED.values():
        run = scenario([30.0, -20.0, 10.0][: len(arm.joints)])
        tree, bodies = ExudynTree(arm, run), ExudynBodies(arm, run)
        for q, v in random_states(tree.layout, 3):
            state = (q,) if answer == MASS else (0.1, q, v)
            one, other = (getattr(tier, answer)(*state) for tier in (tree, bodies))
            yield float(abs(one - other).max() / abs(one).max())


@pytest.mark.parametrize("fault", IN_TREE, ids=lambda fault: fault.name)
def test_fault_in_the_tree_sets_the_tiers_apart(fault: MixedFault, monkeypatch: pytest.MonkeyPatch):
    interpret(monkeypatch, "exudyn:tree")
    fault.plant(monkeypatch)
    assert max(differences(fault.answer)) > 1e-8


@pytest.mark.parametrize("fault", IN_BODIES, ids=lambda fault: fault.name)
def test_fault_in_the_bodies_sets_the_tiers_apart(
    fault: MixedFault, monkeypatch: pytest.MonkeyPatch
):
    interpret_bodies(monkeypatch)
    fault.plant(monkeypatch)
    assert max(differences(fault.answer)) > 1e-8


@pytest.mark.parametrize("answer", [MASS, FORCE])
def test_without_a_fault_the_tiers_agree(answer: str, monkeypatch: pytest.MonkeyPatch):
    interpret(monkeypatch, "exudyn:tree")
    interpret_bodies(monkeypatch)
    # Deflections near 1e-4 m out of places near 1 m.
    assert max(differences(answer)) < 1e-11
