"""Faults in the analytic model, and the check that sees each."""

from __future__ import annotations

import pytest

from crosscheck.analytic.kernel import program
from tests.faults.faults import (
    ACCELERATION,
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
    Plant,
    assert_seen,
    edit,
)

THETA, X_SP, X_PR = "same-step/theta", "same-step/x_sp", "same-step/x_pr"
F_SP = "same-step/F_sp"


def change(function: str, old: str, new: str) -> Plant:
    return edit(f"crosscheck.analytic.{function}", old, new)


LAST = "middle_stage(at(w, block * BLOCK), t, sqrt(t), table, h, 1.0)"
CURVE, CONSERVATIVE = "text.meshes:_curve", (("mesh_work", "conservative"),)
SENSED = "tuple(f'{k}_x{self.angles[joint - 1] - 1}' for k in 'qv')"


def template(old: str, new: str) -> Plant:
    """``old`` becomes ``new`` in the text around the equations."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        whole = program._STEPS
        assert whole.count(old) == 1, f"no single {old!r} to change"
        patch.setattr(program, "_STEPS", whole.replace(old, new))

    return plant


def left(stage: str, block: str, old: str, new: str) -> Plant:
    """``old`` becomes ``new`` in what a stage leaves in a block of rows."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        whole = getattr(program, stage)
        assert whole[block].count(old) == 1, f"no single {old!r} to change"
        patch.setitem(whole, block, whole[block].replace(old, new))

    return plant


BODIES = [
    Fault(
        "planet's spin sign",
        change("derivation.bodies:spinning_bodies", "base - theta_p", "base + theta_p"),
        MASS,
    ),
    Fault(
        "elbow's planets without the shoulder's rotation",
        change("derivation.bodies:spinning_bodies", "base - theta_p", "-theta_p"),
        MASS,
    ),
    Fault(
        "elbow's sun without the shoulder's rotation",
        change(
            "derivation.bodies:spinning_bodies",
            "base + chain.sun_row(joint)",
            "chain.sun_row(joint)",
        ),
        MASS,
    ),
    Fault(
        "one planet spins",
        change("derivation.bodies:spinning_bodies", "count * planet", "planet"),
        MASS,
    ),
    Fault(
        "planets on the base circle",
        change("derivation.bodies:carried_bodies", "stage.r_c**2", "stage.r_cp**2"),
        MASS,
    ),
    Fault(
        "planets without orbit inertia",
        change(
            "derivation.bodies:carried_bodies",
            "stage.N * stage.m_p, orbit",
            "stage.N * stage.m_p, 0",
        ),
        MASS,
    ),
    Fault(
        "orbit of one planet",
        change("derivation.bodies:carried_bodies", "orbit = stage.N * ", "orbit = "),
        MASS,
    ),
    Fault(
        "ring on the link that it drives",
        change("derivation.bodies:carried_bodies", "stage.J_r, before", "stage.J_r, after"),
        MASS,
    ),
    Fault(
        "centre of mass at half length",
        change("derivation.bodies:link_bodies", "stage.d)", "stage.L / 2)"),
        MASS,
    ),
    Fault(
        "payload at the centre of mass",
        change("derivation.bodies:link_bodies", "stage.L)", "stage.d)"),
        MASS,
    ),
    Fault(
        "elbow at its own link's length",
        change("derivation.chain:Chain.centre_of", "(stage.L for", "(self.stages[joint - 1].L for"),
        MASS,
    ),
    Fault(
        "sun's angle over the planet's radius",
        change("paper.kinematics:gear_angles", "/ r_s", "/ r_p"),
        MASS,
    ),
    Fault("carrier counted once", change("paper.kinematics:gear_angles", "2 * r_cp", "r_cp"), MASS),
    Fault(
        "pitch for base radius",
        change("paper.kinematics:stage_geometry", "sun_teeth / 2 * cos_alpha", "sun_teeth / 2"),
        MASS,
    ),
    Fault(
        "r_c for r_cp",
        change("paper.kinematics:stage_geometry", "r_cp=r_c * cos_alpha", "r_cp=r_c"),
        MASS,
    ),
    Fault(
        "rod about its end", change("derivation.stage:_link_inertia", "**2 / 12", "**2 / 3"), MASS
    ),
    Fault(
        "masses of sun and planet swapped",
        change(
            "derivation.stage:_gear_values",
            "joint.sun_mass_kg,\n        joint.planet_mass_kg",
            "joint.planet_mass_kg, joint.sun_mass_kg",
        ),
        MASS,
    ),
    Fault(
        "only half of the kinetic energy's slope",
        change("derivation.lagrange:bias_terms", "slope / 2", "slope / 4"),
        BIAS,
    ),
    Fault(
        "no Coriolis force from a changing mass matrix",
        change("derivation.lagrange:bias_terms", "max(j, k)] += slope", "max(j, k)] += 0 * slope"),
        BIAS,
    ),
    Fault(
        "rates mistaken among the terms",
        change("derivation.terms:chain_terms", "waves.number(w), a, b)", "waves.number(w), a, a)"),
        BIAS,
    ),
]

