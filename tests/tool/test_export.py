"""A model as one file of C or an FMU: compiled, it says what the model says."""

import ctypes
import os
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.analytic.kernel.fmu import generate_unit
from crosscheck.checks.answers import sample_states
from crosscheck.cli.files.export import (
    _format_head,
    build_model,
    describe_model,
    describe_robot_model,
    make_c_name,
    robot_variables,
)
from crosscheck.models.experiment.drive import torques_at
from crosscheck.models.mechanism import select_mechanism
from crosscheck.models.robot.file import load_robot
from crosscheck.provenance import ROOT
from crosscheck.registry import build_robot_model
from tests.robots.traced import random_state
from tests.tool.test_bad_input import assert_one_line

COMPILER = shutil.which("gcc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no gcc here")
# The file has the kernel's operations in the kernel's order; a compiler may still fuse or reorder.
ROUNDING = 1e-12
SETTINGS = {
    "links": ("paper-labelled", "analytic:links", []),
    "coupled, three joints, weight": ("three-unlike", "analytic:coupled", []),
    "lumped": ("probe", "analytic:physical", ["switches.planets=lumped"]),
    "as printed": ("paper-labelled", "analytic:printed", []),
    "free, unlike, every stiffness law": ("three-unlike", "analytic:physical", []),
    "smooth": ("paper-labelled", "analytic:physical", ["switches.dead_zone=tanh"]),
    "conservative": (
        "probe",
        "analytic:physical",
        ["switches.mesh_work=conservative", "switches.damping=contact"],
    ),
    "frequency times time": ("paper-labelled", "analytic:physical", ["switches.phase=omega_t"]),
}


@needs_compiler
@pytest.mark.parametrize("setting", SETTINGS)
def test_compiled_it_says_what_the_model_says(crosscheck, setting, tmp_path):
    arm, name, laws = SETTINGS[setting]
    file = tmp_path / "model.c"
    given = [word for law in laws for word in ("--set", law)]
    answer = crosscheck("export", arm, "--model", name, "--out", file, *given)
    assert (answer.code, answer.err) == (0, "")
    model = build_model(arm, name, laws)
    stated = dict(law.removeprefix("switches.").split("=") for law in laws)
    assert stated.items() <= model.switches.model_dump().items()
    size, joints, theta = len(model.layout), len(model.arm.joints), model.layout.theta
    call = compiled(file, make_c_name(model.arm.name))
    for t, q, v in zip(*sample_states(model.layout, model.arm, 20, 5), strict=True):
        torque = torques_at(model.drive, t, q[theta], v[theta])
        assert torque.shape == (joints,)
        right = model.states.evaluate(t, q, v)
        close(call("mass_matrix", size * size, q).reshape(size, size), right.mass_matrix)
        close(call("bias", size, q, v), right.bias)
        close(call("force", size, t, q, v, torque), right.force)
        close(call("acceleration", size, t, q, v, torque), right.acceleration)


def load_library(file: Path) -> ctypes.CDLL:
    """A file of C, compiled with warnings as errors."""
    library = file.with_suffix(".so")
    strict = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]
    subprocess.run([str(COMPILER), *strict, "-o", library, file, "-lm"], check=True)
    return ctypes.CDLL(str(library))


def compiled(file: Path, prefix: str):
    """``call(name, size, *arguments)`` of a file's functions."""
    functions = load_library(file)

    def call(name: str, size: int, *arguments: float | np.ndarray) -> np.ndarray:
        result = np.full(size, np.nan)
        given = [
            a.ctypes.data_as(ctypes.c_void_p) if isinstance(a, np.ndarray) else ctypes.c_double(a)
            for a in arguments
        ]
        functions[f"{prefix}_{name}"](*given, result.ctypes.data_as(ctypes.c_void_p))
        return result

    return call


def close(found: np.ndarray, right: np.ndarray) -> None:
    assert np.abs(found - right).max() <= ROUNDING * np.abs(right).max()


# Of two coordinates and one torque, in the file's own order; the torque moves the second one.
MADE = """#include <stdint.h>
#include <string.h>
enum { N = 2, JOINTS = 1 };
void made_acceleration(double t, const double q[N], const double v[N],
                       const double torque[JOINTS], double a[N]) {
    a[0] = t + q[1], a[1] = torque[0] - v[0];
}
"""
STATES, EFFORTS = [("q_1", "rad"), ("slide <1>", "m")], ["N"]


def test_a_units_description_is_as_on_record(snapshot: SnapshotAssertion):
    """Variables, units and dependencies as the standard's chapters 2.2.7, 2.2.8 and 3.1 have them.

    A state's derivative names it by its place, counted from 1; states and inputs have a start.
    """
    code, description = generate_unit(MADE, "made", STATES, EFFORTS)
    guid = ElementTree.fromstring(description).get("guid", "")
    assert guid in code
    assert description.replace(guid, "GUID") == snapshot


