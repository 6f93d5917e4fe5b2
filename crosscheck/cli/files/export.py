"""`crosscheck export`: the equations of a model as a file that other programs can use."""

from __future__ import annotations

import ctypes
import io
import platform
import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

from crosscheck import __version__
from crosscheck.analytic.kernel.export import generate_c_source
from crosscheck.analytic.kernel.fmu import generate_fmu_sources, generate_unit
from crosscheck.analytic.model import AnalyticModel
from crosscheck.analytic.robot.equations import build_equations
from crosscheck.analytic.robot.export import generate_robot_c_source
from crosscheck.cli.files.robot_files import export_as_robot
from crosscheck.file_types import C_FILE, FMU_FILE
from crosscheck.mechanisms import supply
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import InputError, format_line, make_printable
from crosscheck.models.files import URDF
from crosscheck.models.loading import load_selection
from crosscheck.models.mechanism import find_section, select_mechanism
from crosscheck.models.robot.robot import LEVELS, Level, Robot
from crosscheck.output import require_file, write_files
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.registry import BUILT_IN, build, load_model_class
from crosscheck.runner.isolated_reading import read_in_subprocess
from crosscheck.runner.process_tree import limit_resources

COMPILERS = ("cc", "gcc", "clang")
FOLDERS = {"Linux": ("linux64", ".so"), "Darwin": ("darwin64", ".dylib")}
COMPILER_S, COMPILER_BYTES = 120, 4_000_000_000  # a unit of seven joints takes 5 s
FIRST_DAY = (1980, 1, 1, 0, 0, 0)  # date of all files in a unit, so that it is the same every time


class EquationsText(NamedTuple):
    """Equations of a model as text of C, and those of a unit around it: code and description.

    prefix: of the functions' names; content: their results, in words.
    """

    prefix: str
    text: str
    make_unit: Callable[[], tuple[str, str]]
    content: str


def export_command(arm: str, model: str | None, settings: list[str], out: Path) -> None:
    """Write a model as C or FMU, or an arm or robot as URDF and file. Raises InputError."""
    unit = out.suffix == ".fmu"
    if out.suffix == URDF:
        if model is not None:
            raise InputError("--model", "", model, "must be left out: a URDF holds no model")
        export_as_robot(arm, settings, out)
        return
    if model is None:
        raise InputError("--model", "", None, "is missing, such as analytic:links")
    require_file(out, FMU_FILE if unit else C_FILE, "--out")
    chosen: EquationsText = supply("export", find_section(arm))(arm, model, settings)
    content = unit_file(chosen.prefix, *chosen.make_unit()) if unit else chosen.text
    write_files({out: content})
    print(make_printable(f"wrote {out}: {chosen.content}"))


def export_arm(name: str, model: str, settings: list[str]) -> EquationsText:
    """Equations of a model of an arm. Raises InputError."""
    chosen = build_model(name, model, settings)
    prefix, layout = make_c_name(chosen.arm.name), chosen.layout
    text = generate_c_source(chosen.term_equations, prefix, describe_model(chosen))
    unit = partial(generate_fmu_sources, text, prefix, layout, len(chosen.arm.joints))
    content = f"M, bias, force and acceleration in {', '.join(layout.names)}"
    return EquationsText(prefix, text, unit, content)


def export_robot(name: str, model: str, settings: list[str]) -> EquationsText:
    """Accelerations, and M of rigid gears, of a robot at a level. Raises InputError."""
    robot: Robot = select_mechanism(name, (), settings).mechanism
    levels = {f"analytic:{level}": level for level in LEVELS if robot.find_level(level)}
    if model not in levels:
        raise InputError("--model", "", model, f"must be one of {', '.join(levels)}")
    equations, prefix = build_equations(robot, levels[model]), make_c_name(robot.name)
    states, efforts = robot_variables(robot, levels[model])
    text = generate_robot_c_source(equations, prefix, describe_robot_model(robot, model, states))
    unit = partial(generate_unit, text, prefix, states, efforts)
    content = f"accelerations in {', '.join(state for state, _ in states)}"
    return EquationsText(prefix, text, unit, content)


