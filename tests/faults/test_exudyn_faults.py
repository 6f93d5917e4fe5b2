"""Faults in the Exudyn tree, its meshes and its engine, and the check that sees each."""

from __future__ import annotations

import pytest

from tests.faults.faults import (
    BIAS,
    CONTACT,
    DIRECT,
    EQ13,
    FORCE,
    MASS,
    OMEGA_T,
    SHIFTED_TABLE,
    TANH,
    UNLIKE,
    Fault,
    assert_seen,
    edit,
)

TREE, MESH, ENGINE = (
    "crosscheck.models.exudyn.tree.tree:",
    "crosscheck.models.exudyn.tree.mesh:",
    "crosscheck.models.exudyn.engine:",
)
PARTS, STIFFNESS = (
    "crosscheck.models.exudyn.tree.parts:",
    "crosscheck.models.exudyn.tree.stiffness:",
)
LAWS, LOADS = "crosscheck.models.exudyn.tree.laws:", "crosscheck.models.exudyn.tree.loads:"
RECORDS, TEETH = TREE + "ExudynTree._mesh_records", TREE + "ExudynTree._place_teeth"
THETA, X_SP, X_PR = "same-step/theta", "same-step/x_sp", "same-step/x_pr"
F_SP, F_PR = "same-step/F_sp", "same-step/F_pr"
SINUSOID = {"drive": "sinusoid"}

BODIES = [
    Fault("rod about its end", edit(PARTS + "_link", "**2 / 12", "**2 / 3"), MASS),
    Fault(
        "centre of mass at half length",
        edit(PARTS + "_link", "rod, link.com_m", "rod, link.length_m / 2"),
        MASS,
    ),
    Fault(
        "payload at the elbow",
        edit(PARTS + "_far_end", "payload_mass_kg, at", "payload_mass_kg, 0.0"),
        MASS,
    ),
    Fault(
        "carrier's inertia by the planet's radius",
        edit(LAWS + "_gear", "joint.sun_teeth + joint.planet_teeth", "joint.planet_teeth"),
        MASS,
    ),
    Fault(
        "ring of the wrong joint",
        edit(PARTS + "_far_end", "arm.joints[place + 1]", "arm.joints[place]"),
        MASS,
    ),
    Fault(
        "ring without inertia", edit(PARTS + "_far_end", "outer.ring_inertia_kg_m2", "0.0"), MASS
    ),
    Fault(
        "parallel axes forgotten", edit(PARTS + "_composite", " + mass @ (x - com) ** 2", ""), MASS
    ),
    Fault(
        "sun on the link that it drives",
        edit(PARTS + "bodies_of", "Body(parent, axis, mass", "Body(stage.link, (0.0, 0.0), mass"),
        MASS,
    ),
    Fault(
        "sun's inertia by the planet's radius",
        edit(LAWS + "_gear", "sun_inertia_kg_m2, joint.sun", "sun_inertia_kg_m2, joint.planet"),
        MASS,
    ),
    Fault("planets on half the circle", edit(PARTS + "_planets", "2 * np.pi", "np.pi"), MASS),
    Fault(
        "planets on the base circle",
        edit(PARTS + "_planets", "/ 2\n", "/ 2 * np.cos(np.radians(joint.pressure_angle_deg))\n"),
        MASS,
    ),
    Fault(
        "planets without orbit inertia",
        edit(PARTS + "_planets", "joint.planet_mass_kg or NO_MASS", "1e-9"),
        MASS,
    ),
    Fault(
        "pitch for base radius",
        edit(
            LAWS + "base_radius", "/ 2 * float(np.cos(np.radians(joint.pressure_angle_deg)))", "/ 2"
        ),
        MASS,
    ),
    Fault(
        "planet's spin sign",
        edit(PARTS + "tree_from_paper", "-ring / planet", "ring / planet"),
        MASS,
    ),
    Fault(
        "sun turns in the link instead of its base",
        edit(PARTS + "tree_from_paper", "(sun + ring) / sun", "ring / sun"),
        MASS,
    ),
    Fault(
        "sign of the right-hand side",
        edit(TREE + "ExudynTree.bias", "-self.from_paper.T", "self.from_paper.T"),
        BIAS,
    ),
    Fault(
        "Coriolis force of other rates",
        edit(ENGINE + "System.put", "SetODE2Coordinates_t(v", "SetODE2Coordinates_t(v / 2"),
        BIAS,
    ),
    Fault("gravity left on", edit(ENGINE + "_tree", "[*gravity, 0.0]", "[0.0, -9.81, 0.0]"), BIAS),
]

