"""What an FMU says of itself, read without running it; the draft of a mapping."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from crosscheck.models.errors import InputError
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.workers import perform_all
from crosscheck.trial.fmu.archive import DESCRIPTION

EXTRA = "needs FMPy: pip install 'geararm-crosscheck[fmu]'"
LONGEST = 200  # characters of a name that is looked at


@dataclass(frozen=True)
class FmuVariable:
    """A real number of the unit; derivative: of which state it is the derivative, if of one."""

    name: str
    reference: int
    is_input: bool
    derivative_of: str = ""


@dataclass(frozen=True)
class FmuDescription:
    """version: 2 or 3; kind: Model Exchange, where it has that, or Co-Simulation; states: the
    continuous ones, in the order of their derivatives."""

    version: int
    kind: Literal["exchange", "co-simulation"]
    identifier: str
    token: str
    variables: tuple[FmuVariable, ...]
    states: tuple[str, ...]


@dataclass(frozen=True)
class DescriptionReading:
    """The task of a worker, for a foreign file is parsed."""

    where: str
    folder: Path
    key: str = "description"

    @property
    def cost(self) -> float:
        """Rough seconds."""
        return 1.0

    def perform(self) -> FmuDescription | InputError:
        """What stands in the file, or what is wrong with it."""
        try:
            from fmpy import read_model_description
        except ImportError:
            return InputError(self.where, "", None, EXTRA)
        text = (self.folder / DESCRIPTION).read_bytes()
        version = re.search(rb"fmiVersion\s*=\s*[\"']([^\"']*)", text)
        said = "" if version is None else version[1].decode("utf-8", "backslashreplace")
        if said[:2] not in ("2.", "3."):
            return InputError(self.where, "fmiVersion", said, "must be 2.0 or 3.0")
        try:
            found = read_model_description(str(self.folder))
        except Exception as error:
            reason = f"is no model description: {type(error).__name__}: {error}"
            return InputError(self.where, "", None, reason)
        kind: Literal["exchange", "co-simulation"] = "exchange"
        interface = found.modelExchange
        if interface is None:
            kind, interface = "co-simulation", found.coSimulation
        if interface is None:
            reason = "is neither for Model Exchange nor for Co-Simulation"
            return InputError(self.where, "", None, reason)
        real = [v for v in found.modelVariables if v.type in ("Real", "Float64")]
        variables = tuple(
            FmuVariable(
                v.name,
                int(v.valueReference),
                v.causality == "input",
                "" if v.derivative is None else v.derivative.name,
            )
            for v in real
            if not v.dimensions and len(v.name) <= LONGEST and v.name.isprintable()
        )
        states = tuple(
            unknown.variable.derivative.name
            for unknown in found.derivatives
            if unknown.variable.derivative is not None
        )
        identifier = interface.modelIdentifier
        return FmuDescription(int(said[0]), kind, identifier, found.guid, variables, states)


def described(where: str, folder: Path) -> FmuDescription:
    """What an unpacked FMU says of itself. Raises InputError."""
    (found,) = perform_all([DescriptionReading(where, folder)], 1, lambda key: None).values()
    if isinstance(found, Failure):
        raise InputError(where, "", None, f"cannot be read: {found}")
    if isinstance(found, InputError):
        raise found
    assert isinstance(found, FmuDescription)
    if "/" in found.identifier or found.identifier.startswith("."):
        raise InputError(where, "modelIdentifier", found.identifier, "must be a name of a file")
    return found


def drafted(name: str, found: FmuDescription) -> str:
    """A mapping to begin with: states that have others for derivatives by their order, inputs."""
    inputs = [v.name for v in found.variables if v.is_input]
    half = len(found.states) // 2
    runs = '# The rigid level that a unit for Co-Simulation is compared with.\nlevel = "links"\n'
    return (
        f"# Written by crosscheck trial --ask, from what {name} says of itself: check every name.\n"
        "# Coordinates in their order, their rates, and the drive's torques on the output side.\n"
        f"q = {_list(found.states[:half])}\n"
        f"v = {_list(found.states[half:])}\n"
        f"torque = {_list(inputs)}\n"
        "\n"
        '# What q are: gearing = "rigid", "lumped" or "free"; links = "relative" or "absolute";\n'
        '# gears = "displacements" or "angles"; or matrix = [[1, 0], [0, 1]].\n'
        'gearing = "rigid"\n'
        'links = "relative"\n' + runs * (found.kind == "co-simulation")
    )


def _list(names: tuple[str, ...] | list[str]) -> str:
    quoted = ('"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"' for name in names)
    return f"[{', '.join(quoted)}]"
