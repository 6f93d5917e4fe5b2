"""`crosscheck export`: the equations of a model as a file that other programs can use."""

from __future__ import annotations

import re
from pathlib import Path

from analytic.kernel.export import c_text
from analytic.model import AnalyticModel
from crosscheck import __version__
from crosscheck.kinds import C_FILE
from crosscheck.output import require_file, write_text
from crosscheck.planning.sizing import unequal_gains
from crosscheck.registry import BUILT_IN, build, model_class
from crosscheck.report.words import printable
from models.arm.planets import usual_switches
from models.errors import InputError
from models.loading import load_chosen


def export_command(arm: str, model: str, settings: list[str], out: Path) -> None:
    """Write a model of an arm as a file of C. Raises InputError."""
    chosen = model_of(arm, model, settings)
    require_file(out, C_FILE, "--out")
    write_text(out, c_text(chosen.term_equations, prefix_of(chosen), about(chosen)))
    names = ", ".join(chosen.layout.names)
    print(f"wrote {printable(str(out))}: M, bias, force and acceleration in {names}")


def model_of(arm: str, model: str, settings: list[str]) -> AnalyticModel:
    """A model whose equations are text. Raises InputError for any other."""
    own = [name for name in BUILT_IN if issubclass(model_class(name), AnalyticModel)]
    if model not in own:
        raise InputError("--model", "", model, f"must be one of {', '.join(own)}")
    loaded = load_chosen(arm, [], settings)
    switches = loaded.switches or usual_switches(loaded.arm)
    found = build(model, loaded.arm, unequal_gains(loaded.arm), switches)
    assert isinstance(found, AnalyticModel)
    return found


def prefix_of(model: AnalyticModel) -> str:
    """What the functions' names begin with: a name of C, from the arm's."""
    return re.sub(r"\W|^(?=\d)", "_", model.arm.name, flags=re.ASCII)


def about(model: AnalyticModel) -> str:
    """What a reader of the file is told first."""
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