FORCES = [
    Fault(
        "motor torque without 1/n",
        edit(LOADS + "add_joints", "torque / joints.ratios[joint]", "torque"),
        FORCE,
    ),
    Fault("ratio without the ring's turn", edit(LOADS + "_ratio", " + 1", ""), FORCE),
    Fault("motor on the link", edit(LOADS + "add_joints", "forces[driven]", "forces[link]"), FORCE),
    Fault(
        "motor with the shoulder's gains",
        edit(LOADS + "add_joints", "drive.gains[joint]", "drive.gains[0]"),
        FORCE,
    ),
    Fault("force's clock stands", edit(LOADS + "loads", "clock[0] + t", "t"), FORCE, OMEGA_T),
    Fault(
        "motor's clock stands",
        edit(LOADS + "loads_on_tree", "joints, t", "joints, 0.0"),
        FORCE,
        **SINUSOID,
    ),
    Fault(
        "sun mesh without the carrier's reaction",
        edit(MESH + "add_sun_mesh", "forces[link] += law[WHEEL_RADIUS]", "forces[link] += 0.0"),
        FORCE,
    ),
    Fault(
        "sun mesh without the sun's reaction",
        edit(MESH + "add_sun_mesh", "forces[sun] -= law[WHEEL_RADIUS]", "forces[sun] -= 0.0"),
        FORCE,
    ),
    Fault(
        "sign on the planet",
        edit(MESH + "add_sun_mesh", "forces[planet] -=", "forces[planet] +="),
        FORCE,
    ),
    Fault(
        "sign on the carrier",
        edit(MESH + "add_ring_mesh", "forces[link] +=", "forces[link] -="),
        FORCE,
    ),
    Fault(
        "meshes of the shoulder everywhere",
        edit(MESH + "add_meshes", "gears.sun_laws[row]", "gears.sun_laws[0]"),
        FORCE,
    ),
    Fault(
        "ring meshes' laws read where the sun's are",
        edit(LOADS + "unpacked", "numbers[laws : 2 * laws]", "numbers[:laws]"),
        FORCE,
    ),
    Fault(
        "last planet forgotten", edit(MESH + "gearing", "s.planets[-1] + 1", "s.planets[-1]"), FORCE
    ),
    Fault(
        "meshes' clock stands",
        edit(LOADS + "loads_on_tree", "add_meshes(gears, t", "add_meshes(gears, 0.0"),
        FORCE,
        OMEGA_T,
    ),
    Fault(
        "ring mesh as an external one",
        edit(LAWS + "mesh_law", "else -planet_radius", "else planet_radius"),
        FORCE,
    ),
    Fault(
        "ring's teeth for the planet's",
        edit(LAWS + "mesh_law", "else joint.ring_teeth", "else joint.planet_teeth"),
        FORCE,
    ),
    Fault(
        "every mesh has the damping of all",
        edit(LAWS + "_damping", "mass)) / planets", "mass))"),
        FORCE,
    ),
    Fault(
        "every mesh has the direct damping of all",
        edit(LAWS + "_damping", "_N_s_per_m / planets", "_N_s_per_m"),
        FORCE,
    ),
    Fault(
        "damping by one planet's mass",
        edit(LAWS + "_damping", "planets * planet_mass", "planet_mass"),
        FORCE,
    ),
    Fault(
        "ring mesh with the sun mesh's direct damping",
        edit(LAWS + "_damping", "return mesh", "return joint.sun_mesh"),
        FORCE,
    ),
    Fault(
        "ring phase lost", edit(LAWS + "mesh_law", "planet, mesh.phase_rad", "planet, 0.0"), FORCE
    ),
    Fault(
        "corrected ring rate is Eq. 13's",
        edit(LAWS + "_phase_rate", ' or chosen.ring_rate == "corrected"', ""),
        FORCE,
    ),
    Fault("sign in Eq. 13", edit(LAWS + "_phase_rate", "planet - 1", "planet + 1"), FORCE, EQ13),
    Fault(
        "deflection without the carrier",
        edit(MESH + "stretch", "(wheel - carrier)", "wheel"),
        FORCE,
    ),
    Fault(
        "damper by the absolute sun",
        edit(MESH + "add_sun_mesh", "q_t[planet], q_t[link]", "q_t[planet], 0.0"),
        FORCE,
    ),
    Fault("tooth error sign", edit(MESH + "elastic_force", "x - error", "x + error"), FORCE),
    Fault(
        "stiffness varies the other way",
        edit(STIFFNESS + "stiffness_at", "MEAN] + law", "MEAN] - law"),
        FORCE,
    ),
    Fault(
        "clearance on one flank only", edit(MESH + "clearance", "return x + b", "return 0.0"), FORCE
    ),
    Fault(
        "clearance b instead of 2 b",
        edit(
            MESH + "elastic_force",
            "clearance(gap, law[BACKLASH])\n    return",
            "clearance(gap, law[BACKLASH] / 2)\n    return",
        ),
        FORCE,
    ),
    Fault(
        "sign in the smooth clearance",
        edit(MESH + "smooth_clearance", "upper - lower", "upper + lower"),
        FORCE,
        TANH,
    ),
    Fault(
        "exact clearance whatever the switch",
        edit(LAWS + "mesh_law", 'chosen.dead_zone == "tanh"', "False"),
        FORCE,
        TANH,
    ),
    Fault(
        "phase without time", edit(MESH + "variation", "theta_dot * t", "theta_dot"), FORCE, OMEGA_T
    ),
    Fault(
        "phase by the clock whatever the switch",
        edit(LAWS + "mesh_law", 'chosen.phase == "omega_t"', "True"),
        FORCE,
    ),
    Fault(
        "dampers act in free play",
        edit(LAWS + "mesh_law", 'chosen.damping == "contact"', "False"),
        FORCE,
        CONTACT,
    ),
    Fault(
        "contact judged without the tooth error",
        edit(MESH + "damping_force", "x - error", "x"),
        FORCE,
        CONTACT,
    ),
]

