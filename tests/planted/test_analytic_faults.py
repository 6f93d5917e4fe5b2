"""Faults in the analytic model, and the check that sees each."""

from __future__ import annotations

import pytest

from tests.planted.faults import (
    ACCELERATION,
    BIAS,
    CONTACT,
    EQ13,
    FORCE,
    MASS,
    OMEGA_T,
    TANH,
    Fault,
    Plant,
    assert_seen,
    edit,
)

THETA, X_SP, X_PR = "same-step/theta", "same-step/x_sp", "same-step/x_pr"
F_SP = "same-step/F_sp"


def change(function: str, old: str, new: str) -> Plant:
    return edit(f"analytic.{function}", old, new)


BODIES = [
    Fault(
        "planet's spin sign",
        change("physical:spinning_bodies", "base - theta_p", "base + theta_p"),
        MASS,
    ),
    Fault(
        "elbow's planets without the shoulder's rotation",
        change("physical:spinning_bodies", "base - theta_p", "-theta_p"),
        MASS,
    ),
    Fault(
        "elbow's sun without the shoulder's rotation",
        change("physical:spinning_bodies", "base + theta_s", "theta_s"),
        MASS,
    ),
    Fault(
        "one planet spins", change("physical:spinning_bodies", "stage.N * planet", "planet"), MASS
    ),
    Fault(
        "planets on the base circle",
        change("physical:carrier_bodies", "stage.r_c**2", "stage.r_cp**2"),
        MASS,
    ),
    Fault(
        "planets without orbit inertia",
        change(
            "physical:carrier_bodies",
            "stage.N * stage.m_p, orbit",
            "stage.N * stage.m_p, sp.S.Zero",
        ),
        MASS,
    ),
    Fault(
        "orbit of one planet",
        change("physical:carrier_bodies", "orbit = stage.N * ", "orbit = "),
        MASS,
    ),
    Fault(
        "ring on the link that it drives",
        change(
            "physical:carrier_bodies", "stage.J_r, angles[joint - 1]", "stage.J_r, angles[joint]"
        ),
        MASS,
    ),
    Fault(
        "centre of mass at half length",
        change("physical:link_bodies", "stage.d)", "stage.L / 2)"),
        MASS,
    ),
    Fault(
        "payload at the centre of mass",
        change("physical:link_bodies", "stage.L)", "stage.d)"),
        MASS,
    ),
    Fault(
        "elbow at its own link's length",
        change("physical:_joint_centre", "stage_symbols(k)", "stage_symbols(joint)"),
        MASS,
    ),
    Fault(
        "sun's angle over the planet's radius",
        change("kinematics:gear_angles", "/ r_s", "/ r_p"),
        MASS,
    ),
    Fault("carrier counted once", change("kinematics:gear_angles", "2 * r_cp", "r_cp"), MASS),
    Fault(
        "pitch for base radius",
        change("kinematics:stage_geometry", "sun_teeth / 2 * cos_alpha", "sun_teeth / 2"),
        MASS,
    ),
    Fault(
        "r_c for r_cp",
        change("kinematics:stage_geometry", "r_cp=r_c * cos_alpha", "r_cp=r_c"),
        MASS,
    ),
    Fault("rod about its end", change("symbols:_stage_values", "**2 / 12", "**2 / 3"), MASS),
    Fault(
        "masses of sun and planet swapped",
        change(
            "symbols:_stage_values",
            "joint.sun_mass_kg,\n        joint.planet_mass_kg",
            "joint.planet_mass_kg, joint.sun_mass_kg",
        ),
        MASS,
    ),
    Fault(
        "only half of the kinetic energy's slope",
        change("lagrange:christoffel_bias", "[0] / 2", "[0] / 4"),
        BIAS,
    ),
    Fault(
        "no Coriolis force from a changing mass matrix",
        change("lagrange:christoffel_bias", "(changing - slope)", "(-slope)"),
        BIAS,
    ),
    Fault("rates mistaken among the terms", change("terms:_bias_terms", "a, b))", "a, a))"), BIAS),
]

