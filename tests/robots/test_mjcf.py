"""MJCF is read through MuJoCo: its own dynamics of the file are those of the robot made of it."""

import os
import sys

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.errors import InputError
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.mjcf import reading
from crosscheck.runner.tasks import build_robot_model
from tests.loops import require_items
from tests.tool.test_bad_input import assert_one_line

BODY = '<mujoco><worldbody><body name="a">{}<geom size="1"/></body></worldbody>{}</mujoco>'
ARM = """
<mujoco>
  <compiler angle="degree"/>
  <option gravity="0 1 -5"/>
  <worldbody>
    <body name="upper" pos="0 .2 1" euler="10 20 30">
      <joint name="turn" axis="0 1 .2" pos="0 .3 .1" ref="30" armature=".2" damping="1"/>
      <inertial pos=".1 .2 .3" mass="3" diaginertia=".1 .2 .25" quat="1 .2 .3 .4"/>
      <body name="plate" pos="0 .1 0"><geom type="box" size=".1 .2 .3" euler="10 10 20"/>
        <body name="slider" pos=".5 0 0">
          <joint name="slide" type="slide" axis="1 0 0" ref=".2" pos=".3 .2 .1"
            actuatorfrcrange="-7 5"/>
          <inertial pos=".1 0 0" mass="2" diaginertia=".1 .2 .25"/>
        </body>
      </body>
      <body pos="0 .3 0">
        <joint name="follow" axis="0 0 1" range="-90 45" ref="5"/>
        <geom type="sphere" size=".1" pos=".2 0 0"/>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="follow" joint2="turn" polycoef=".1 2 0 0 0"/></equality>
  <actuator><motor joint="slide"/><motor joint="turn" gear="-100"/></actuator>
</mujoco>
"""


@pytest.fixture
def arm(tmp_path):
    """The file of an arm with all that is read."""
    file = tmp_path / "arm.xml"
    file.write_text(ARM)
    return file


def mass_matrix(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """MuJoCo's M (nv, nv) at the data's state, whose forces are worked out too."""
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, full, data.qM)
    return full


def test_the_robot_moves_as_mujocos_own_model(arm):
    robot = load_robot(str(arm))
    model = mujoco.MjModel.from_xml_path(str(arm))
    data = mujoco.MjData(model)
    links, derived = (build_robot_model("analytic", robot, x) for x in ("links", "armature"))
    rows = [model.joint(joint.name).dofadr[0] for joint in robot.joints]
    factors, offsets = robot.joint_map
    given = np.zeros((model.nv, len(robot.coordinates)))
    given[rows] = factors
    q, v = np.random.default_rng(0).uniform(-1, 1, (2, 5, 2))
    for at, rate in require_items(zip(q, v, strict=True)):
        data.qpos[rows], data.qvel[:] = factors @ at + offsets, given @ rate
        full = mass_matrix(model, data)
        # A joint that follows another is where MuJoCo's own equality has it.
        (equality,) = data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
        assert abs(equality) < 1e-14  # rounding of a few sums of numbers near 1
        masses = given.T @ full @ given
        bare = given.T @ (full - np.diag(model.dof_armature)) @ given
        torques = given.T @ data.qfrc_bias
        own = derived.inverse_dynamics(at[None], rate[None], np.zeros((1, 2)))[0]
        # The box is turned by a quaternion of single rounding errors; MuJoCo's own M has them too.
        assert np.abs(derived.mass_matrix(at[None])[0] - masses).max() < 1e-11 * masses.max()
        assert np.abs(links.mass_matrix(at[None])[0] - bare).max() < 1e-11 * masses.max()
        assert np.abs(own - torques).max() < 1e-11 * np.abs(torques).max()


def test_limits_are_those_of_the_file(arm):
    """In radians, of the coordinate as the file counts it."""
    limits = {joint.name: joint.limits for joint in load_robot(str(arm)).joints}
    follow, slide = limits["follow"], limits["slide"]
    assert (follow.lower, follow.upper) == pytest.approx((-np.pi / 2, np.pi / 4), rel=1e-15)
    assert slide.upper == -slide.lower == 1e18  # as URDFs have what is not limited
    assert (slide.effort, follow.effort) == (7.0, np.inf)


ACROSS = """<mujoco><worldbody><body quat="{0}"><joint axis="0 0 1"/>
<inertial pos=".1 .2 .3" mass="3" fullinertia=".3 .3 .35 .01 .02 .03"/>
<body pos=".1 .2 .3" quat="{0}"><joint axis="1 0 0"/>
<inertial pos=".1 .2 .1" mass="2" fullinertia=".3 .3 .35 .01 .02 .03"/>
</body></body></worldbody></mujoco>"""