RUNS = [
    Fault("integrator of order 3", edit(ENGINE + "_settings", "RK44", "RK33"), X_SP),
    Fault(
        "steps 0.1 percent too long",
        edit(ENGINE + "Engine.advance", "steps * step_s", "1.001 * steps * step_s"),
        THETA,
    ),
    Fault(
        "start at rest", edit(TREE + "ExudynTree.start", "start.theta_dot_rad_per_s", "0.0"), THETA
    ),
    Fault("start away from contact", edit(TEETH, '== "contact"', '== "centre"'), X_SP),
    Fault(
        "offsets of the start swapped",
        edit(TEETH, "start.planet_ring_offset_m", "start.sun_planet_offset_m"),
        X_PR,
    ),
    Fault(
        "clock of a run stands",
        edit(TREE + "ExudynTree.simulate", "engine.place(t, q, v)", "engine.place(0.0, q, v)"),
        X_SP,
        OMEGA_T,
    ),
    Fault("motor's clock stands", edit(LOADS + "loads", "clock[0] + t", "t"), THETA, **SINUSOID),
    Fault(
        "ring mesh recorded with the sun",
        edit(RECORDS, "planet, q, with_sun=side == 0", "planet, q, with_sun=True"),
        X_PR,
    ),
    Fault("sun's sign in the record", edit(MESH + "deflection", "wheel - q", "wheel + q"), X_SP),
    Fault(
        "forces recorded with the shoulder's phase",
        edit(RECORDS, "x[at], q[:, link]", "x[at], q[:, 0]"),
        F_SP,
    ),
    Fault(
        "forces recorded without the clock",
        edit(RECORDS, "law.array, time,", "law.array, 0 * time,"),
        F_PR,
        OMEGA_T,
    ),
]