FORCES = [
    Fault(
        "motor torque without 1/n", change("derivation.efforts:drive_rows", " / stage.n", ""), FORCE
    ),
    Fault(
        "ratio without the ring's turn",
        change("paper.kinematics:stage_geometry", "sun_teeth + 1", "sun_teeth"),
        FORCE,
    ),
    Fault(
        "motor without reaction on the link before",
        change(
            "derivation.efforts:drive_rows",
            "chain.sun_row(joint)",
            "(chain.sun_row(joint) + chain.angles[joint - 1])",
        ),
        FORCE,
    ),
    Fault(
        "one planet's force", change("derivation.efforts:_stage_rows", "-stage.N * ", "-"), FORCE
    ),
    Fault(
        "sign of the ring mesh",
        change(
            "derivation.efforts:_stage_rows",
            "-stage.N",
            "(1 if mesh == MESHES[1] else -1) * stage.N",
        ),
        FORCE,
    ),
    Fault("tooth error sign", change("kernel.text.meshes:_mesh", "} - e_", "} + e_"), FORCE),
    Fault(
        "stiffness does not vary", change("kernel.numbers:_waves", "gears.k_a[mesh]", "0.0"), FORCE
    ),
    Fault(
        "clearance as Eq. 15 prints it",
        change("kernel.text.meshes:_travel", "{gap} - inside", "{gap}"),
        FORCE,
    ),
    Fault(
        "clearance 4 b instead of 2 b",
        change("kernel.text.meshes:_travel", 'f"b_{own}"', 'f"(2.0 * b_{own})"'),
        FORCE,
    ),
    Fault(
        "sign on the other flank",
        change("kernel.text.meshes:_travel", "-{b} if inside < -", "{b} if inside < -"),
        FORCE,
    ),
    Fault(
        "sign in the smooth clearance",
        change("kernel.text.meshes:_travel", "right - left", "right + left"),
        FORCE,
        TANH,
    ),
    Fault(
        "exact clearance whatever the switch",
        change("derivation.gears:gears", 'switches.dead_zone == "tanh"', "False"),
        FORCE,
        TANH,
    ),
    Fault(
        "corrected ring rate is Eq. 13's",
        change("paper.mesh_frequency:ring_mesh_rate", "else 1", "else -1"),
        FORCE,
    ),
    Fault(
        "ring rate of Eq. 13 is corrected",
        change("paper.mesh_frequency:ring_mesh_rate", "-1 if", "1 if"),
        FORCE,
        EQ13,
    ),
    Fault(
        "phase of the wrong joint",
        change("kernel.structure:Structure.turns", 'f"q_theta{joint}"', '"q_theta1"'),
        FORCE,
    ),
    Fault(
        "phase without time",
        change("kernel.structure:Structure.turns", "{joint} * t", "{joint}"),
        FORCE,
        OMEGA_T,
    ),
    Fault("ring phase lost", change("derivation.gears:gears", "entry.offset", "0.0"), FORCE),
    Fault(
        "stiffness of the wrong mesh",
        change("kernel.numbers:_of_mesh", "gears.k_m[mesh]", "gears.k_m[0]"),
        FORCE,
    ),
    Fault(
        "damping of one planet",
        change("derivation.gears:_damping", "stiffness = planets * ", "stiffness = "),
        FORCE,
    ),
    Fault(
        "damping by one planet's mass",
        change("derivation.gears:damping", "joint.planet_count * own", "own"),
        FORCE,
    ),
    Fault(
        "dampings swapped",
        change(
            "derivation.gears:damping",
            "joint.sun_mesh.of_planet(planet), joint.ring_mesh.of_planet(planet)",
            "joint.ring_mesh.of_planet(planet), joint.sun_mesh.of_planet(planet)",
        ),
        FORCE,
    ),
    Fault("damping pushes", change("kernel.text.terms:_taken", "-D_{mesh}", "D_{mesh}"), FORCE),
    Fault(
        "dampers act in free play",
        change("derivation.gears:gears", 'switches.damping == "always"', "True"),
        FORCE,
        CONTACT,
    ),
    Fault(
        "contact judged without the tooth error",
        change("kernel.text.meshes:_mesh", "abs(gap_", "abs(x_"),
        FORCE,
        CONTACT,
    ),
    Fault(
        "controller senses the mesh",
        change("kernel.text.terms:TermStructure.sensed", "super().sensed(joint)", SENSED),
        FORCE,
    ),
    Fault(
        "Coriolis force pushes",
        change("kernel.text.terms:_solve", '" - h{i}"', '" + h{i}"'),
        ACCELERATION,
    ),
    Fault(
        "elimination adds",
        change("kernel.text.terms:_solve", "- L{i} * r{pivot}", "+ L{i} * r{pivot}"),
        ACCELERATION,
    ),
]

