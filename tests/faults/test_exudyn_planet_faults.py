"""Faults in what single planets of the Exudyn tree have, and the truth that each turns red."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import pytest

from tests.faults.faults import Plant, edit, interpret
from tests.outside_truth import test_exudyn_tree_planets as truths
from tests.outside_truth.tree_planets import unlike

TREE, MESH = "crosscheck.models.exudyn.tree.tree:", "crosscheck.models.exudyn.tree.mesh:"
LAWS, PARTS = "crosscheck.models.exudyn.tree.laws:", "crosscheck.models.exudyn.tree.parts:"
TEETH, RECORDS = TREE + "ExudynTree._place_teeth", TREE + "ExudynTree._mesh_records"
LAW, PASSED, TORQUES = LAWS + "mesh_law", LAWS + "passed", MESH + "add_turning_torques"
MESH_OF = "(joint.sun_mesh if sun else joint.ring_mesh).of_planet"

MESHES = partial(truths.test_every_planets_meshes_have_laws_of_their_own, unlike, "contact")
NEIGHBOUR = partial(truths.test_one_planet_unlike_its_neighbours_alone_differs, 2)
ACCELERATION = truths.test_unlike_planets_accelerate_as_mass_and_force_say
IN_STEP = partial(truths.test_lumped_planets_are_free_ones_in_step, "probe", "paper")
TURNED = partial(truths.test_turned_by_a_planets_spacing_each_meshes_as_the_next_one_did, True)
TEETH_SAY = partial(truths.test_phases_from_the_teeth, *truths.GEAR_SETS[1])
GIVEN = partial(truths.test_the_ring_mesh_from_teeth_follows_a_given_sun_mesh, *truths.GEAR_SETS[1])
GRADIENT = truths.test_conservative_force_is_minus_the_gradient_of_the_springs_energy
START = truths.test_each_planet_starts_at_its_own_contact_with_the_ring_and_one_with_the_sun
LUMPED_START = truths.test_lumped_planets_start_at_contact_with_the_error_that_stands_still
MOVED = partial(truths.test_a_planets_offset_at_the_start_moves_it_alone, "contact")
OWN_RECORDS = truths.test_records_are_every_planets_own
MODES = truths.test_modes_and_largest_step_follow_every_planets_own_stiffness
TRUTHS = (
    *(MESHES, NEIGHBOUR, ACCELERATION, IN_STEP, TURNED, TEETH_SAY, GIVEN),
    *(GRADIENT, START, LUMPED_START, MOVED, OWN_RECORDS, MODES),
)


class PlanetFault(NamedTuple):
    """A fault and the test that must fail with it."""

    name: str
    plant: Plant
    truth: Callable[[], None]


OF_LAWS = [
    PlanetFault(
        "a neighbour's backlash",
        edit(LAW, "=mesh.backlash_m", f"={MESH_OF}(planet - 1).backlash_m"),
        MESHES,
    ),
    PlanetFault(
        "a neighbour's amplitude",
        edit(LAW, "=mesh.tooth_error_m", f"={MESH_OF}(planet - 1).tooth_error_m"),
        MESHES,
    ),
    PlanetFault(
        "the first planet's stiffness",
        edit(LAW, "curve_of(mesh.stiffness)", f"curve_of({MESH_OF}(0).stiffness)"),
        MESHES,
    ),
    PlanetFault(
        "damping by the first planet's stiffness",
        edit(LAW, "curve.mean)", f"curve_of({MESH_OF}(0).stiffness).mean)"),
        MESHES,
    ),
    PlanetFault(
        "phase of the error lost", edit(LAW, "=mesh.tooth_error_phase_rad", "=0.0"), MESHES
    ),
    PlanetFault(
        "phase of the error in the stiffness too",
        edit(MESH + "variation", "law[OFFSET]", "law[OFFSET] + law[ERROR_PHASE]"),
        MESHES,
    ),
    PlanetFault("static error dropped", edit(LAW, "=mesh.static_error_m", "=0.0"), MESHES),
    PlanetFault(
        "static error's sign", edit(MESH + "variation", ", law[STATIC]", ", -law[STATIC]"), MESHES
    ),
    PlanetFault(
        "all planets with the first law", edit(MESH + "add_meshes", "row += 1", "row += 0"), MESHES
    ),
    PlanetFault(
        "stiffness never worked out again",
        edit(MESH + "_new", "not law.varies_as(before)", "False"),
        MESHES,
    ),
    PlanetFault(
        "laws compared without the stiffness",
        edit(
            MESH + "MeshLaw.varies_as",
            "self.array[ERROR:], other.array[ERROR:]",
            "self.array[ERROR:CURVE], other.array[ERROR:CURVE]",
        ),
        NEIGHBOUR,
    ),
    PlanetFault(
        "sun's turn of free planets without the ring's",
        edit(PARTS + "_free_rows", "-(sun + ring)", "-sun"),
        IN_STEP,
    ),
    PlanetFault(
        "planets in reverse order",
        edit(PARTS + "_free_rows", "enumerate(stage.planets)", "enumerate(stage.planets[::-1])"),
        ACCELERATION,
    ),
    PlanetFault(
        "modes of the first planet's springs",
        edit(TREE + "_linear", "tuple(map(law, gear.sun))", "3 * (law(gear.sun[0]),)"),
        MODES,
    ),
]

OF_PHASES = [
    PlanetFault(
        "planet's place backwards at the sun",
        edit(PASSED, "-2 * joint.sun_teeth", "2 * joint.sun_teeth"),
        MESHES,
    ),
    PlanetFault(
        "planet's place backwards at the ring",
        edit(PASSED, "(2 * joint.ring_teeth", "(-2 * joint.ring_teeth"),
        TURNED,
    ),
    PlanetFault(
        "both flanks of a planet in phase", edit(PASSED, "across = (", "across = 0 * ("), MESHES
    ),
    PlanetFault(
        "half a pitch for odd planets",
        edit(PASSED, "joint.planet_teeth - 1", "joint.planet_teeth"),
        TEETH_SAY,
    ),
    PlanetFault(
        "ring deaf to the given sun mesh", edit(LAWS + "_phase_offset", '"ring"', '"none"'), GIVEN
    ),
    PlanetFault(
        "sun mesh follows itself",
        edit(LAWS + "_phase_offset", "if given is not None", "if False"),
        GIVEN,
    ),
]

OF_WORK = [
    PlanetFault(
        "no work on the phase",
        edit(TREE + "ExudynTree._engine", '== "conservative"', '== "none"'),
        GRADIENT,
    ),
    PlanetFault(
        "work on the phase whatever the switch",
        edit(TREE + "ExudynTree._engine", '== "conservative"', '!= "none"'),
        MESHES,
    ),
    PlanetFault(
        "work on the phase pushes",
        edit(MESH + "turning_torque", "return -potential", "return potential"),
        GRADIENT,
    ),
    PlanetFault(
        "work of the stiffness forgotten",
        edit(MESH + "turning_torque", "= stiffness * travel", "= stiffness.real * travel"),
        GRADIENT,
    ),
    PlanetFault(
        "work of the error forgotten", edit(MESH + "turning_torque", "gap.imag)", "0.0)"), GRADIENT
    ),
    PlanetFault(
        "work on the sun's phase",
        edit(
            TORQUES, "forces[link] += turning_torque(of_sun", "forces[sun] += turning_torque(of_sun"
        ),
        GRADIENT,
    ),
    PlanetFault(
        "work of the ring meshes forgotten",
        edit(TORQUES, "turning_torque(of_ring", "0 * turning_torque(of_ring"),
        GRADIENT,
    ),
    PlanetFault("work of the first planet alone", edit(TORQUES, "row += 1", "row += 0"), GRADIENT),
]

OF_RUNS = [
    PlanetFault("last sun mesh to touch", edit(TEETH, "min(sun", "max(sun"), START),
    PlanetFault(
        "first planet's contact for all", edit(TEETH, "ring[planet] +", "ring[0] +"), START
    ),
    PlanetFault(
        "start without the static error",
        edit(TEETH, "law.backlash + law.static_error", "law.backlash"),
        LUMPED_START,
    ),
    PlanetFault("planet's offset lost", edit(TEETH, "by_ring + offset", "by_ring"), MOVED),
    PlanetFault(
        "sun stays behind its planets", edit(TEETH, "+ by_sun + by_ring", "+ by_sun"), MOVED
    ),
    PlanetFault(
        "forces recorded by the first law",
        edit(RECORDS, "[side][planet]", "[side][0]"),
        OWN_RECORDS,
    ),
    PlanetFault(
        "the first planet recorded for all",
        edit(MESH + "deflection", "stage.planets[planet]", "stage.planets[0]"),
        START,
    ),
]

FAULTS = [*OF_LAWS, *OF_PHASES, *OF_WORK, *OF_RUNS]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_fault_turns_its_truth_red(fault: PlanetFault, monkeypatch: pytest.MonkeyPatch):
    interpret(monkeypatch, "exudyn:tree")
    fault.plant(monkeypatch)
    with pytest.raises(AssertionError):
        fault.truth()


@pytest.mark.parametrize("truth", TRUTHS)
def test_without_a_fault_every_truth_holds(
    truth: Callable[[], None], monkeypatch: pytest.MonkeyPatch
):
    interpret(monkeypatch, "exudyn:tree")
    truth()