@pytest.mark.parametrize("pitch", [90.0, -90.0, 90.0 - 1e-7, 20.0])
@pytest.mark.parametrize("roll", [0.25, 1.3, -2.0])
def test_a_frame_that_stands_on_end_is_the_same(tmp_path, pitch, roll):
    """Roll and yaw are one angle where a frame's pitch is a right one."""
    turn = Rotation.from_euler("xyz", [roll, np.deg2rad(pitch), 0.7])
    file = tmp_path / "arm.xml"
    file.write_text(ACROSS.format(" ".join(map(repr, turn.as_quat(scalar_first=True).tolist()))))
    model = mujoco.MjModel.from_xml_path(str(file))
    data, robot = mujoco.MjData(model), load_robot(str(file))
    data.qpos[:] = q = np.array([0.3, 0.5])
    mujoco.mj_forward(model, data)
    weights = build_robot_model("analytic", robot, "links").inverse_dynamics(
        q[None], np.zeros((1, 2)), np.zeros((1, 2))
    )
    assert weights[0] == pytest.approx(data.qfrc_bias, rel=1e-12, abs=1e-12)


def test_an_inertia_that_the_file_states_keeps_its_digits(tmp_path):
    """MuJoCo's principal axes would give some 1e-6 of it."""
    stated = '<joint/><inertial pos="0 0 0" mass="1" fullinertia=".1 .2 .25 .01 .02 .03"/>'
    (tmp_path / "arm.xml").write_text(BODY.format(stated, ""))
    (body,) = load_robot(str(tmp_path / "arm.xml")).bodies
    right = [[0.1, 0.01, 0.02], [0.01, 0.2, 0.03], [0.02, 0.03, 0.25]]
    assert np.array_equal(body.inertia, right)


def test_init_takes_gear_armature_and_gravity(crosscheck, tmp_path, arm):
    answer = crosscheck("init", tmp_path / "arm.toml", "--urdf", arm)
    first, turn, *_ = answer.out.splitlines()
    assert first.endswith("arm.toml: 2 joints, 1 geared as arm.xml states")
    assert turn.endswith("gear -100 of motor on turn, armature 0.2 kg m^2 of joint turn")
    robot = load_robot(str(tmp_path / "arm.toml"))
    (rotor,) = robot.rotors
    assert (robot.joints[rotor.joint].name, rotor.ratio) == ("turn", -100.0)
    assert rotor.inertia == pytest.approx(0.2 / 100**2, rel=1e-15)
    assert robot.gravity.tolist() == [0.0, 1.0, -5.0]
    assert (
        'damping of turn is not used; friction = "from-urdf" in a robot file uses it' in robot.notes
    )
    assert robot.armature.tolist() == [0.0, 0.0]
    assert not any("armature of" in note or "gear -100" in note for note in robot.notes)


def test_without_mujoco_one_line_says_what_to_do(crosscheck, monkeypatch, arm):
    reading.read_mjcf.cache_clear()
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert_one_line(crosscheck("validate", arm), ".venv/bin/pip install -e '.[mjcf]'")


PENDULA = """<mujoco>{}<worldbody><body name="a" pos="0 0 1"><joint name="j1" axis="0 1 0"/>
<inertial pos=".3 0 0" mass="2" diaginertia=".02 .1 .1"/>
<body name="b" pos=".6 0 0"><joint name="j2" axis="0 1 0"/>
<inertial pos=".2 0 0" mass="1" diaginertia=".01 .04 .04"/></body></body></worldbody>{}</mujoco>"""
FLAG = '<option><flag {}="disable"/></option>'
JOINT2 = 'name="j2" axis="0 1 0"'
FOLLOW = '<equality><joint joint1="j2" joint2="j1"/></equality>'
AS_MUJOCO = {
    "gravity disabled": PENDULA.format(FLAG.format("gravity"), ""),
    "gravcomp of all": PENDULA.format("", "").replace("<body ", '<body gravcomp=".25" '),
    "equality not active": PENDULA.format("", FOLLOW.replace("/></", ' active="false"/></')),
    "loop not active": PENDULA.format(
        "", '<equality><connect body1="b" anchor=".4 0 0" active="false"/></equality>'
    ),
    "equalities disabled": PENDULA.format(FLAG.format("equality"), FOLLOW),
    "constraints disabled": PENDULA.format(FLAG.format("constraint"), FOLLOW),
    "armature": PENDULA.format("", "").replace(JOINT2, f'{JOINT2} armature=".3"'),
    "joints of one body": """<mujoco><worldbody><body name="t" pos="0 .1 0" euler="10 20 30">
        <joint name="x" type="slide" axis="1 0 .5" pos=".1 0 .2" ref=".1"/>
        <joint name="z" axis="0 0 1" pos=".3 .1 0" ref="20"/>
        <joint name="r" axis="0 1 .2" pos="0 .2 .1"/>
        <inertial pos=".1 .2 0" mass="3" diaginertia=".1 .1 .1"/></body></worldbody></mujoco>""",
}


