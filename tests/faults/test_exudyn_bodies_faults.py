"""Faults in Exudyn's separate bodies, their contacts, joints and engine, and what sees each."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import pytest

from crosscheck.findings import Finding
from crosscheck.models.exudyn.bodies.bodies import ExudynBodies
from crosscheck.models.exudyn.tree.tree import ExudynTree
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import Case, load_case
from crosscheck.models.pinocchio.gears import PinocchioGears
from tests.engines.bodies_checks import joint_gaps, wrenches
from tests.faults.bodies_interpreted import interpret
from tests.faults.faults import (
    ACCELERATION,
    BIAS,
    CONTACT,
    DIRECT,
    EQ13,
    FORCE,
    MASS,
    OMEGA_T,
    SEED,
    SHIFTED_TABLE,
    STATES,
    TANH,
    UNLIKE,
    Fault,
    Setup,
    edit,
)
from tests.judged import compare_states, refined

BODIES, MESH = "crosscheck.models.exudyn.bodies.bodies:", "crosscheck.models.exudyn.bodies.contact:"
STIFFNESS = "crosscheck.models.exudyn.bodies.stiffness:"
POSES, ENGINE = "crosscheck.models.exudyn.bodies.poses:", "crosscheck.models.exudyn.bodies.engine:"
WRENCHES, JOINTS = "bodies/wrenches", "bodies/joints"
THETA, X_SP, X_PR = "refined/theta", "refined/x_sp", "refined/x_pr"


PARTS = [
    Fault("rod about its end", edit(POSES + "_bare_link", "**2 / 12", "**2 / 3"), MASS),
    Fault(
        "ring of the wrong joint",
        edit(POSES + "link_parts", "arm.joints[place + 1]", "arm.joints[place]"),
        MASS,
    ),
    Fault("parallel axes forgotten", edit(ENGINE + "_part", "part.mass * part.x**2", "0.0"), MASS),
    Fault(
        "pitch for base radius",
        edit(POSES + "base_radius", " * float(np.cos(np.radians(joint.pressure_angle_deg)))", ""),
        MASS,
    ),
    Fault(
        "planets not spread all round",
        edit(POSES + "planet_seats", "joint.planet_count\n", "joint.planet_count * 0.9\n"),
        MASS,
    ),
    Fault("planet's spin sign", edit(POSES + "turns_of", "base - along", "base + along"), MASS),
    Fault(
        "elbow's planets without the shoulder's rotation",
        edit(POSES + "turns_of", "base - along", "-along"),
        MASS,
    ),
    Fault(
        "sun without the carrier's second turn",
        edit(POSES + "turns_of", "along_planets[0] + (r_s + r_p) * theta", "along_planets[0]"),
        MASS,
    ),
    Fault(
        "sign of the inertial forces", edit(BODIES + "ExudynBodies.bias", "- eng", "+ eng"), BIAS
    ),
    Fault(
        "no centripetal acceleration of the poses",
        edit(POSES + "PoseMap.acceleration", " - spin**2", ""),
        BIAS,
    ),
    Fault(
        "no centripetal acceleration of the joints",
        edit(
            ENGINE + "BodyEngine.solve", "right_hand_side(), -swing", "right_hand_side(), 0 * swing"
        ),
        ACCELERATION,
    ),
    Fault(
        "elbow hinged at the shoulder",
        edit(ENGINE + "BodyEngine._add_bodies", "body.seat, first", "0j, first"),
        JOINTS,
    ),
    Fault(
        "lever of a body on the wrong link",
        edit(POSES + "levers_of", "links.index(body.seat_body)", "0"),
        JOINTS,
    ),
    Fault(
        "rates of the poses without the previous links'",
        edit(POSES + "PoseMap.velocity", "spin[self.links]", "v[2::3]"),
        JOINTS,
    ),
]

CONTACTS = [
    Fault("ring as an external mesh", edit(MESH + "mesh_of", "else -1.0", "else 1.0"), FORCE),
    Fault(
        "r_c for r_s",
        edit(MESH + "mesh_of", "sun_teeth if", "sun_teeth + joint.planet_teeth if"),
        FORCE,
    ),
    Fault("deflection on the pitch circles", edit(MESH + "look", "mesh.cosine * (", "("), FORCE),
    Fault(
        "planet's turn against the line of centres lost",
        edit(MESH + "look", "(planet.angle - turn)", "planet.angle"),
        FORCE,
    ),
    Fault(
        "full turns lost",
        edit(MESH + "turned", " + 2 * np.pi * np.round((carrier - angle) / (2 * np.pi))", " + 0.0"),
        FORCE,
    ),
    Fault("where the planet began forgotten", edit(MESH + "turned", "- direction", ""), FORCE),
    Fault(
        "elbow's ring at the shoulder",
        edit(MESH + "mesh_of", "0.0 if sun else ring_at", "0.0"),
        FORCE,
    ),
    Fault(
        "ring does not turn with its body",
        edit(MESH + "look", "np.exp(1j * body.angle)", "(1 + 0j)"),
        FORCE,
    ),
    Fault(
        "slip of the planet alone",
        edit(MESH + "look", "slip = carried", "slip = 0 * carried"),
        FORCE,
    ),
    Fault(
        "wheel's reaction torque lost",
        edit(MESH + "mesh_forces", "contact.wheel_lever, -push", "0j, -push"),
        FORCE,
    ),
    Fault("wheel's reaction lost", edit(MESH + "mesh_forces", "-push", "0 * push"), FORCE),
    Fault("sign of the reaction", edit(MESH + "mesh_forces", "-push", "push"), FORCE),
    Fault(
        "no radial part",
        edit(MESH + "line_of_action", " + np.sign(flank) * mesh.side * mesh.sine * along", ""),
        WRENCHES,
    ),
    Fault(
        "one flank's radial part", edit(MESH + "line_of_action", "np.sign(flank) * ", ""), WRENCHES
    ),
    Fault("ring pulls its planets", edit(MESH + "line_of_action", "mesh.side * ", ""), WRENCHES),
    Fault("every mesh with all damping", edit(MESH + "damping_of", " / count", ""), FORCE),
    Fault(
        "one planet's mass", edit(MESH + "damping_of", "count * equivalent", "equivalent"), FORCE
    ),
    Fault("tooth error sign", edit(MESH + "gap_of", "- mesh.error", "+ mesh.error"), FORCE),
    Fault(
        "stiffness sign",
        edit(STIFFNESS + "stiffness_at", "mean + numbers[0, 0]", "mean - numbers[0, 0]"),
        FORCE,
    ),
    Fault("one flank", edit(MESH + "dead_zone", "min(max(gap, -b), b)", "min(gap, b)"), FORCE),
    Fault("sign of Eq. 6", edit(MESH + "rounded_dead_zone", "- below", "+ below"), FORCE, TANH),
    Fault(
        "contact without tooth error",
        edit(MESH + "damping_force", "gap_of(mesh, contact)", "contact.x"),
        FORCE,
        CONTACT,
    ),
    Fault("phase of the link in space", edit(MESH + "mesh_phase", " - previous.angle", ""), FORCE),
    Fault(
        "clock of the link in space",
        edit(MESH + "mesh_phase", "(carrier.spin - previous.spin)", "carrier.spin"),
        FORCE,
        OMEGA_T,
    ),
    Fault(
        "ring phase lost", edit(MESH + "mesh_of", "None else own.phase_rad", "None else 0.0"), FORCE
    ),
    Fault("sign in Eq. 13", edit(MESH + "teeth_passing", "- 1)", "+ 1)"), FORCE, EQ13),
]

MOTORS = [
    Fault("torque without 1/n", edit(BODIES + "motor", "torque / ratio", "torque"), FORCE),
    Fault("ratio without the ring", edit(BODIES + "motor", "sun_teeth + 1", "sun_teeth"), FORCE),
    Fault("reaction lost", edit(BODIES + "motor", "drag - on_driven", "drag"), FORCE),
    Fault(
        "reaction on the driven link",
        edit(BODIES + "motor", "torques[-1] = drag", "torques[link] += drag"),
        FORCE,
    ),
    Fault("angle in space sensed", edit(BODIES + "motor", "theta - q[-1]", "theta"), FORCE),
    Fault("shoulder's gains", edit(BODIES + "motor", "law.gains[place]", "law.gains[0]"), FORCE),
]

START, PLACED = BODIES + "ExudynBodies.start", BODIES + "ExudynBodies._place_planets"
RUNS = [
    Fault("start at rest", edit(START, "start.theta_dot_rad_per_s", "0.0"), THETA),
    Fault("start in play", edit(PLACED, '== "contact"', '== "centre"'), X_SP),
    Fault(
        "offsets swapped",
        edit(
            PLACED,
            "start.sun_planet_offset_m, start.planet_ring_offset_m",
            "start.planet_ring_offset_m, start.sun_planet_offset_m",
        ),
        X_PR,
    ),
    Fault(
        "engine starts with other rates",
        edit(ENGINE + "BodyEngine.run", "(0.0, pose, velocity)", "(0.0, pose, 0.999 * velocity)"),
        THETA,
    ),
    Fault(
        "sides swapped in the record",
        edit(BODIES + "ExudynBodies._mesh_records", '"x_sp": read[0, 0]', '"x_sp": read[1, 0]'),
        X_SP,
    ),
]

SECOND_VERSION = [
    Fault(
        "weights lift",
        edit(ENGINE + "BodyEngine._add_weight", "[*gravity, 0.0]", "[*(-g for g in gravity), 0.0]"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "weight of the links alone",
        edit(ENGINE + "BodyEngine._add_bodies", "for part in parts:", "for part in parts[:1]:"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction pushes",
        edit(BODIES + "motor", "torques[link] -= drag", "torques[link] += drag"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction without reaction",
        edit(BODIES + "motor", "drag - on_driven", "-on_driven"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction of the rate in space",
        edit(BODIES + "motor", "friction * theta_dot", "friction * q_t[link]"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "motor without mass",
        edit(POSES + "link_parts", "outer.motor_mass_kg", "0.0"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "rotor without inertia",
        edit(POSES + "link_parts", "joint.rotor_inertia_kg_m2", "0.0"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "direct joint with a ratio",
        edit(BODIES + "motor", "else 1.0", "else 2.0"),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "last harmonic lost",
        edit(STIFFNESS + "waves", "len(numbers)", "len(numbers) - 1"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "last harmonic of the square wave lost",
        edit(STIFFNESS + "square", "int(harmonics) + 1", "int(harmonics)"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "table shifted by a row",
        edit(STIFFNESS + "_table", "law.stiffness_N_per_m", SHIFTED_TABLE),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "slopes of a table from its neighbours alone",
        edit(STIFFNESS + "_table", "range(PASSES)", "range(1)"),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "ring with the sun's law",
        edit(MESH + "mesh_of", "spring_of(own.", "spring_of(joint.sun_mesh.of_planet(0)."),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "ring with the sun's tooth error",
        edit(MESH + "mesh_of", "=own.tooth_error_m", "=joint.sun_mesh.of_planet(0).tooth_error_m"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "inertia over the radius alone",
        edit(POSES + "equivalent_mass", "** 2", "** 1"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "link's inertia of a rod of its mass",
        edit(
            POSES + "_bare_link",
            "    assert mass is not None",
            "    inertia = mass * link.length_m**2 / 12",
        ),
        MASS,
        arm=UNLIKE,
    ),
]

FAULTS = [*PARTS, *CONTACTS, *MOTORS, *RUNS, *SECOND_VERSION]


def found(red_check: str, setup: Setup) -> Finding:
    """The named check, with whatever is planted in the bodies."""
    kind, quantity = red_check.split("/")
    findings = {"states": _states, "refined": _refined, "bodies": _bodies}[kind](setup.case)
    return next(finding for finding in findings if finding.quantity == quantity)


def _states(case: Case) -> Iterable[Finding]:
    models = [kind(*case) for kind in (PinocchioGears, ExudynBodies)]
    return compare_states("planted", models, STATE_ABILITIES, STATES, SEED)


def _bodies(case: Case) -> Iterable[Finding]:
    settings = ("scenario.drive.torque_N_m=0.0",)
    still = load_case("paper-labelled", "constant-torque", {}, settings).scenario
    model = ExudynBodies(case.arm, still, case.switches)
    return joint_gaps(model), wrenches(model, PinocchioGears(model.arm, still, model.switches))


def _refined(case: Case) -> Iterable[Finding]:
    bodies, tree = (
        tuple(kind(*_short(case, step)).simulate() for step in (1e-6, 2e-6))
        for kind in (ExudynBodies, ExudynTree)
    )
    return refined("planted", _short(case, 1e-6), bodies, tree)


def _short(case: Case, step_s: float) -> Case:
    """0.2 ms from the start in motion."""
    grid = {"duration_s": 2e-4, "step_s": step_s, "record_every": round(2e-5 / step_s)}
    return case._replace(scenario=case.scenario.model_copy(update=grid))


@lru_cache
def _control(red_check: str, setup: Setup) -> str:
    with pytest.MonkeyPatch.context() as patch:
        interpret(patch)
        return found(red_check, setup).verdict


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_fault_turns_its_check_red(fault: Fault, monkeypatch: pytest.MonkeyPatch):
    assert _control(fault.red_check, fault.setup) == "agree"
    if not fault.red_check.startswith("refined"):  # whole runs need the compiled functions' speed
        interpret(monkeypatch)
    fault.plant(monkeypatch)
    assert found(fault.red_check, fault.setup).verdict == "differ"
