"""Faults in the text, the numbers and the steps of the kernels, and what sees each."""

from __future__ import annotations

import pytest

from tests.faults.faults import CONTACT, EQ13, OMEGA_T, TANH, UNLIKE, Fault, Laws, assert_seen
from tests.faults.kernels import Kernel
from tests.faults.test_analytic_faults import F_SP, LAST, THETA, X_PR, X_SP, change, left, template
from tests.faults.test_analytic_planets_faults import APART, CONSERVATIVE

THETA_DDOT = "same-step/theta_ddot"
ENERGY = "same-step/kinetic_energy"
F_PR = "same-step/F_pr"


def fault(
    name: str,
    function: str,
    old: str,
    new: str,
    check: str = X_SP,
    *,
    laws: Laws = (),
    drive: str = "pd",
    arm: str = "probe",
    kernel: Kernel = "alone",
) -> Fault:
    """One in a function of crosscheck.analytic.kernel."""
    plant = change(f"kernel.{function}", old, new)
    return Fault(name, plant, check, laws, drive, arm, kernel)


EQUATIONS = [
    fault("friction pushes", "text.links:acceleration", "} - friction", "} + friction", arm=UNLIKE),
    fault("link before without reaction", "text.links:acceleration", " - tau{j}", "", THETA),
    fault("base's reaction pushes", "text.links:acceleration", "+ base{j}", "- base{j}", THETA),
    fault(
        "angles of the joint for those of the link",
        "text.links:_links",
        'f"Theta{k - 1} + " if',
        '"" if',
        THETA,
        arm=UNLIKE,
    ),
    fault(
        "rates of the joint for those of the link",
        "text.links:_links",
        'f"Omega{k - 1} + " if',
        '"" if',
        THETA,
    ),
    fault(
        "weight to the left lifts", "text.links:_links", "} - weight_x", "} + weight_x", arm=UNLIKE
    ),
    fault("weight lifts", "text.links:_links", "weight_y{k} * c", "-weight_y{k} * c", arm=UNLIKE),
    fault(
        "shoulder's angle stays", "text.links:_direction", "(Theta{k} - Theta1)", "Theta{k}", THETA
    ),
    fault("links couple by the sum", "text.links:_pair", "c{i} + s", "c{i} - s", arm=UNLIKE),
    fault("turning the other way", "text.links:_pair", "c{i} - c", "c{i} + c", arm=UNLIKE),
    fault("sign of turning, outer link", "text.links:_pair", "} - turning", "} + turning", THETA),
    fault("sign of turning, inner link", "text.links:_pair", "} + turning", "} - turning", THETA),
    fault("outer link's own rate", "text.links:_pair", "spin{i}", "spin{k}", THETA),
    fault(
        "inner link's own rate", "text.links:_pair", "turning * spin{k}", "turning * spin{i}", THETA
    ),
    fault("target behind", "text.meshes:torque", "0 - (", "0 + (", THETA),
    fault("controller drives on", "text.meshes:torque", " - drive{j}_2", " + drive{j}_2", THETA),
    fault(
        "time for its root",
        "text.meshes:torque",
        "== SINE_OF_TIME",
        "!= SINE_OF_TIME",
        THETA,
        drive="sinusoid",
    ),
    fault(
        "torque of a table's first", "text.meshes:torque", "table{j}", "table1", arm=UNLIKE
    )._replace(drive="table"),
    fault("sun mesh without its planet", "text.links:_stage", " - q_x_pr{planet}", ""),
    fault("damper without its planet", "text.links:_stage", " - v_x_pr{planet}", ""),
    fault("half of the ring mesh", "text.links:_stage", "- (F_{ring}", "- (F_{ring} / 2"),
    fault("sun without a damper", "text.links:_stage", "F_{sun} + D_{sun}", "F_{sun}"),
    fault("ring without a damper", "text.links:_stage", "(F_{ring} + D_{ring})", "F_{ring}"),
    fault("half on the sun", "text.links:_stage", "f_s{j} - f_{sun}", "f_s{j} - f_{sun} / 2"),
    fault("last planet's push alone", "text.links:_stage", "f_p{j} + f_p", "f_p", THETA, arm=APART),
    fault("last planet's sun mesh alone", "text.links:_stage", "f_s{j} - f_", "-f_", arm=APART),
    fault(
        "kappa of the other gear",
        "text.links:_stage",
        "kappa_s{j} * f_s{j} + kappa_p",
        "kappa_p{j} * f_s{j} + kappa_s",
        THETA,
    ),
    fault(
        "u of the other gear",
        "text.links:_stage",
        "u_s{j} * f_s{j} + u_p",
        "u_p{j} * f_s{j} + u_s",
        THETA,
    ),
    fault("motor without reaction", "text.links:_stage", "+ reaction{j} * T{j}", "", THETA),
    fault(
        "sun's sines for the ring",
        "text.meshes:meshes_of",
        '"sp" if stage.one_rate else "pr"',
        '"sp"',
    )._replace(laws=EQ13),
    fault("springs leave the angle", "text.links:_stage", "+ on_theta{j}", "", X_SP)._replace(
        laws=CONSERVATIVE, arm=APART
    ),
    fault(
        "phase without time", "structure:Structure.turns", "{joint} * t", "{joint}", laws=OMEGA_T
    ),
    fault("sines of sums", "text.meshes:_waves", "c{b}_{name} + c", "c{b}_{name} - c", arm=UNLIKE),
    fault(
        "cosines of sums", "text.meshes:_waves", "c{b}_{name} - s", "c{b}_{name} + s", arm=UNLIKE
    ),
    fault("last harmonic lost", "text.meshes:_wave", "harmonics + 1", "harmonics", arm=UNLIKE),
    fault("error the other way", "text.meshes:_mesh", "} - e_", "} + e_"),
    fault("error does not vary", "text.meshes:_wave", " + e_s_{own} * s1_{phase}", ""),
    fault(
        "error without its cosine", "text.meshes:_wave", " + e_c_{own} * c1_{phase}", "", arm=UNLIKE
    ),
    fault("standing error lost", "text.meshes:_wave", "e0_{own} + ", "", arm=APART),
    fault("stiffness without sines", "text.meshes:_wave", " + k{n}_s_{own} * s{n}_{phase}", ""),
    fault("cosines of stiffness turned", "text.meshes:_wave", " + k{n}_c", " - k{n}_c", arm=UNLIKE),
    fault("force of all planets recorded", "text.meshes:_mesh", " * share{j}", "", F_SP),
    fault("dampers push", "text.meshes:_mesh", "d_{own} * v", "-d_{own} * v"),
    fault(
        "dampers act in free play", "text.meshes:_mesh", "if not s.damps_apart", "if False"
    )._replace(laws=CONTACT),
    fault("dampers act in play alone", "text.meshes:_mesh", "> b_", "< b_", laws=CONTACT),
    fault("no play", "text.meshes:_travel", "{gap} - inside", "{gap}"),
    fault(
        "no other flank", "text.meshes:_travel", "-{b} if inside < -{b}", "inside if inside < -{b}"
    ),
    fault("play on one side", "text.meshes:_travel", "inside < -{b} else", "inside < {b} else"),
    fault("smooth flanks added", "text.meshes:_travel", "right - left", "right + left", laws=TANH),
    fault(
        "smooth flanks taken away",
        "text.meshes:_travel",
        "right + left)",
        "right - left)",
        laws=TANH,
    ),
    fault(
        "smooth play on one side", "text.meshes:_travel", "{gap} + {b}", "{gap} - {b}", laws=TANH
    ),
    *(
        fault(name, "text.meshes:_on_angle", old, new, laws=CONSERVATIVE, arm=APART)
        for name, old, new in (
            ("slope of the first harmonic alone", "{float(n)!r} * (", "("),
            ("slope with cosines turned", "} - k{n}_c", "} + k{n}_c"),
            ("error's slope with its cosine turned", "} - e_c", "} + e_c"),
            ("error does no work", "F_{mesh} * error_slope", "0.0"),
            ("stiffness does no work", " - ({' + '.join(slopes)}) * travel * travel / 2.0", ""),
            ("stiffness does twice the work", "travel / 2.0", "travel"),
            ("last mesh's work alone", "on_theta{j} + slope", "slope"),
            ("angle for phase", "slope_{own} * ", ""),
        )
    ),
    fault(
        "elimination adds on the right",
        "text.links:_solve",
        "- L{k}_{p} * r",
        "+ L{k}_{p} * r",
        THETA,
    ),
    fault("elimination adds", "text.links:_solve", "- L{k}_{p} * M", "+ L{k}_{p} * M", THETA),
    fault("substitution adds", "text.links:_solve", " - L{i}_{k}", " + L{i}_{k}", THETA),
    fault("acceleration of the link", "text.links:_solve", 'f" - A{k - 1}"', '""', THETA),
    fault("sun without its motor", "text.links:_gears", " + advance{j} * T{j}", ""),
    fault("sun without the link before", "text.links:_gears", '} + " if j', '} - " if j'),
    fault("gears without their joint", "text.links:_gears", "kappa_{{0}}{j} * a", "0 * a"),
    fault("planet carried as the sun is", "text.links:_gears", 'format("p")', 'format("s")', X_PR),
]