RUNS = [
    Fault(
        "twice the kinetic energy recorded",
        change("kernel.equations:TermEquations.kinetic_energy", "q), v) / 2", "q), v)"),
        "invariants/energy",
        kernel="terms",
    ),
    Fault(
        "Coriolis force pushes",
        change("kernel.text.terms:_solve", '" - h{i}"', '" + h{i}"'),
        "invariants/power",
    ),
    Fault(
        "Coriolis force pushes in a run",
        change("kernel.text.terms:_solve", '" - h{i}"', '" + h{i}"'),
        THETA,
        kernel="terms",
    ),
    Fault(
        "angles of a run stand",
        left("_LAST", "q", " + h / 6.0 * ({sum_q} + v_{x})", ""),
        THETA,
        kernel="terms",
    ),
    Fault("weight of a stage", left("_MIDDLE", "sum_v", "2.0 *", "1.0 *"), X_SP, kernel="terms"),
    Fault(
        "last stage at half the step",
        template(LAST, LAST.replace("1.0", "0.5")),
        X_SP,
        kernel="terms",
    ),
    Fault(
        "stages without their time",
        template("t = step * h + h / 2.0\n", "t = step * h\n"),
        X_SP,
        OMEGA_T,
        kernel="terms",
    ),
    Fault(
        "clock of a run stands",
        template("t = step * h\n", "t = 0.0\n"),
        THETA,
        (),
        "sinusoid",
        kernel="terms",
    ),
    Fault(
        "start at rest",
        change("model:AnalyticModel.start", "start.theta_dot_rad_per_s", "0.0"),
        THETA,
    ),
    Fault(
        "start away from contact",
        change("model:AnalyticModel._place_teeth", '== "contact"', '== "centre"'),
        X_SP,
    ),
    Fault(
        "offsets of the start swapped",
        change(
            "model:AnalyticModel._place_teeth",
            "start.planet_ring_offset_m",
            "start.sun_planet_offset_m",
        ),
        X_PR,
    ),
    Fault(
        "forces recorded of the other mesh",
        change("model:AnalyticModel.recorded", "forces[:, place::2]", "forces[:, 1 - place :: 2]"),
        F_SP,
    ),
    Fault(
        "displacements recorded of the other mesh",
        change(
            "model:AnalyticModel.recorded",
            "self._per_planet(x[:, place::2])",
            "self._per_planet(x[:, 1 - place :: 2])",
        ),
        X_SP,
    ),
    Fault(
        "forces recorded of another time",
        template("if k == 0:", "if k == stride - 1:"),
        F_SP,
        OMEGA_T,
        kernel="terms",
    ),
]

