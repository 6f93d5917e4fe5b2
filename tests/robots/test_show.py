"""`show` of a robot: every doubtful inertia at once, with what would repair it."""

import numpy as np
import pinocchio as pin
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.mechanism import read_robot_data
from crosscheck.models.robot.file import RobotFile, build_robot
from crosscheck.provenance import ROOT
from tests.robots.chains import BOB, Solid, joint, link, urdf

BODY = (0.01, 0.001, 0.0, 0.02, 0.002, 0.015)
SLIPS = {  # mass and inertia of a link; the first has none
    "left_arm": (1.0, BODY),
    "right_arm": (1.0, (*BODY[:5], 0.15)),
    "order": (1.0, (0.01, 0.02, 0.015, 0.001, 0.0, 0.002)),
    "decade": (1.0, (0.01, 0.0, 0.0, 0.2, 0.0, 0.015)),
    "sign": (1.0, (0.01, 0.0, 0.0, -0.02, 0.0, 0.015)),
    "coarse": (1.0, (0.01, 0.0, 0.0, 0.01, 0.0, 0.0249)),
    "beyond a quarter": (1.0, (0.01, 0.0, 0.0, 0.01, 0.0, 0.0252)),
    "unit": (0.00186, (2.32e-3, 0, 0, 7.83e-3, 0, 8.06e-3)),
}


def test_every_doubtful_inertia_is_reported_with_its_repair(
    crosscheck, tmp_path, snapshot: SnapshotAssertion
):
    parts = [link("ground"), *(joint(f"to {name}", "ground", name) for name in SLIPS)]
    for name, (mass, inertia) in SLIPS.items():
        parts.append(link(name, Solid(mass, (0.1, 0.0, 0.0), inertia)))
    (tmp_path / "robot.urdf").write_text(urdf(*parts))
    answer = crosscheck("show", tmp_path / "robot.urdf")
    assert answer.out == snapshot
    assert (answer.code, answer.err.count("\n")) == (2, 1)  # no robot has a negative inertia


def test_a_robot_of_possible_bodies_is_shown(crosscheck):
    answer = crosscheck("show", "sliding")
    assert answer.code == 0
    assert answer.out.startswith("Robot sliding")
    bodies = pin.buildModelFromUrdf(str(ROOT / "models" / "robots" / "sliding.urdf")).inertias
    lines = [line for line in answer.out.splitlines() if "principal inertias" in line]
    heads = ("swivel: revolute", "slide: prismatic", "tilt: revolute")
    for head, body, line in zip(heads, list(bodies)[1:], lines, strict=True):
        values = ", ".join(f"{value:.3g}" for value in np.linalg.eigvalsh(body.inertia))
        assert line == (
            f"{head}, moves {body.mass:.4g} kg with all that is fixed to it,"
            f" of principal inertias {values} kg m^2"
        )


@pytest.mark.parametrize(("inertia", "is_doubtful"), [(1e-4, False), (100.0, True)])
def test_a_rotor_beyond_all_links_is_doubted(inertia, is_doubtful):
    content, rotor = read_robot_data("sliding"), {"kind": "geared", "rotor_inertia_kg_m2": inertia}
    names = "swivel", "slide", "tilt"
    content["robot"]["joints"] = {name: {**rotor, "ratio": 300.0} for name in names}
    file = RobotFile.model_validate(content["robot"])
    said = [each for each in build_robot(file, content["urdf"], "", "").notes if "rotor" in each]
    assert said == is_doubtful * [
        "joints swivel, tilt: their rotors of 100 kg m^2 are 9e+06 kg m^2 at the joints, beside at"
        " most 78 kg m^2 of all links; used as given",
        "joint slide: its rotor of 100 kg m^2 is 9e+06 kg at the joint, beside at most"
        " 30 kg of all links; used as given",
    ]


def test_friction_and_free_planets_of_a_joint_are_shown(crosscheck, tmp_path):
    crosscheck("export", "planets-apart", "--out", tmp_path / "a.urdf")
    shown = crosscheck("show", tmp_path / "a.toml").out
    assert "; friction 4.5 N m s/rad; planets move by themselves" in shown
    assert "; friction 2.2 N m s/rad; planets move by themselves" in shown
    assert "; friction" not in crosscheck("show", "puma560").out
    (tmp_path / "disc.urdf").write_text(BOB.replace('<mass value="2.0"/>', '<mass value="0"/>'))
    assert "swing: revolute, moves 0 kg with" in crosscheck("show", tmp_path / "disc.urdf").out


MIMIC = """<mujoco><worldbody><body><freejoint/><geom size="0.1"/>
<body><joint name="a"/><geom size="0.1"/><body><joint name="b"/><geom size="0.1"/></body></body>
</body></worldbody><equality><joint joint1="a" joint2="b" polycoef="0 0.5 0 0 0"/></equality>
</mujoco>"""


def test_joints_without_a_body_and_those_that_follow_are_shown(crosscheck, tmp_path):
    (tmp_path / "robot.xml").write_text(MIMIC)
    lines = crosscheck("show", tmp_path / "robot.xml").out.splitlines()
    assert "joint_0_pitch: revolute, massless" in lines
    assert any(line.startswith("a: revolute, follows b times 0.5, moves") for line in lines)