FORCES = [
    Fault("motor torque without 1/n", change("physical:_efforts", " / stage.n", ""), FORCE),
    Fault(
        "ratio without the ring's turn",
        change("kinematics:stage_geometry", "sun_teeth + 1", "sun_teeth"),
        FORCE,
    ),
    Fault(
        "motor without reaction on the link before",
        change("physical:_efforts", ", theta_s)]", ", theta_s + link_angles(joints)[joint - 1])]"),
        FORCE,
    ),
    Fault("one planet's force", change("physical:_efforts", "-stage.N * F_sp", "-F_sp"), FORCE),
    Fault(
        "sign of the ring mesh",
        change("physical:_efforts", "-stage.N * F_pr", "stage.N * F_pr"),
        FORCE,
    ),
    Fault("tooth error sign", change("mesh_force:mesh_force", "x - tooth", "x + tooth"), FORCE),
    Fault(
        "stiffness does not vary",
        change("mesh_force:mesh_force", "fundamental(sine, k_m, k_a)", "k_m"),
        FORCE,
    ),
    Fault(
        "clearance as Eq. 15 prints it",
        change("mesh_force:mesh_force", "dead_zone(gap, b)", "gap"),
        FORCE,
    ),
    Fault(
        "clearance 4 b instead of 2 b",
        change("mesh_force:mesh_force", "dead_zone(gap, b)", "dead_zone(gap, 2 * b)"),
        FORCE,
    ),
    Fault("sign on the other flank", change("backlash:dead_zone", "x + b", "x - b"), FORCE),
    Fault(
        "sign in the smooth clearance",
        change("backlash:dead_zone_tanh", "right - left", "right + left"),
        FORCE,
        TANH,
    ),
    Fault(
        "exact clearance whatever the switch",
        change("gears:gears", 'switches.dead_zone == "tanh"', "False"),
        FORCE,
        TANH,
    ),
    Fault(
        "corrected ring rate is Eq. 13's",
        change("mesh_frequency:ring_mesh_rate", "else 1", "else -1"),
        FORCE,
    ),
    Fault(
        "ring rate of Eq. 13 is corrected",
        change("mesh_frequency:ring_mesh_rate", "-1 if", "1 if"),
        FORCE,
        EQ13,
    ),
    Fault("phase of the wrong joint", change("gears:gears", "3 * (mesh // 2) + 2", "2"), FORCE),
    Fault(
        "phase without time",
        change("mesh_frequency:mesh_phase", "theta_dot * t", "theta_dot"),
        FORCE,
        OMEGA_T,
    ),
    Fault(
        "ring phase lost",
        change("gears:gears", "(0.0, joint.ring_mesh_phase_rad)", "(0.0, 0.0)"),
        FORCE,
    ),
    Fault(
        "stiffness of the wrong mesh",
        change("kernel:elastic_force", "gears.k_m[i]", "gears.k_m[0]"),
        FORCE,
    ),
    Fault(
        "damping of one planet",
        change("gears:damping", "stiffness * joint.sun", "stiffness / planets * joint.sun"),
        FORCE,
    ),
    Fault(
        "damping by one planet's mass",
        change("gears:damping", "stiffness * planets * joint", "stiffness * joint"),
        FORCE,
    ),
    Fault(
        "direct dampings swapped",
        change("gears:damping", "return direct[0], direct[1]", "return direct[1], direct[0]"),
        FORCE,
    ),
    Fault("damping pushes", change("kernel:generalized_force", "] -= gears", "] += gears"), FORCE),
    Fault(
        "dampers act in free play",
        change("gears:gears", 'switches.damping == "always"', "True"),
        FORCE,
        CONTACT,
    ),
    Fault(
        "contact judged without the tooth error",
        change("mesh_force:in_contact", "x - tooth_error(sine, E)", "x"),
        FORCE,
        CONTACT,
    ),
    Fault(
        "controller senses the mesh",
        change("kernel:torque", "(q.size // joints) - 1", "(q.size // joints) - 2"),
        FORCE,
    ),
    Fault(
        "Coriolis force pushes",
        change("kernel:acceleration_by", "-= room.gyroscopic", "+= room.gyroscopic"),
        ACCELERATION,
    ),
    Fault(
        "elimination adds",
        change("kernel:solve", "factor * right[column]", "-factor * right[column]"),
        ACCELERATION,
    ),
]

RUNS = [
    Fault(
        "twice the kinetic energy recorded",
        change("recording:along", "(matrix @ v) / 2", "(matrix @ v)"),
        "invariants/energy",
    ),
    Fault(
        "Coriolis force pushes",
        change("kernel:acceleration_by", "-= room.gyroscopic", "+= room.gyroscopic"),
        "invariants/power",
    ),
    Fault(
        "weight of a stage",
        change("kernel:runge_kutta_step", "+ 2 * s.a[2, i]", "+ 2 * s.a[1, i]"),
        X_SP,
    ),
    Fault(
        "last stage at half the step",
        change("kernel:runge_kutta_step", "h if stage == 3 else h / 2", "h / 2"),
        X_SP,
    ),
    Fault(
        "stages without their time",
        change("kernel:runge_kutta_step", "t + part,", "t,"),
        X_SP,
        OMEGA_T,
    ),
    Fault(
        "clock of a run stands",
        change("kernel:integrate", "k * step, step", "0.0, step"),
        THETA,
        (),
        "sinusoid",
    ),
    Fault(
        "start at rest",
        change("model:AnalyticModel.start", "start.theta_dot_rad_per_s", "0.0"),
        THETA,
    ),
    Fault(
        "start away from contact",
        change("model:AnalyticModel.start", '== "contact"', '== "centre"'),
        X_SP,
    ),
    Fault(
        "offsets of the start swapped",
        change(
            "model:AnalyticModel.start", "start.planet_ring_offset_m", "start.sun_planet_offset_m"
        ),
        X_PR,
    ),
    Fault(
        "forces recorded of the other mesh",
        change("model:AnalyticModel.record", "forces[:, offset::2]", "forces[:, 1 - offset :: 2]"),
        F_SP,
    ),
    Fault(
        "displacements recorded of the other mesh",
        change(
            "model:AnalyticModel.record",
            "self.gears.where[offset::2]",
            "self.gears.where[1 - offset :: 2]",
        ),
        X_SP,
    ),
    Fault(
        "forces recorded without the clock",
        change("recording:along", "elastic_forces(gears, time[k]", "elastic_forces(gears, time[0]"),
        F_SP,
        OMEGA_T,
    ),
]


@pytest.mark.parametrize("fault", [*BODIES, *FORCES], ids=lambda fault: fault.name)
def test_fault_turns_its_check_red(fault: Fault):
    assert_seen(fault, "analytic:physical", "pinocchio:gears")


@pytest.mark.parametrize("fault", RUNS, ids=lambda fault: fault.name)
def test_fault_in_a_run_turns_its_check_red(fault: Fault):
    assert_seen(fault, "analytic:physical", "exudyn:tree")