@needs_compiler
def test_a_units_functions_answer_and_refuse_as_fmi_2_says(tmp_path):
    """0 is fmi2OK, 3 fmi2Error; what a unit has not (integers, saved states) is an error."""
    code, description = generate_unit(MADE, "made", STATES, EFFORTS)
    guid = ElementTree.fromstring(description).get("guid", "").encode()
    source = tmp_path / "unit.c"
    source.write_text(code, encoding="utf-8")
    unit = load_library(source)
    unit.fmi2Instantiate.restype = ctypes.c_void_p
    assert unit.fmi2Instantiate(b"a", 1, guid, None, None, 0, 0) is None  # co-simulation
    assert unit.fmi2Instantiate(b"a", 0, b"another", None, None, 0, 0) is None
    made_unit = ctypes.c_void_p(unit.fmi2Instantiate(b"a", 0, guid, None, None, 0, 0))
    numbers, references = (ctypes.c_double * 5), (ctypes.c_uint * 1)

    def real(reference: int) -> float:
        found = (ctypes.c_double * 1)()
        assert unit.fmi2GetReal(made_unit, references(reference), count(1), found) == 0
        return found[0]

    def set_real(reference: int, value: float) -> int:
        given = (ctypes.c_double * 1)(value)
        return unit.fmi2SetReal(made_unit, references(reference), count(1), given)

    count = ctypes.c_size_t
    for reference, value in ((0, 0.5), (1, 0.25), (2, 7.0), (3, -1.0), (8, 11.0)):
        assert set_real(reference, value) == 0
    assert [set_real(reference, 1.0) for reference in (4, 7, 9)] == [3, 3, 3]
    assert unit.fmi2SetTime(made_unit, ctypes.c_double(2.0)) == 0
    right = [0.5, 0.25, 7.0, -1.0, 7.0, -1.0, 2.25, 4.0, 11.0]
    assert [real(reference) for reference in range(9)] == right
    assert unit.fmi2GetReal(made_unit, references(9), count(1), numbers()) == 3
    for name in ("GetContinuousStates", "SetContinuousStates", "GetDerivatives"):
        ask = getattr(unit, f"fmi2{name}")
        assert [ask(made_unit, numbers(), count(size)) for size in (3, 4, 5)] == [3, 0, 3], name
    found = numbers(9.0, 9.0, 9.0, 9.0, 9.0)
    assert unit.fmi2GetNominalsOfContinuousStates(made_unit, found, count(4)) == 0
    assert [*found] == [1.0, 1.0, 1.0, 1.0, 9.0]
    for kind in ("Integer", "Boolean", "String"):
        for verb in ("Get", "Set"):
            ask = getattr(unit, f"fmi2{verb}{kind}")
            assert [ask(made_unit, None, count(size), None) for size in (0, 1)] == [0, 3]
    for name in ("GetFMUstate", "SetFMUstate", "FreeFMUstate", "GetDirectionalDerivative"):
        assert getattr(unit, f"fmi2{name}")(made_unit, None) == 3
    for name in ("EnterEventMode", "EnterContinuousTimeMode", "Terminate", "Reset"):
        assert getattr(unit, f"fmi2{name}")(made_unit) == 0
    assert real(8) == 0.0  # after a reset
    unit.fmi2FreeInstance(made_unit)


DESCRIBED = {
    "rigid": ("three-unlike", "analytic:links", []),
    "geared": ("probe", "analytic:physical", ["switches.phase=omega_t"]),
}


@pytest.mark.parametrize("name", DESCRIBED)
def test_a_file_says_first_what_it_is(name: str, snapshot: SnapshotAssertion):
    assert describe_model(build_model(*DESCRIBED[name])) == snapshot


def test_a_robots_file_says_first_what_it_is(snapshot: SnapshotAssertion):
    robot = load_robot("sliding")
    states, efforts = robot_variables(robot, "geared")
    assert states == [("swivel", "rad"), ("slide", "m"), ("tilt", "rad"), ("x_tilt", "m")]
    assert efforts == ["N.m", "N", "N.m"]
    assert describe_robot_model(robot, "analytic:geared", states) == snapshot


@pytest.mark.parametrize(
    ("name", "c_name"), [("a-b c", "a_b_c"), ("7axes", "_7axes"), ("arm2", "arm2"), ("ä", "_")]
)
def test_a_name_of_c_is_made_of_any_name(name, c_name):
    assert make_c_name(name) == c_name
    assert "*/" not in _format_head(f"{name} */")


COMPILERS = {
    "hangs": ("sleep 1000", "TooSlow: stopped after"),
    "writes nothing": ("exit 0", "its output is not a library for this machine"),
    "writes nonsense": ("echo x > $7", "its output is not a library for this machine"),
    "fails without a word": ("exit 4", ": exit code 4"),
    "refuses": ("echo no such option >&2; exit 1", ": no such option"),
}


@pytest.mark.parametrize("case", COMPILERS)
def test_a_compiler_that_makes_no_library_is_one_line(
    crosscheck, case, tmp_path, monkeypatch, impatient
):
    work, said = COMPILERS[case]
    (tmp_path / "cc").write_text(f"#!/bin/sh\n{work}\n")
    (tmp_path / "cc").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    out = tmp_path / "unit.fmu"
    answer = crosscheck("export", "probe", "--model", "analytic:links", "--out", out)
    assert_one_line(answer, f"--out: {tmp_path / 'cc'} cannot compile the FMU", said)
    assert not out.exists()


PLANETARY = str(ROOT / "examples" / "robots" / "planetary-arm.toml")


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