NUMBERS = [
    fault("gains of the shoulder", "numbers:mesh_numbers", "gains[j - 1]", "gains[0]", THETA),
    fault(
        "friction of the shoulder", "numbers:mesh_numbers", "arm.joints[j - 1].f", "arm.joints[0].f"
    )._replace(arm=UNLIKE),
    fault("ring at the sun's rate", "numbers:mesh_numbers", "ring / TURN", "sun / TURN", laws=EQ13),
    *(
        fault(
            f"sides swapped, {arm}", "numbers:mesh_numbers", '("sp", "pr")', '("pr", "sp")'
        )._replace(arm=arm, laws=(("planets", "free"),))
        for arm in (UNLIKE, APART)
    ),
    fault("phase in radians", "numbers:mesh_numbers", "sun / TURN", "sun"),
    fault(
        "meshes of the shoulder", "numbers:mesh_numbers", "(gears, mesh,", "(gears, mesh - first,"
    ),
    fault("weight across for along", "numbers:_of_links", "g_x * links", "g_y * links", arm=UNLIKE),
    fault("weight along for across", "numbers:_of_links", "g_y * links", "g_x * links", arm=UNLIKE),
    fault(
        "links without inertia", "numbers:_of_links", "constant if k == i", "0.0 if k == i", THETA
    ),
    fault("tip twice as light", "numbers:_of_links", "1 / coupling", "2 / coupling", THETA),
    fault("sun's inertia at the planet's", "numbers:_of_gears", "1 / (sun *", "1 / (planet *"),
    fault("sun turned once", "numbers:_of_gears", "r_s**2 * a_s**2", "r_s**2 * a_s"),
    fault("inertia of one planet", "numbers:_of_gears", "together * planet", "planet", X_PR),
    fault("inertia of all planets", "numbers:_of_gears", "// stage.planets", "", X_PR, arm=APART),
    fault("planet turned half", "numbers:_of_gears", "a_p**2", "a_p**2 / 4", X_PR),
    fault("u of the sun", "numbers:_of_gears", '_s{j}": 1 / a_s', '_s{j}": a_s', THETA),
    fault("u of the planet", "numbers:_of_gears", '"u_p{j}": 1 / a_p', '"u_p{j}": -1 / a_p', THETA),
    fault("kappa of the sun", "numbers:_of_gears", "rho_s / a_s", "rho_s", THETA),
    fault("kappa of the planet", "numbers:_of_gears", "-minus_rho_p /", "minus_rho_p /", THETA),
    fault("force of all planets", "numbers:mesh_numbers", "1 / gears.planets[first]", "1.0", F_SP),
    fault("motor turns the sun directly", "numbers:_of_gears", "a_s / geometry.n", "a_s"),
    fault("reaction of the output", "numbers:_of_gears", "1 / geometry.n", "1.0", THETA),
    fault("stiffness of one planet", "numbers:_of_mesh", "planets * gears.k_m", "gears.k_m"),
    fault("no standing error", "numbers:_of_mesh", "gears.static[mesh]", "0.0", arm=APART),
    fault(
        "error without its lead",
        "numbers:_of_mesh",
        "offset + gears.lead[mesh]",
        "offset",
        arm=APART,
    ),
    fault("error's phase lost", "numbers:_of_mesh", "math.cos(turned)", "1.0", arm=UNLIKE),
    fault(
        "error's phase turned", "numbers:_of_mesh", "math.sin(turned) if", "-math.sin(turned) if"
    ),
    fault("play of the first mesh", "numbers:_of_mesh", "gears.b[mesh]", "gears.b[0]", X_PR),
    fault("damper of the first mesh", "numbers:_of_mesh", "gears.d[mesh]", "gears.d[0]", X_PR),
    fault(
        "sharpness of the first mesh",
        "numbers:_of_mesh",
        "gears.sigma[mesh]",
        "gears.sigma[0]",
        F_PR,
    )._replace(laws=TANH),
    fault("stiffness turned, sines", "numbers:_of_mesh", "c - cosines", "c + cosines", arm=UNLIKE),
    fault(
        "stiffness turned, cosines", "numbers:_of_mesh", "s + cosines", "s - cosines", arm=UNLIKE
    ),
    fault("stiffness does not vary", "numbers:_waves", "gears.k_a[mesh]", "0.0"),
    fault(
        "series turned", "numbers:_waves", "rows[:, 1], rows[:, 2]", "rows[:, 2], rows[:, 1]"
    )._replace(arm=UNLIKE),
    fault("centres without mass", "links:_add", "body.mass * np.outer", "np.outer", THETA),
    fault(
        "centre by the square", "links:_add", "body.mass * centre", "body.mass * centre**2"
    )._replace(arm=UNLIKE),
    fault("spin counted with the link", "links:_add", "if not", "if True or", THETA),
    fault("bodies do not spin", "links:_add", "body.inertia *", "0 *", THETA),
    fault("relative for absolute", "links:absolute", "[*row[1:], 0.0]", "0 * row", THETA),
    fault("a body less", "links:_links", "all_bodies(chain) if", "all_bodies(chain)[1:] if", THETA),
    fault(
        "links alone",
        "links:_links",
        "all_bodies(chain) if",
        'rigid_bodies(chain, "links") if',
        THETA,
    ),
    fault("payload lost", "links:links_of", "arm.payload_mass_kg", "0.0", THETA),
]

