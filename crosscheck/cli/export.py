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
from pathlib import Path

from crosscheck import __version__
from crosscheck.analytic.kernel.export import c_text
from crosscheck.analytic.kernel.fmu import fmu_sources
from crosscheck.analytic.model import AnalyticModel
from crosscheck.kinds import C_FILE, FMU_FILE
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import InputError, one_line
from crosscheck.models.loading import load_chosen
from crosscheck.output import require_file, write_files
from crosscheck.planning.sizing import unequal_gains
from crosscheck.registry import BUILT_IN, build, model_class
from crosscheck.report.words import printable
from crosscheck.runner.foreign import read_apart
from crosscheck.runner.process_tree import limit_resources

COMPILERS = ("cc", "gcc", "clang")
FOLDERS = {"Linux": ("linux64", ".so"), "Darwin": ("darwin64", ".dylib")}
COMPILER_S, COMPILER_BYTES = 120, 4_000_000_000  # a unit of seven joints takes 5 s
FIRST_DAY = (1980, 1, 1, 0, 0, 0)  # of all files in a unit, so that it is the same every time


def export_command(arm: str, model: str, settings: list[str], out: Path) -> None:
    """Write a model of an arm as a file of C, or as an FMU. Raises InputError."""
    chosen = model_of(arm, model, settings)
    unit = out.suffix == ".fmu"
    require_file(out, FMU_FILE if unit else C_FILE, "--out")
    prefix = prefix_of(chosen)
    text = c_text(chosen.term_equations, prefix, about(chosen))
    content = fmu_file(chosen, text, prefix) if unit else text
    write_files({out: content})
    names = ", ".join(chosen.layout.names)
    print(f"wrote {printable(str(out))}: M, bias, force and acceleration in {names}")


def fmu_file(model: AnalyticModel, text: str, prefix: str) -> bytes:
    """Content of a unit for this machine, compiled here, with its source. Raises InputError."""
    code, description = fmu_sources(text, prefix, model.layout, len(model.arm.joints))
    folder, suffix = FOLDERS[platform.system()]
    files = {
        "modelDescription.xml": description.encode(),
        f"sources/{prefix}.c": code.encode(),
        f"binaries/{folder}/{prefix}{suffix}": _compiled(code),
    }
    found = io.BytesIO()
    with zipfile.ZipFile(found, "w", zipfile.ZIP_STORED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name, FIRST_DAY), content)
    return found.getvalue()


def _compiled(code: str) -> bytes:
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
        if complaint := read_apart("--out", _compile, command, library, fails=fails):
            raise InputError("--out", "", None, f"{fails}: {complaint}")
        return library.read_bytes()


def _compile(command: list[str], library: Path) -> str:
    """Run a compiler within limits, in a process of its own; returns what it complains about."""
    limit_resources(COMPILER_BYTES, COMPILER_S)
    ended = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace"
    )
    if ended.returncode:
        return one_line(ended.stderr) or f"exit code {ended.returncode}"
    try:
        ctypes.CDLL(str(library)).fmi2Instantiate  # noqa: B018
    except (OSError, AttributeError):
        return "what it wrote is no library of this machine"
    return ""


def model_of(arm: str, model: str, settings: list[str]) -> AnalyticModel:
    """The named model, whose equations are text. Raises InputError for any other."""
    own = [name for name in BUILT_IN if issubclass(model_class(name), AnalyticModel)]
    if model not in own:
        raise InputError("--model", "", model, f"must be one of {', '.join(own)}")
    loaded = load_chosen(arm, [], settings)
    switches = loaded.switches or usual_switches(loaded.arm)
    found = build(model, loaded.arm, unequal_gains(loaded.arm), switches)
    assert isinstance(found, AnalyticModel)
    return found


def prefix_of(model: AnalyticModel) -> str:
    """Prefix of the functions' names: a name of C, from the arm's."""
    return re.sub(r"\W|^(?=\d)", "_", model.arm.name, flags=re.ASCII)


def about(model: AnalyticModel) -> str:
    """The text that a reader of the file is told first."""
    units = (f"{c.name} [{'rad' if c.is_angle else 'm'}]" for c in model.layout.coordinates)
    laws = ", ".join(f"{key} {value}" for key, value in model.switches.model_dump().items())
    name = re.sub(r"\*/", "* /", model.arm.name)
    return (
        f"Equations of motion of {name}, {model.name}: M(q) q'' + bias(q, v) = force(t, q, v,"
        f" torque). Coordinates q: {', '.join(units)}; torque [N m] of the drive on the output side"
        f" of each joint; M row by row. Laws: {laws}."
        " Compilers must keep the order of operations: no -ffast-math."
        f" Written by crosscheck export, geararm-crosscheck {__version__}."
    )