@pytest.mark.parametrize("case", AS_MUJOCO)
def test_what_a_file_switches_is_as_mujoco_has_it(tmp_path, case):
    (tmp_path / "arm.xml").write_text(AS_MUJOCO[case])
    model, robot = (
        mujoco.MjModel.from_xml_string(AS_MUJOCO[case]),
        load_robot(str(tmp_path / "arm.xml")),
    )
    data, derived = mujoco.MjData(model), build_robot_model("analytic", robot, "armature")
    q, v = np.random.default_rng(0).uniform(-1, 1, (2, model.nv))
    data.qpos[:], data.qvel[:] = q, v
    full = mass_matrix(model, data)
    held = derived.inverse_dynamics(q[None], v[None], np.zeros((1, model.nv)))[0]
    assert derived.mass_matrix(q[None])[0] == pytest.approx(full, rel=1e-12, abs=1e-14)
    right = data.qfrc_bias - data.qfrc_gravcomp
    assert held == pytest.approx(right, rel=1e-12, abs=1e-13)


def test_of_armature_without_a_gear_nothing_but_the_ratio_is_lacking(crosscheck, tmp_path):
    (tmp_path / "arm.xml").write_text(AS_MUJOCO["armature"])
    robot = load_robot(str(tmp_path / "arm.xml"))
    assert "armature of j2 is on the diagonal" in robot.notes[-1]
    answer = crosscheck("cost", tmp_path / "arm.xml", "--quick")
    assert answer.code == 0
    assert "depends on the ratio of j2, the only number that is missing" in answer.out
    assert "nothing to compare" not in answer.out
    assert "without gears: j1\n" in answer.out


def test_shapes_may_be_missing_where_each_body_states_its_inertia(tmp_path):
    shapes = (
        '<asset><mesh name="m" file="no.stl"/><texture name="t" type="2d" file="no.png"/>'
        '<material name="t" texture="t"/><hfield name="h" file="no.png" size="1 1 1 1"/></asset>'
        '<default><geom material="t"/></default>'
    )
    text = PENDULA.format(shapes, '<contact><pair geom1="g" geom2="ground"/></contact>')
    text = text.replace("<worldbody>", '<worldbody><geom name="ground" type="hfield" hfield="h"/>')
    fitted = '<geom name="g" type="mesh" mesh="m"/><geom type="box" mesh="m"/><inertial'
    stated = text.replace("<inertial", fitted, 1)
    (tmp_path / "arm.xml").write_text(stated)
    robot = load_robot(str(tmp_path / "arm.xml"))
    assert [body.mass for body in robot.bodies] == [2.0, 1.0]
    assert "contacts of geoms (3) are not used" in robot.notes
    (tmp_path / "arm.xml").write_text(
        stated.replace('<inertial pos=".3 0 0" mass="2" diaginertia=".02 .1 .1"/>', "")
    )
    with pytest.raises(InputError, match=r"Error opening file .*no\.(stl|png)"):
        load_robot(str(tmp_path / "arm.xml"))


HOSTILE = {
    "copies": ("<replicate count='1000000' offset='1 0 0'>{}</replicate>", "takes more than 1 s"),
    "a pipe": ("{}<include file='pipe.xml'/>", "waits for a file that is none"),
    "a height field": (
        "{}</worldbody><asset><hfield name='h' nrow='100000' ncol='100000' size='1 1 1 1'/></asset>"
        "<worldbody>",
        "too large for the memory",
    ),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_file_that_never_ends_is_one_line(crosscheck, tmp_path, monkeypatch, case):
    text, said = HOSTILE[case]
    monkeypatch.setattr(reading, "PROCESSOR_S", 1)
    monkeypatch.setattr(reading, "IDLE_S", 0.5)
    os.mkfifo(tmp_path / "pipe.xml")
    body = "<body><joint/><geom size='1'/><geom type='mesh' mesh='m'/></body>"
    file = tmp_path / "arm.xml"
    file.write_text(f"<mujoco><worldbody>{text.format(body)}</worldbody></mujoco>")
    assert_one_line(crosscheck("show", file), said)
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()


def test_a_reader_that_dies_takes_nothing_with_it(tmp_path, monkeypatch):
    (tmp_path / "arm.xml").write_text(PENDULA.format("", ""))
    monkeypatch.setattr(reading, "convert_file", lambda *names: os.abort())
    with pytest.raises(InputError, match="ends its process by SIGABRT"):
        reading.read_mjcf(tmp_path / "arm.xml", "another text")


def test_show_names_what_is_not_used_in_the_words_of_the_file(
    crosscheck, tmp_path, snapshot: SnapshotAssertion
):
    default = '<default><joint armature=".02" damping=".3" frictionloss=".1"/></default>'
    motor = '<actuator><motor joint="j1" gear="100"/></actuator>'
    (tmp_path / "arm.xml").write_text(PENDULA.format(default, motor))
    (tmp_path / "arm.toml").write_text('schema_version = 1\nname = "a"\nurdf = "arm.xml"\n')
    for name in ("arm.xml", "arm.toml"):
        lines = crosscheck("show", tmp_path / name).out.splitlines()
        assert [line for line in lines if line.startswith("note: ")] == snapshot(name=name)