def robot_variables(robot: Robot, level: Level) -> tuple[list[tuple[str, str]], list[str]]:
    """Name and unit of every coordinate of a robot at a level, and the units of its torques."""
    slides = [number in robot.slides for number, _ in enumerate(robot.coordinates, 1)]
    names = robot.state_names(level)
    units = ["m" if each else "rad" for each in slides] + ["m"] * (len(names) - len(slides))
    return list(zip(names, units, strict=True)), ["N" if each else "N.m" for each in slides]


def describe_robot_model(robot: Robot, model: str, states: list[tuple[str, str]]) -> str:
    """The text at the head of a robot's exported file."""
    return _format_head(
        f"{robot.name}, {model}: accelerations under torques [N m, N] of the motors at the free"
        f" joints. Coordinates q: {', '.join(f'{n} [{u}]' for n, u in states)}."
    )


def unit_file(prefix: str, code: str, description: str) -> bytes:
    """Content of a unit for this machine, compiled here, with its source. Raises InputError."""
    folder, suffix = FOLDERS[platform.system()]
    files = {
        "modelDescription.xml": description.encode(),
        f"sources/{prefix}.c": code.encode(),
        f"binaries/{folder}/{prefix}{suffix}": _compile_library(code),
    }
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name, FIRST_DAY), content)
    return buffer.getvalue()


def _compile_library(code: str) -> bytes:
    """Content of the shared library of C code. Raises InputError."""
    compiler = next(filter(None, map(shutil.which, COMPILERS)), None)
    if compiler is None:
        reason = f"an FMU needs a C compiler, one of {', '.join(COMPILERS)}"
        raise InputError("--out", "", None, reason)
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "unit.c"), Path(folder, "unit.so")
        source.write_text(code, encoding="utf-8")
        made = ["-o", str(library), str(source), "-lm"]
        command = [compiler, "-std=c11", "-O2", "-fPIC", "-shared", *made]
        fails = f"{compiler} cannot compile the FMU"
        if complaint := read_in_subprocess("--out", _compile, command, library, fails=fails):
            raise InputError("--out", "", None, f"{fails}: {complaint}")
        return library.read_bytes()


def _compile(command: list[str], library: Path) -> str:
    """Run a compiler within limits, in a process of its own; returns its complaint."""
    limit_resources(COMPILER_BYTES, COMPILER_S)
    ended = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace"
    )
    if ended.returncode:
        return format_line(ended.stderr) or f"exit code {ended.returncode}"
    try:
        ctypes.CDLL(str(library)).fmi2Instantiate  # noqa: B018
    except (OSError, AttributeError):
        return "its output is not a library for this machine"
    return ""


def build_model(arm: str, model: str, settings: list[str]) -> AnalyticModel:
    """The named model, whose equations are text. Raises InputError for any other."""
    analytic = [name for name in BUILT_IN if issubclass(load_model_class(name), AnalyticModel)]
    if model not in analytic:
        raise InputError("--model", "", model, f"must be one of {', '.join(analytic)}")
    loaded = load_selection(arm, [], settings)
    switches = loaded.switches or usual_switches(loaded.arm)
    exported_model = build(model, loaded.arm, make_unequal_gains_scenario(loaded.arm), switches)
    assert isinstance(exported_model, AnalyticModel)
    return exported_model


def make_c_name(name: str) -> str:
    """An identifier of C made from a name."""
    return re.sub(r"\W|^(?=\d)", "_", name, flags=re.ASCII)


def describe_model(model: AnalyticModel) -> str:
    """The text at the head of an exported file."""
    units = (f"{c.name} [{'rad' if c.is_angle else 'm'}]" for c in model.layout.coordinates)
    laws = ", ".join(f"{key} {value}" for key, value in model.switches.model_dump().items())
    return _format_head(
        f"{model.arm.name}, {model.name}: M(q) q'' + bias(q, v) = force(t, q, v, torque)."
        f" Coordinates q: {', '.join(units)}; torque [N m] of the drive on the output side of each"
        f" joint; M row by row. Laws: {laws}."
    )


def _format_head(content: str) -> str:
    """The head of a file with some equations, which ends no comment of C."""
    text = (
        f"Equations of motion of {content} Compilers must keep the order of operations: no"
        f" -ffast-math. Written by crosscheck export, geararm-crosscheck {__version__}."
    )
    return text.replace("*/", "* /")
