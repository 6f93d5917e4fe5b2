"""Robots that cannot be read: one line with file, link or joint and what is allowed; code 2."""

import re
import tomllib
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.checks.robot_states import sample_states
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.models.robot import tree
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.inertias import is_negative, is_possible
from crosscheck.models.robot.robot import Robot
from crosscheck.models.robot.tree import survey_inertias
from crosscheck.models.robot.urdf import DEEPEST, read_root, read_urdf
from crosscheck.planning.robots import compare_engines
from tests.loops import require_items
from tests.robots.chains import LIMIT, Solid, joint, link, mass_matrices, robot, urdf
from tests.robots.test_floating import ARM as ON_SATELLITE
from tests.robots.test_floating import moved
from tests.robots.test_mjcf import BODY
from tests.robots.test_robot_template import GEARS, geared_text
from tests.robots.test_space_robot import ARM as ARM_IN_SPACE
from tests.robots.test_space_robot import BASE
from tests.tool.test_bad_input import assert_one_line

GROUND, ARM = link("ground"), link("arm", Solid())
TURN = joint("turn", "ground", "arm")
GOOD = urdf(GROUND, ARM, TURN)
ROWS = tomllib.loads(Path(__file__).with_name("bad_robots.toml").read_text(encoding="utf-8"))
XACRO = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'


def changed(text: str, old: str, new: str) -> str:
    """A text, the first ``old`` in it changed."""
    assert old in text
    return text.replace(old, new, 1)