LINKS, COMMON = "text.links:link_structure", "structure:common_structure"
SHAPES = [
    fault(name, function, old, new, check, laws=laws, arm=arm)
    for name, function, old, new, check, laws, arm in (
        ("no weight", LINKS, "any(arm.gravity_m_per_s2)", "False", X_SP, (), UNLIKE),
        ("no friction", LINKS, "friction=any(", "friction=False and any(", X_SP, (), UNLIKE),
        ("phase of an angle", COMMON, "gears.phase == OMEGA_T", "False", X_SP, OMEGA_T, "probe"),
        ("exact clearance", COMMON, "gears.dead_zone == TANH", "False", F_SP, TANH, "probe"),
        ("dampers everywhere", COMMON, "bool(gears.damps_apart)", "True", X_SP, CONTACT, "probe"),
        (
            "springs do no work",
            COMMON,
            "bool(gears.conservative)",
            "False",
            X_SP,
            CONSERVATIVE,
            APART,
        ),
    )
] + [
    fault("one rate for both", "structure:_stages", "bool(abs(", "bool(0 * abs(", laws=EQ13),
    fault(
        "first planet's meshes for all", "structure:_alike", "same_laws and", "True or", arm=APART
    ),
    fault("no cosines", "structure:_stages", ".any() or", ".any() and", arm=UNLIKE),
]