SECOND_VERSION = [
    Fault(
        "weights lift",
        change("derivation.lagrange:weight_terms", "cosine + lever", "cosine - lever"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "base tilted the other way",
        change("derivation.lagrange:weight_terms", "sine - sign", "sine + sign"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "weight of the links alone",
        change(
            "derivation.terms:chain_terms",
            "weight_terms(bodies,",
            "weight_terms(bodies[: len(links)],",
        ),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction pushes",
        change("kernel.text.terms:_taken", "-(friction", "(friction"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "friction of the shoulder everywhere",
        change("kernel.numbers:mesh_numbers", "arm.joints[j - 1].f", "arm.joints[0].f"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "motor without mass",
        change("derivation.bodies:carried_bodies", "stage.m_m, stage.J_m", "0, stage.J_m"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "rotor without inertia",
        change("derivation.bodies:carried_bodies", "stage.m_m, stage.J_m", "stage.m_m, 0"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "rotor on the link before",
        change("derivation.bodies:carried_bodies", "stage.J_m, after", "stage.J_m, before"),
        MASS,
        arm=DIRECT,
    ),
    Fault(
        "direct torque without reaction",
        change("derivation.efforts:drive_rows", 'chain.row("theta", joint)', "chain.angles[joint]"),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "last harmonic lost",
        change("kernel.text.meshes:_wave", "harmonics + 1", "harmonics"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "square wave begins elsewhere",
        change("paper.stiffness:_waves", "(1 - np.cos(lag))", "(1 + np.cos(lag))"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "square wave's mean is its peak",
        change("paper.stiffness:mean_stiffness", "law.contact_ratio - 1", "1.0"),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "table shifted by a row",
        change("paper.stiffness:_pieces", "law.stiffness_N_per_m", SHIFTED_TABLE),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "mean of a table without its curves",
        change("paper.stiffness:mean_stiffness", "width * a / 4", "0 * a"),
        FORCE,
        arm=DIRECT,
    ),
    Fault(
        "ring with the sun's law",
        change(
            "derivation.gears:gears",
            "entry.mesh.stiffness for entry in meshes])",
            "meshes[2 * (place // 2)].mesh.stiffness for place in range(len(meshes))])",
        ),
        FORCE,
        arm=UNLIKE,
    ),
    Fault(
        "inertia over the radius alone",
        change("derivation.stage:_either", "radius**2", "radius"),
        MASS,
        arm=UNLIKE,
    ),
    Fault(
        "link's inertia about its joint",
        change(
            "derivation.stage:_link_inertia",
            "return link.mass_kg, link.inertia_kg_m2",
            "return link.mass_kg, link.inertia_kg_m2 - link.mass_kg * link.com_m**2",
        ),
        MASS,
        arm=UNLIKE,
    ),
]


TABLES = [
    Fault(name, change(f"kernel.{function}", old, new), FORCE, laws, arm=DIRECT)
    for name, function, old, new, laws in (
        ("table's pieces stop at the half", CURVE, "stage.pieces // 2", "stage.pieces // 4", ()),
        ("table's pieces begin late", CURVE, "<= {cycle} else", "<= {cycle} - 0.2 else", ()),
        ("table by its first cubic", CURVE, "{power}, {place})", "{power}, 0.0)", ()),
        ("table of straight lines", CURVE, "{c1} + {into} * ({c2} + {into} * {c3})", "{c1}", ()),
        ("table's slope without curvature", CURVE, "2.0 * {c2}", "1.0 * {c2}", CONSERVATIVE),
        ("table's slope per turn", CURVE, " * {PER_TURN}", "", CONSERVATIVE),
        ("table of one planet", "numbers:_pieces", "gears.planets[mesh] * rows", "rows", ()),
        ("table's cubics turned round", "numbers:_pieces", "rows[:, :0:-1]", "rows[:, 1:]", ()),
    )
]


@pytest.mark.parametrize(
    "fault", [*BODIES, *FORCES, *SECOND_VERSION, *TABLES], ids=lambda fault: fault.name
)
def test_fault_turns_its_check_red(fault: Fault):
    assert_seen(fault, "analytic:physical", "pinocchio:gears")


@pytest.mark.parametrize("fault", RUNS, ids=lambda fault: fault.name)
def test_fault_in_a_run_turns_its_check_red(fault: Fault):
    assert_seen(fault, "analytic:physical", "exudyn:tree")