TWO_LIMBS = tuple(link(name, Solid()) for name in ("left", "right"))
POINT = (0.0,) * 6
BAD_URDFS = {
    **{name: changed(GOOD, *row) for name, row in ROWS["urdfs"].items()},
    "no XML": "schema_version = 1",
    "cut off": GOOD[:-20],
    "another document": "<html></html>",
    "empty": " ",
    "no link": urdf(),
    "nothing moves": urdf(GROUND),
    "links in another root": "<model><link name='arm'/></model>",
    "xacro element": XACRO.format("<xacro:arm/>"),
    "external entity": '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/passwd">]>' + GOOD,
    "entities of entities": (
        '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>'
    ),
    "nested deep": "<robot>" + "<a>" * 10_000 + "</a>" * 10_000 + "</robot>",
    "10 MB": GOOD + " " * 10_000_000,
    "two links of a name": urdf(GROUND, ARM, ARM, TURN),
    "two joints of a name": urdf(GROUND, ARM, TURN, TURN),
    "no inertias at all": urdf(GROUND, link("arm"), TURN),
    "massless at the ends": urdf(
        *(GROUND, ARM, TURN),
        *(link(name) + joint(f"to {name}", "arm", name) for name in ("left", "right")),
    ),
    "mimics in a circle": urdf(
        *(GROUND, ARM, TURN, *TWO_LIMBS),
        joint("a", "arm", "left", more=f'<mimic joint="b"/>{LIMIT}'),
        joint("b", "arm", "right", more=f'<mimic joint="a"/>{LIMIT}'),
    ),
    "inertia of a point": urdf(GROUND, link("arm", Solid(inertia=POINT)), TURN),
    "a point on three axes": urdf(
        GROUND,
        *(link(name, Solid(1.0, inertia=POINT)) for name in ("arm", "elbow")),
        link("hand", Solid(1.0, (0, 0, 0.3), POINT)),
        joint("turn", "ground", "arm", axis=(1, 0, 0)),
        joint("bend", "arm", "elbow", axis=(0, 1, 0)),
        joint("roll", "elbow", "hand", axis=(1, 1, 0)),
    ),
    "loop": urdf(
        *(GROUND, ARM, link("leg", Solid()), TURN, joint("a", "arm", "leg")),
        joint("b", "ground", "leg"),
    ),
    "ring": urdf(ARM, link("leg", Solid()), joint("a", "arm", "leg"), joint("b", "leg", "arm")),
    "island": urdf(
        *(GROUND, ARM, TURN, *TWO_LIMBS),
        *(joint("a", "left", "right"), joint("b", "right", "left")),
    ),
    "two roots": urdf(GROUND, ARM, TURN, link("moon")),
    "control character in a name": GOOD.replace("arm", "a&#10;rm"),
}
MINIMAL = 'schema_version = 1\nname = "mine"\nurdf = "mine.urdf"\n'
GEARED = '[joints.turn]\nkind = "geared"\nratio = 5.0\nrotor_inertia_kg_m2 = 1e-4\n'
MESH = "mesh = { pinion_base_radius_m = 0.01, stiffness_N_per_m = 1e6 }\n"
TEETH = """\
[joints.turn]
kind = "planetary"
sun_teeth = 27
planet_teeth = 36
ring_teeth = 99
module_m = 0.003
pressure_angle_deg = 24.6
sun_inertia_kg_m2 = 1e-3
planet_inertia_kg_m2 = 1e-3
"""
LAW = 'stiffness = { law = "sine", mean_N_per_m = 1e8, amplitude_N_per_m = 2e7 }\n'
CONTACT = LAW + "backlash_m = 5e-5\ntooth_error_m = 5e-6\ndamping_ratio = 0.05\n"
STAGE = f"{TEETH}[joints.turn.sun_mesh]\n{CONTACT}[joints.turn.ring_mesh]\n{CONTACT}"
SLIDES = GOOD.replace('type="revolute"', 'type="prismatic"')
TEXTS = {
    "plain": MINIMAL,
    "geared": MINIMAL + GEARED,
    "meshed": MINIMAL + GEARED + MESH,
    "staged": MINIMAL + STAGE,
    "lumped": MINIMAL + changed(STAGE, "ring_teeth = 99", 'ring_teeth = 99\nplanets = "lumped"'),
}
BAD_FILES = {
    **{name: changed(TEXTS[text], *row) for name, (text, *row) in ROWS["files"].items()},
    "stage without a mesh": MINIMAL + STAGE.partition("[joints.turn.ring_mesh]")[0],
    "stage out of phase": MINIMAL
    + STAGE.replace("= 27", "= 28")
    .replace("= 36", "= 35")
    .replace("= 99", '= 98\nplanets = "lumped"')
    .replace(LAW, LAW + 'phase_rad = "from-teeth"\n', 1),
    "400 digits": changed(MINIMAL + GEARED, "5.0", "1" + 400 * "0"),
    "200 digits": changed(MINIMAL + GEARED, "5.0", "1" + 200 * "0"),
}
THREE = (
    "<mujoco><worldbody><body><joint name='a'/><joint name='b' axis='1 0 0'/><joint name='c'"
    " axis='0 1 0'/><geom size='1'/></body></worldbody><equality>{}</equality></mujoco>"
)
GRID = "<flexcomp name='f' type='grid' dim='2' count='3 3 1' spacing='1 1 1'/>"
BAD_MJCF = {
    "none moves": "<mujoco/>",
    "no XML": "<mujoco",
    "no file": BODY.format("<joint/><geom type='mesh' mesh='m'/>", ""),
    "deformable": changed(BODY.format("<joint/>", ""), "</worldbody>", f"{GRID}</worldbody>"),
    "two leaders": THREE.format(
        "<joint joint1='a' joint2='b'/><joint name='f' joint1='a' joint2='c'/>"
    ),
    "no leader": THREE.format("<joint name='e' joint1='a'/>"),
    "a leader's square": THREE.format(
        "<joint name='e' joint1='a' joint2='b' polycoef='0 1 1 0 0'/>"
    ),
    "loop": BODY.format("<joint/>", "<equality><connect body1='a' anchor='0 0 0'/></equality>"),
}
FLOATING = urdf(link("inertial"), *ON_SATELLITE, moved("floating"))
BAD_FLOATING = {
    "no passive joint": changed(FLOATING, "</robot>", '<passive_joint name="elbow"/></robot>'),
    "mimics": changed(FLOATING, 'type="floating">', 'type="floating"><mimic joint="j1"/>'),
    "a name twice": changed(FLOATING, 'name="j1"', 'name="base_yaw"'),
}
WITH_YAW = MINIMAL + changed(GEARED, "turn", "base_yaw")
BASES = {
    "no side": "mass_kg = 30.0",
    "two forms": "mass_kg = 30.0\nside_m = 1.0\ncom_m = 0.1",
    "unknown key": "mass_kg = 30.0\nside = 1.0",
    "negative mass": "mass_kg = -1.0\nside_m = 1.0",
}
BAD_GEARS = {
    "no number": geared_text(GEARS.replace(">-100<", ">a hundred<")),
    "too large a ratio": geared_text(GEARS.replace('"50"', '"1e9"')),
    "negative inertia": geared_text(GEARS.replace('"2e-5"', '"-1"')),
    "armature of text": geared_text(armature="much"),
    "no such joint": geared_text(GEARS.replace('name="d"', 'name="x"')),
    "two ratios": geared_text(GEARS + GEARS.replace(">7<", ">8<")),
}
RUNS = (
    *("--model analytic:geared", "--model newton:links"),
    *("--set switches.phase=angle", "--set arm.payload_mass_kg=1"),
    *("--set robot.joints.nose.ratio=1", "--set scenario.start.theta_rad=[1,2]"),
    *("--set scenario.step_s=0.1 --t-end 1", "--model pinocchio:coupled --rtol 1e-9", "--rtol 1"),
)
USUAL, RUN = " --model analytic:coupled", "simulate puma560 --scenario pd --out run.nc"
COST = "cost mine.toml --json cost.json"
REFUSED: dict[str, tuple[str, dict[str, str]]] = {
    **{f"URDF, {n}": (COST, {"mine.urdf": t, "mine.toml": MINIMAL}) for n, t in BAD_URDFS.items()},
    **{f"file, {n}": (COST, {"mine.urdf": GOOD, "mine.toml": t}) for n, t in BAD_FILES.items()},
    "stage of a slide": (COST, {"mine.urdf": SLIDES, "mine.toml": MINIMAL + STAGE}),
    "no text": (COST, {"mine.urdf": "\udcff\udcfe<robot/>", "mine.toml": MINIMAL}),
    "xacro": ("cost arm.urdf.xacro", {"arm.urdf.xacro": XACRO.format("<xacro:property/>")}),
    "no robot": ("cost hexapod", {}),
    **{f"MJCF, {name}": ("cost arm.xml", {"arm.xml": text}) for name, text in BAD_MJCF.items()},
    **{f"floating, {n}": ("show mine.urdf", {"mine.urdf": t}) for n, t in BAD_FLOATING.items()},
    "gear without motor": ("show mine.toml", {"mine.urdf": FLOATING, "mine.toml": WITH_YAW}),
    **{
        f"base, {name}": (
            "show arm.toml",
            {"arm.toml": ARM_IN_SPACE.replace(BASE, f"[base]\n{own}\n")},
        )
        for name, own in BASES.items()
    },
    **{
        f"{command} of {kind}": (f"{command} other.xml", {"other.xml": text})
        for kind, text in (("SDF", "<sdf version='1.6'/>"), ("xacro", XACRO.format("<xacro:a/>")))
        for command in ("validate", "run")
    },
    "init of nothing": ("init mine.toml --urdf yours.urdf", {}),
    "init of joints": ("init mine.toml --urdf mine.urdf --joints 3", {"mine.urdf": GOOD}),
    "init of what exists": (
        "init mine.toml --urdf mine.urdf",
        {"mine.urdf": GOOD, "mine.toml": ""},
    ),
    "export of teeth": ("export probe --out a.urdf --model analytic:physical", {}),
    "export of no model": ("export probe --out a.c", {}),
    "export over a file": ("export probe --out a.urdf", {"a.toml": "mine = 1"}),
    **{f"gear, {n}": ("init r.toml --urdf r.urdf", {"r.urdf": t}) for n, t in BAD_GEARS.items()},
    **{
        f"run, {words}": (f"{RUN} {words}" + USUAL * ("--model" not in words), {}) for words in RUNS
    },
    **{
        f"export, {model}": (f"export puma560 --model {model} --out robot.c", {})
        for model in ("analytic:geared", "pinocchio:links")
    },
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_robot_that_cannot_be_read_is_one_line(refuse, case, snapshot: SnapshotAssertion):
    assert refuse(*REFUSED[case]) == snapshot


def test_an_arm_is_no_robot_nor_a_robot_an_arm():
    with pytest.raises(InputError, match="it is one of arms"):
        load_robot("probe")
    with pytest.raises(InputError, match="it is one of robots"):
        load_arm("sliding")


def test_elements_are_as_deep_in_each_other_as_is_said():
    for depth in (DEEPEST, DEEPEST + 1):
        nested = "<robot>" + "<a>" * (depth - 1) + "</a>" * (depth - 1) + "</robot>"
        with nullcontext() if depth == DEEPEST else pytest.raises(InputError, match="deep in"):
            read_root(nested, "made")


def test_no_output_takes_the_place_of_an_input(crosscheck, tmp_path):
    (tmp_path / "mine.urdf").write_text(GOOD)
    (tmp_path / "mine.toml").write_text(MINIMAL)
    for name in ("mine.urdf", "mine.toml"):
        given = ("--ratio", 101, "--rotor-inertia", 1e-4)
        answer = crosscheck("cost", tmp_path / "mine.toml", *given, "--json", tmp_path / name)
        assert_one_line(answer, name, "is read by this command")


def test_what_is_not_used_is_reported(snapshot: SnapshotAssertion):
    more = '<dynamics damping="0.5" friction="1"/>' + LIMIT
    text = GOOD.replace(LIMIT, more).replace(
        "</robot>", '<gazebo/><transmission name="t"/></robot>'
    )
    mesh = '<visual><geometry><mesh filename="package://nowhere/arm.dae"/></geometry></visual>'
    text = text.replace("</inertial>", "</inertial>" + mesh)
    assert robot(text).notes == snapshot


@pytest.mark.parametrize(("size", "along", "lines"), [(0.01, 0.01, 1), (0.01, 0, 1), (0, 0, 0)])
def test_an_inertia_without_mass_is_reported_and_nothing_without_either(size, along, lines):
    """Of a ball, of a thin rod, and of nothing."""
    massless = Solid(0.0, inertia=(along, 0, 0, size, 0, size))
    held = joint("flange", "arm", "hand", "fixed")
    notes = robot(urdf(GROUND, link("arm", massless), link("hand", Solid()), TURN, held)).notes
    reported = [note.startswith("link arm: an inertia without mass") for note in notes]
    assert reported == lines * [True]


def test_of_two_inertials_every_engine_uses_the_first():
    first, second = link("arm", Solid(1.0)), link("arm", Solid(7.0, inertia=(5, 0, 0, 5, 0, 5)))
    inertial = re.search("<inertial>.*</inertial>", second, re.DOTALL)
    assert inertial
    doubled = robot(urdf(GROUND, first.replace("</link>", inertial[0] + "</link>"), TURN))
    right, *_ = mass_matrices(robot(GOOD), [0.0])
    for mass in require_items(mass_matrices(doubled, [0.0])):
        assert mass == pytest.approx(right, rel=1e-14)


@pytest.mark.parametrize(
    "stated",
    [
        '<limit lower="-3" upper="3"/>',
        '<limit effort="1"/>',
        f'{LIMIT}<dynamics friction="1"/>',
        f"{LIMIT}<dynamics/>",
        f'{LIMIT}<safety_controller soft_upper_limit="1"/><calibration rising="two"/>',
    ],
)
def test_what_a_joint_leaves_out_or_has_besides_stops_no_engine(stated):
    own = robot(GOOD.replace(LIMIT, stated))
    masses = mass_matrices(own, [0.0])
    np.testing.assert_allclose(masses, own.bodies[0].inertia[2, 2], rtol=1e-14)


def test_an_inertia_that_breaks_the_triangle_inequality_is_used_and_reported():
    flat = Solid(inertia=(0.01, 0, 0, 0.01, 0, 0.03))
    own = robot(urdf(GROUND, link("arm", flat), TURN))
    assert own.bodies[0].inertia[2, 2] == 0.03
    (note,) = own.notes
    assert note.startswith("link arm: no body has principal inertias 0.01, 0.01, 0.03")


@pytest.mark.parametrize("part", [1.02, 0.98])
def test_an_inertia_is_rounded_measured_or_wrong_by_how_much_it_is_too_large(part):
    """By a millionth of itself all bodies' may be, and by a quarter those that were measured."""
    beyond = part > 1
    assert is_possible(np.array([1.0, 1.0, 2 * (1 + part * 1e-6)])) != beyond
    assert is_negative(np.array([-part * 1e-6, 1.0, 1.0])) == beyond
    large = Solid(inertia=(0.01, 0, 0, 0.01, 0, 0.02 * (1 + part * 0.25)))
    (doubt,) = survey_inertias(read_urdf(urdf(GROUND, link("arm", large), TURN), "made"), "made")
    assert ("measured" in doubt.repair) != beyond


@pytest.mark.parametrize(("part", "unit"), [(1.1, "kg mm^2"), (0.9, "g cm^2")])
def test_an_inertia_is_in_the_unit_that_makes_it_a_machines(part, unit):
    """Of 3e4 kg/m^3, its radius of gyration cubed; between two units, of 10^(3/4) less."""
    sail = Solid(part * 3e4 * 10**-9.75, (0.01, 0, 0), (1e-9, 0, 0, 1e-9, 0, 1e-9))
    each = sail.mass * 1.0**2
    sail = sail._replace(inertia=(each, 0, 0, each, 0, each))
    (doubt,) = survey_inertias(read_urdf(urdf(GROUND, link("arm", sail), TURN), "made"), "made")
    assert f"may be in {unit}" in doubt.repair


@pytest.mark.parametrize(("part", "is_refused"), [(0.98, True), (1.02, False)])
def test_a_mass_matrix_is_singular_below_a_trillionth_of_its_diagonal(
    part, is_refused, monkeypatch
):
    near = 1 - part * 1e-12
    root = np.array([[1.0, near], [0.0, np.sqrt(1 - near**2)]])
    monkeypatch.setattr(tree, "_root_of_mass_matrix", lambda *_: root)
    with pytest.raises(InputError) if is_refused else nullcontext():
        robot(urdf(GROUND, ARM, TURN, joint("bend", "arm", "hand"), link("hand", Solid())))


def test_a_joint_may_be_locked_by_its_limits():
    limits = robot(GOOD.replace('lower="-3" upper="3"', 'lower="1" upper="1"')).joints[0].limits
    assert limits.lower == limits.upper == 1.0


def test_zero_axis_of_a_fixed_joint_and_huge_limits_are_no_error():
    fixed = joint("flange", "arm", "hand", "fixed", axis=(0, 0, 0))
    text = urdf(GROUND, ARM, TURN, link("hand"), fixed).replace('upper="3"', 'upper="1e16"')
    assert len(robot(text).joints) == 1


def test_errors_of_a_file_come_without_a_trace_of_the_reader():
    with pytest.raises(InputError) as caught:
        robot(GOOD.replace('value="1.0"', 'value="heavy"'))
    assert caught.value.__context__ is None


NUMBERS = (
    *("1", " 1", "1 ", "1_0", "+1", ".5", "1.", "1.e3", "00012", "1E+003", "1e", "1d2", "0x10"),
    *("inf", "nan", "1e400", "1,5", "", "1f", "--1", "1 2", "&#9;1", "&#10;1", "1&#10;"),
    *("\u0661", "\u00a01", "1\u2009"),
)


def read_or_refused(text: str) -> Robot | str:
    """A robot, or what the error says."""
    try:
        return robot(text)
    except InputError as error:
        return str(error)


@pytest.mark.parametrize("number", NUMBERS)
def test_a_number_is_one_for_both_readers_or_for_none(number, capfd):
    """Pinocchio reads by urdfdom, which leaves out an inertia whose numbers it cannot read."""
    text = changed(GOOD, 'mass value="1.0"', f'mass value="{number}"')
    text = changed(text, 'upper="3"', f'upper="{number}"')
    own = read_or_refused(text)
    if isinstance(own, str):
        assert "must be a number" in own
        with pytest.raises(ValueError, match="does not contain a valid URDF"):
            pin.buildModelFromXML(text)
        return
    model = pin.buildModelFromXML(own.urdf)
    assert model.inertias[1].mass == own.bodies[0].mass
    assert model.upperPositionLimit[0] == own.joints[0].limits.upper
    assert capfd.readouterr().err == ""


VECTORS = (
    *("1 2 3", "  1 2  3 ", "\n1\t2\r\n3\n", "1&#9;2 3", "1,2,3", "1 2", "1 2 3 4", "1_0 2 3"),
)


@pytest.mark.parametrize("vector", VECTORS)
def test_three_numbers_are_a_place_for_both_readers_or_for_none(vector, capfd):
    """A line break in an attribute is a blank, as XML says; urdfdom would not read on."""
    text = changed(GOOD, 'origin xyz="0.0 0.0 0.0"', f'origin xyz="{vector}"')
    own = read_or_refused(text)
    if isinstance(own, str):
        assert "must be 3 numbers" in own
        assert pin.buildModelFromXML(text).inertias[1].mass == 0
        return
    lever = pin.buildModelFromXML(own.urdf).inertias[1].lever
    assert lever.tolist() == own.bodies[0].com.tolist() == [1.0, 2.0, 3.0]
    assert capfd.readouterr().err == ""


def test_shapes_that_are_none_disturb_no_reader(capfd):
    shape = '<visual><origin xyz="1 2"/><geometry><box size="1_0"/></geometry></visual>'
    own = robot(GOOD.replace("</inertial>", "</inertial>" + shape))
    assert pin.buildModelFromXML(own.urdf).inertias[1].mass == 1.0
    assert capfd.readouterr().err == ""


def test_a_urdf_is_one_by_what_it_holds(tmp_path):
    for name in ("arm.xml", "arm"):
        (tmp_path / name).write_text(GOOD)
        assert load_robot(str(tmp_path / name)).joints[0].name == "turn"


def test_friction_of_zero_however_written_is_nothing():
    for zero in ("0.00", " 0e5", "-0", ""):
        text = GOOD.replace(LIMIT, f'<dynamics friction="{zero}"/>{LIMIT}')
        assert robot(text).notes == ()


def test_damping_that_is_used_must_be_a_number_that_slows():
    for damping, fragment in (("-1", "must not be negative"), ("x", "a number"), ("1e13", "1e+12")):
        text = GOOD.replace(LIMIT, f'<dynamics damping="{damping}"/>{LIMIT}')
        assert "from-urdf" in robot(text).notes[0]
        with pytest.raises(InputError, match=re.escape("joint turn: dynamics.damping")) as error:
            robot(text, friction="from-urdf")
        assert fragment in str(error.value)
    used = robot(GOOD.replace(LIMIT, f'<dynamics damping="2"/>{LIMIT}'), friction="from-urdf")
    assert (used.friction.tolist(), used.notes) == ([2.0], ())
    stated = {"turn": {"kind": "direct", "friction_N_m_s_per_rad": 0.0}}
    assert robot(used.urdf, stated, friction="from-urdf").friction.tolist() == [0.0]


def test_a_mass_of_nothing_on_what_is_fixed_is_merged():
    """2 kg and an inertia of 0.01 kg m^2, 0.1 m off the axis: M = 0.03 kg m^2."""
    arm = Solid(2.0, (0, 0.1, 0), (0.01, 0, 0, 0.01, 0, 0.01))
    tool = Solid(1e-15, inertia=(1e-11, 0, 0, 1e-11, 0, 1e-11))
    own = robot(
        urdf(GROUND, link("arm", arm), link("t", tool), TURN, joint("f", "arm", "t", "fixed"))
    )
    assert own.notes == ()
    np.testing.assert_allclose(mass_matrices(own, [0.0]), 0.03, rtol=1e-6)


ROD = Solid(1.0, (0.1, 0, 0), (0.1, 0.1, 0, 0.1, 0, 0.2))  # along the diagonal of x and y


@pytest.mark.parametrize(
    ("solid", "axis", "mass"),
    [(Solid(1.0, (0, 0, -1), (0,) * 6), (0, 1, 0), 1.0), (ROD, (0, 0, 1), 0.21)],
)
def test_point_masses_and_thin_rods_are_bodies(solid, axis, mass):
    own = robot(urdf(GROUND, link("arm", solid), joint("turn", "ground", "arm", axis=axis)))
    found = compare_engines(own, sample_states(own, 3, 0))
    assert max(each.measured for each in found) < 1e-14
    np.testing.assert_allclose(mass_matrices(own, [0.0]), mass, rtol=1e-6)


def test_an_inertia_of_another_unit_is_reported():
    """The radii of gyration are the roots of inertia over mass; the robot is 0.1 m long."""
    arm = Solid(1.5, (0.1, 0, 0), (0.001, 0, 0, 0.005, 0, 0.005))
    servo = Solid(0.00186, (-0.0176, 0, 0), (2.32e-3, 0, 0, 7.83e-3, 0, 8.06e-3))
    parts = joint("servo", "arm", "servo", at=(0.07, 0, 0)), link("servo", servo)
    (note,) = robot(urdf(GROUND, link("arm", arm), TURN, *parts)).notes
    assert note.startswith("link servo: radii of gyration of 1.1, 2.1, 2.1 m")
    right = servo._replace(inertia=np.array(servo.inertia) / 1e6)
    assert robot(urdf(GROUND, link("arm", arm), TURN, parts[0], link("servo", right))).notes == ()


@pytest.mark.parametrize(("density", "notes"), [(0.9, 1), (1.1, 0)])
def test_what_is_far_out_and_lighter_than_air_is_doubted(density, notes):
    """A radius of gyration of 12 robots' sizes; density: mass over its cube [kg/m^3]."""
    radius = 1.2
    mass = density * radius**3
    each = mass * radius**2
    sail = Solid(mass, (0.1, 0, 0), (each, 0, 0, each, 0, each))
    assert len(robot(urdf(GROUND, link("arm", sail), TURN)).notes) == notes


def test_a_heavy_base_of_several_limbs_is_reported_as_held():
    body = link("body", Solid(5.0))
    legs = [joint(name, "body", name) + link(name, Solid()) for name in ("left", "right")]
    (note,) = robot(urdf(body, *legs)).notes
    assert note.startswith("link body is fixed to the ground, with its 5 kg")
    assert robot(urdf(body, legs[0])).notes == robot(urdf(link("body"), *legs)).notes == ()
    foot = joint("ankle", "left", "foot") + link("foot", Solid())
    assert robot(urdf(body, *legs, foot)).tip == "foot"