SECOND_VERSION = [
    Fault(
        "weights lift",
        edit(ENGINE + "_tree", "[*gravity, 0.0]", "[*(-g for g in gravity), 0.0]"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "gravity along the other axis",
        edit(ENGINE + "_tree", "[*gravity, 0.0]", "[*gravity[::-1], 0.0]"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction pushes",
        edit(LOADS + "add_joints", "forces[link] -=", "forces[link] +="),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction on the sun",
        edit(LOADS + "add_joints", "forces[link] -=", "forces[driven] -="),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction read where the ratios are",
        edit(LOADS + "unpacked", "numbers[ratio + count :])", "numbers[ratio : ratio + count])"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction of the shoulder everywhere",
        edit(LOADS + "add_joints", "friction[joint]", "friction[0]"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "motor without mass",
        edit(PARTS + "_far_end", "outer.motor_mass_kg", "0.0"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "rotor without inertia",
        edit(PARTS + "_link_parts", "joint.rotor_inertia_kg_m2", "0.0"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "rotor on the link before as well",
        edit(
            PARTS + "_far_end",
            "motor_mass_kg, at, 0.0",
            "motor_mass_kg, at, outer.rotor_inertia_kg_m2",
        ),
        MASS,
        arm=DIRECT,
    ),
    Fault("direct joint with a ratio", edit(LOADS + "_ratio", "1.0", "2.0"), FORCE, arm=DIRECT),
    Fault(
        "last harmonic lost",
        edit(STIFFNESS + "waves_at", "first + rows)", "first + rows - 1)"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "square wave's sines and cosines swapped",
        edit(STIFFNESS + "_square", "cosines, sines = size", "sines, cosines = size"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "table shifted by a row",
        edit(STIFFNESS + "curve_of", "law.stiffness_N_per_m", SHIFTED_TABLE),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "straight lines between a table's rows",
        edit(STIFFNESS + "spline_at", "straight + bent", "straight + 0 * bent"),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "ring with the sun's law",
        edit(LAWS + "mesh_law", "curve_of(mesh.", "curve_of(joint.sun_mesh."),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "ring with the sun's clearance",
        edit(LAWS + "mesh_law", "=mesh.backlash_m", "=joint.sun_mesh.backlash_m"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "damping by inertia over the radius alone",
        edit(LAWS + "equivalent_mass", "radius**2", "radius"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "link's inertia about its joint",
        edit(
            PARTS + "_link",
            "link.com_m, link.inertia_kg_m2",
            "link.com_m, link.inertia_kg_m2 - link.mass_kg * link.com_m**2",
        ),
        MASS,
        arm=UNLIKE,
    ),
    Fault(
        "friction missing in a run",
        edit(LOADS + "joints_of", "joint.friction_N_m_s_per_rad", "0.0"),
        THETA,
        arm=UNLIKE,
    ),
    Fault(
        "weights lift in a run",
        edit(ENGINE + "_tree", "[*gravity, 0.0]", "[*(-g for g in gravity), 0.0]"),
        THETA,
        arm=UNLIKE,
    ),
]

FAULTS = [*BODIES, *FORCES, *RUNS, *SECOND_VERSION]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_fault_turns_its_check_red(fault: Fault):
    assert_seen(fault, "exudyn:tree", "analytic:physical")
