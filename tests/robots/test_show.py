"""`show` of a robot: every doubtful inertia at once, with what would repair it."""

import numpy as np
import pinocchio as pin
import pytest

from crosscheck.provenance import ROOT
from tests.robots.chains import Solid, joint, link, urdf

BODY = (0.01, 0.001, 0.0, 0.02, 0.002, 0.015)
REST = "iyy 0.02, iyz 0.002, izz 0.015,"
SLIPS = {
    "right_arm": (1.0, (*BODY[:5], 0.15), "twin left_arm has ixx 0.01, ixy 0.001, ixz 0, " + REST),
    "order": (1.0, (0.01, 0.02, 0.015, 0.001, 0.0, 0.002), "ixx, iyy, izz, ixy, ixz, iyz"),
    "decade": (1.0, (0.01, 0.0, 0.0, 0.2, 0.0, 0.015), "possible if iyy is 0.02"),
    "sign": (1.0, (0.01, 0.0, 0.0, -0.02, 0.0, 0.015), "without the signs of ixx, iyy and izz"),
    "coarse": (1.0, (0.01, 0.0, 0.0, 0.01, 0.0, 0.0249), "24 % too large"),
    "beyond a quarter": (1.0, (0.01, 0.0, 0.0, 0.01, 0.0, 0.0252), "possible if"),
    "unit": (0.00186, (2.32e-3, 0, 0, 7.83e-3, 0, 8.06e-3), "in kg mm^2: times 1e-06"),
}


@pytest.fixture
def doubtful(tmp_path):
    """A robot whose links have a slip each."""
    solids = {"left_arm": (1.0, BODY, ""), **SLIPS}
    parts = [link("ground")]
    for name, (mass, inertia, _) in solids.items():
        parts += [
            link(name, Solid(mass, (0.1, 0.0, 0.0), inertia)),
            joint(f"to {name}", "ground", name),
        ]
    file = tmp_path / "robot.urdf"
    file.write_text(urdf(*parts))
    return file


def test_every_doubtful_inertia_is_reported_with_its_repair(crosscheck, doubtful):
    answer = crosscheck("show", doubtful)
    lines = answer.out.splitlines()
    assert [line.split(":")[0] for line in lines] == [f"link {name}" for name in SLIPS]
    for line, (_, _, repair) in zip(lines, SLIPS.values(), strict=True):
        assert repair in line
    assert answer.code == 2  # of a negative inertia no robot can be made
    assert answer.err.count("\n") == 1


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


def test_friction_and_free_planets_of_a_joint_are_shown(crosscheck, tmp_path):
    crosscheck("export", "planets-apart", "--out", tmp_path / "a.urdf")
    shown = crosscheck("show", tmp_path / "a.toml").out
    assert "; friction 4.5 N m s/rad; planets move by themselves" in shown
    assert "; friction 2.2 N m s/rad; planets move by themselves" in shown
    assert "; friction" not in crosscheck("show", "puma560").out


MIMIC = """<mujoco><worldbody><body><freejoint/><geom size="0.1"/>
<body><joint name="a"/><geom size="0.1"/><body><joint name="b"/><geom size="0.1"/></body></body>
</body></worldbody><equality><joint joint1="a" joint2="b" polycoef="0 0.5 0 0 0"/></equality>
</mujoco>"""


def test_joints_without_a_body_and_those_that_follow_are_shown(crosscheck, tmp_path):
    (tmp_path / "robot.xml").write_text(MIMIC)
    lines = crosscheck("show", tmp_path / "robot.xml").out.splitlines()
    assert "joint_0_pitch: revolute, massless" in lines
    assert any(line.startswith("a: revolute, follows b times 0.5, moves") for line in lines)