FIRST = "first_stage(at(w, block * BLOCK), t, sqrt(t), table"
STEPS = [
    Fault("weight of a stage", left("_MIDDLE", "sum_v", "2.0 *", "1.0 *"), X_SP),
    Fault("last stage at half the step", template(LAST, LAST.replace("1.0", "0.5")), X_SP),
    Fault(
        "last stage without its time",
        template("t = step * h + h\n", "t = step * h\n"),
        X_SP,
        OMEGA_T,
    ),
    Fault(
        "second stage without its time",
        template("t = step * h + h / 2.0\n", "t = step * h\n"),
        X_SP,
        OMEGA_T,
    ),
    Fault(
        "clock of a step's start stands",
        template("t = step * h\n", "t = 0.0\n"),
        THETA,
        (),
        "sinusoid",
    ),
    Fault("no root of time", template(FIRST, FIRST.replace("sqrt(t)", "t")), THETA, (), "root"),
    Fault("fifths of a step", left("_LAST", "v", "h / 6.0", "h / 5.0"), THETA),
    Fault("last stage not counted", left("_LAST", "q", " + v_{x}", ""), THETA),
    Fault("sums kept", left("_FIRST", "sum_q", "v_{x}", "v_{x} + 1e-3 * {sum_q}"), THETA),
    Fault("stage of the step before", left("_FIRST", "stage_q", "q_{x}", "{stage_q}"), X_SP),
    Fault("rates of the stage before", left("_MIDDLE", "stage_v", "{v}", "v_{x}"), X_SP),
    Fault("rates for accelerations", template("w[A + i]", "w[SIZE + i]"), THETA_DDOT),
    Fault("forces of other meshes", template("w[FORCES + i]", "w[FORCES + FORCED - 1 - i]"), F_SP),
    Fault("record a step late", template("if k == 0:", "if k == stride - 1:"), X_SP),
    Fault(
        "table read at the step's start",
        template("t = step * h + h / 2.0\n            {at_t}", "t = step * h + h / 2.0"),
        X_SP,
        drive="table",
        arm=UNLIKE,
    ),
    Fault("whole step by half", left("_MIDDLE", "stage_q", "part *", "part / 2 *"), X_SP),
    Fault("stages weighed alike", left("_MIDDLE", "sum_v", "2.0 *", "1.5 *"), X_SP),
]

