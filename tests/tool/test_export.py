"""A model as one file of C: compiled, it says what the model says."""

import ctypes
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from crosscheck.checks.answers import sample_states
from crosscheck.checks.invariants import torques_at
from crosscheck.cli.export import build_model, function_prefix
from crosscheck.runner import cpu_limit
from tests.tool.test_bad_input import assert_one_line

COMPILER = shutil.which("gcc")
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


@pytest.mark.skipif(COMPILER is None, reason="no gcc here")
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
    call = compiled(file, function_prefix(model))
    for t, q, v in zip(*sample_states(model.layout, model.arm, 20, 5), strict=True):
        torque = torques_at(model.drive, t, q[theta], v[theta])
        assert torque.shape == (joints,)
        right = model.states.evaluate(t, q, v)
        close(call("mass_matrix", size * size, q).reshape(size, size), right.mass_matrix)
        close(call("bias", size, q, v), right.bias)
        close(call("force", size, t, q, v, torque), right.force)
        close(call("acceleration", size, t, q, v, torque), right.acceleration)


def compiled(file: Path, prefix: str):
    """``call(name, size, *arguments)`` of a file's functions, warnings being errors."""
    library = file.with_suffix(".so")
    strict = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]
    subprocess.run([str(COMPILER), *strict, "-o", library, file, "-lm"], check=True)
    functions = ctypes.CDLL(str(library))

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


def test_what_cannot_be_exported_is_one_line(crosscheck, tmp_path):
    out = tmp_path / "model.c"
    answer = crosscheck("export", "probe", "--model", "exudyn:tree", "--out", out)
    assert_one_line(answer, "--model = 'exudyn:tree': must be one of analytic:physical")
    answer = crosscheck("export", "three-unlike", "--model", "analytic:printed", "--out", out)
    assert_one_line(answer, "three-unlike: joints: analytic:printed")
    assert not out.exists()
    out.write_text("mine", encoding="utf-8")
    answer = crosscheck("export", "probe", "--model", "analytic:links", "--out", out)
    assert_one_line(answer, "exists and is not an exported C file")


COMPILERS = {
    "hangs": ("sleep 1000", "TooSlow: stopped after"),
    "writes nothing": ("exit 0", "what it wrote is no library of this machine"),
    "writes nonsense": ("echo x > $7", "what it wrote is no library of this machine"),
    "refuses": ("echo no such option >&2; exit 1", ": no such option"),
}


@pytest.mark.parametrize("case", COMPILERS)
def test_a_compiler_that_makes_no_library_is_one_line(crosscheck, case, tmp_path, monkeypatch):
    work, said = COMPILERS[case]
    (tmp_path / "cc").write_text(f"#!/bin/sh\n{work}\n")
    (tmp_path / "cc").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(cpu_limit, "IDLE_S", 0.5)
    monkeypatch.setattr(cpu_limit, "LOOK_S", 0.1)
    out = tmp_path / "unit.fmu"
    answer = crosscheck("export", "probe", "--model", "analytic:links", "--out", out)
    assert_one_line(answer, f"--out: {tmp_path / 'cc'} cannot compile the FMU", said)
    assert not out.exists()
