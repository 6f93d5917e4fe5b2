"""A robot as one file of C or an FMU: compiled, it says what Kane's method says."""

import shutil
from zipfile import ZipFile

import numpy as np
import pytest

from crosscheck.models.mechanism import select_mechanism
from crosscheck.provenance import ROOT
from crosscheck.registry import build_robot_model
from tests.robots.traced import random_state
from tests.tool.test_export import close, compiled

PLANETARY = str(ROOT / "examples" / "robots" / "planetary-arm.toml")

needs_compiler = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc here")


@needs_compiler
@pytest.mark.parametrize(
    ("name", "level", "prefix", "settings"),
    [
        ("puma560", "coupled", "puma560", ["robot.joints.elbow.friction_N_m_s_per_rad=4.0"]),
        (PLANETARY, "geared", "planetary_arm", ['robot.joints.elbow.planets="free"']),
    ],
)
def test_compiled_it_says_what_kanes_method_says(
    crosscheck, tmp_path, name, level, prefix, settings
):
    out, changes = tmp_path / "robot.c", [word for each in settings for word in ("--set", each)]
    answer = crosscheck("export", name, "--model", f"analytic:{level}", "--out", out, *changes)
    assert (answer.code, answer.err) == (0, "")
    robot = select_mechanism(name, (), settings).mechanism
    kane, call = build_robot_model("analytic", robot, level), compiled(out, prefix)
    q, v, torques = random_state(robot, level, 6, states=5)
    expected, mass = kane.forward_dynamics(q, v, torques), kane.mass_matrix(q)
    for k in range(5):
        found = call("acceleration", q.shape[1], 0.0, q[k], v[k], torques[k])
        close(mass[k] @ found, mass[k] @ expected[k])
        if level == "coupled":
            close(call("mass_matrix", mass[k].size, q[k]), np.ravel(mass[k]))


@needs_compiler
def test_an_fmu_has_joints_and_meshes_as_states(crosscheck, tmp_path):
    out = tmp_path / "robot.fmu"
    answer = crosscheck("export", "sliding", "--model", "analytic:geared", "--out", out)
    assert (answer.code, answer.err) == (0, "")
    with ZipFile(out) as unit:
        described = unit.read("modelDescription.xml").decode()
    for name, kind in (("slide", "m"), ("tilt", "rad"), ("x_tilt", "m"), ("torque_2", "N")):
        start = described.index(f'name="{name}"')
        assert f'unit="{kind}"' in described[start : described.index("</ScalarVariable>", start)]