BATCHES = [
    fault(
        "sun's advance without the ring", "equations:LinkEquations.to_kernel", "x_sp + x_pr", "x_sp"
    ),
    fault(
        "sun mesh recorded as the advance",
        "equations:LinkEquations.from_kernel",
        "2 * place] - x_pr",
        "2 * place]",
    ),
    fault(
        "planet of the first joint",
        "equations:LinkEquations.from_kernel",
        "2 * place + 1",
        "1",
        X_PR,
    ),
    fault(
        "steps not counted", "batch:Batch.advance", "self.done += ", "self.done = 0 * ", THETA
    )._replace(drive="sinusoid", kernel="abreast"),
    fault(
        "start of the first member",
        "batch:Batch._column",
        "in model.start()",
        "in self.models[0].start()",
        THETA,
    )._replace(kernel="abreast"),
    fault(
        "numbers of the first member",
        "batch:Batch._column",
        "model.equations.numbers",
        "self.models[0].equations.numbers",
        THETA,
        kernel="abreast",
    ),
    Fault(
        "run of the first member",
        change("ensemble:_run", "each[:, :, place]", "each[:, :, 0]"),
        THETA,
        kernel="abreast",
    ),
    *(
        fault(
            f"sine's pairs, {kernel}",
            "text.functions:cosine",
            "{pairs[2]} + {pairs[3]} * {u2}",
            "{pairs[2]} + {pairs[3]} * {u}",
        )._replace(kernel=kernel)
        for kernel in ("alone", "abreast")
    ),
    fault("fold at half a turn", "text.functions:cosine", "0.25 - abs", "0.5 - abs"),
    fault("sine the other way", "text.functions:sine", "- 0.25", "+ 0.25"),
    fault(
        "smooth corner of the other flank",
        "text.functions:hyperbolic_tangent",
        "1.0 - 2.0 /",
        "1.0 - 1.9 /",
        F_SP,
        laws=TANH,
        kernel="abreast",
    ),
]

ENERGIES = [
    fault(name, f"energy:{function}", old, new, ENERGY)
    for name, function, old, new in (
        (
            "energy of relative rates",
            "kinetic_energy",
            "np.cumsum(each.T[-joints:], axis=0)",
            "each.T[-joints:]",
        ),
        (
            "energy without constant inertia",
            "_of_links",
            "links.coupling + links.constant",
            "links.coupling",
        ),
        ("twice the links' energy", "_of_links", ".sum(axis=0) / 2", ".sum(axis=0)"),
        ("links apart", "_of_links", "turned[k] - turned[before]", "turned[k]"),
        ("spin without the link before", "kinetic_energy", "u * base", "0 * base"),
        ("spin without the joint", "kinetic_energy", "kappa * v", "0 * v"),
        ("twice the gears' energy", "kinetic_energy", "(2 * per)", "per"),
        ("gears' energy at one rate", "kinetic_energy", "place += 1", "place += 0"),
    )
]

ALL = [*EQUATIONS, *NUMBERS, *SHAPES, *STEPS, *BATCHES, *ENERGIES]


@pytest.mark.parametrize("fault", ALL, ids=lambda fault: fault.name)
def test_fault_turns_its_check_red(fault: Fault):
    assert_seen(fault, "analytic:physical", "exudyn:tree")
