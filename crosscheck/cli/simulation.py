"""`crosscheck simulate`: a run of one model, in a process of its own, into a NetCDF file."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from crosscheck.file_types import TRAJECTORY
from crosscheck.models.errors import Diverged, InputError, Unfinished
from crosscheck.models.files import is_robot
from crosscheck.models.loading import Case, load_case
from crosscheck.models.robot.case import RobotCase, load_robot_case
from crosscheck.models.robot.robot import Level
from crosscheck.output import require_file, write_files
from crosscheck.provenance import describe_surroundings, record_provenance
from crosscheck.registry import (
    build,
    find_level_engines,
    get_entry,
    model_names,
    require_usable_numbers,
)
from crosscheck.runner.outcomes import Failure, SelfKeyedTask
from crosscheck.runner.workers import perform_all


@dataclass(frozen=True)
class SimulationRequest(SelfKeyedTask):
    """A run that a user asks for by name; see ``api.simulate``."""

    model: str
    case: Case
    force: bool
    rtol: float | None = None
    cost = 3600.0  # rough seconds; a user may well ask for a run of hours

    def perform(self) -> tuple[bytes, str] | InputError | Diverged:
        """The content of the run's file and what is said of it; or what is wrong."""
        from crosscheck.api import simulate
        from crosscheck.models.trajectory import encode_netcdf

        try:
            with require_usable_numbers(self.model, self.case.arm):
                model = build(self.model, *self.case)
                run = simulate(model, force=self.force, rtol=self.rtol)
        except (InputError, Diverged) as error:
            return error
        packages = get_entry(self.model).versioned_packages
        record = record_provenance(self.case.arm, 0, False, packages=packages)
        run.attrs |= {"provenance": record.model_dump_json(), "command": record.command}
        final = ", ".join(f"{angle:.9g}" for angle in run["theta"].values[-1])
        return encode_netcdf(run), f"{run.sizes['time']} times, theta at the end {final} rad"


@dataclass(frozen=True, eq=False)
class RobotSimulationRequest(SelfKeyedTask):
    """A run of a robot by an engine at a level; see ``api.simulate_robot``."""

    engine: str
    level: Level
    case: RobotCase
    force: bool
    rtol: float | None = None
    cost = 3600.0

    def perform(self) -> tuple[bytes, str] | InputError | Diverged:
        """The content of the run's file and what is said of it; or what is wrong."""
        from crosscheck.api import simulate_robot
        from crosscheck.models.trajectory import encode_netcdf

        try:
            run = simulate_robot(
                self.engine, self.level, self.case, force=self.force, rtol=self.rtol
            )
        except (InputError, Diverged) as error:
            return error
        surroundings = describe_surroundings()
        run.attrs |= {"provenance": json.dumps(surroundings), "command": surroundings["command"]}
        ends = zip(run["theta"].values[-1], self.case.robot.joints, strict=True)
        final = ", ".join(
            f"{joint.name} {value:.9g} {'m' if joint.kind == 'prismatic' else 'rad'}"
            for value, joint in ends
        )
        return encode_netcdf(run), f"{run.sizes['time']} times; at the end {final}"


def _request_robot(
    name: str,
    model: str,
    scenario: str,
    switches: dict[str, str],
    settings: list[str],
    force: bool,
    rtol: float | None,
) -> RobotSimulationRequest:
    """The run of a robot that a command line asks for. Raises InputError."""
    for switch, value in switches.items():
        allowed = "is for planar arms: the teeth of robots follow their joints' angles"
        raise InputError(f"--{switch.replace('_', '-')}", "", value, allowed)
    engine, _, level = model.partition(":")
    if engine not in model_names("robot"):
        allowed = f"must be ENGINE:LEVEL, ENGINE one of {', '.join(model_names('robot'))}"
        raise InputError("--model", "", model, allowed)
    case = load_robot_case(name, scenario, settings)
    levels = [each for each in case.robot.levels if engine in find_level_engines(each)]
    chosen = [each for each in levels if each == level]
    if not chosen:
        allowed = f"{case.robot.name} has the levels {', '.join(levels)} in {engine}"
        raise InputError("--model", "", model, allowed)
    return RobotSimulationRequest(engine, chosen[0], case, force, rtol)


def simulate_command(
    arm: str,
    model: str,
    scenario: str,
    switches: dict[str, str],
    settings: list[str],
    out: Path,
    force: bool,
    rtol: float | None = None,
) -> None:
    """Simulate one model of an arm or a robot into a NetCDF file."""
    request: SimulationRequest | RobotSimulationRequest
    if is_robot(arm):
        request = _request_robot(arm, model, scenario, switches, settings, force, rtol)
    else:
        case = load_case(arm, scenario, switches, settings)
        get_entry(model)
        request = SimulationRequest(model, case, force, rtol)
    require_file(out, TRAJECTORY, "--out")
    experiment = request.case.scenario
    about = escape(f"{model}, {experiment.name}, {experiment.duration_s:g} s")
    with Console(stderr=True).status(about):
        written = perform_all([request], 1, lambda key: None)[request.key]
    if isinstance(written, Failure):
        raise Unfinished(f"{model}: {written}")
    if isinstance(written, Exception):
        raise written
    content, summary = written
    write_files({out: content})
    print(f"wrote {out}: {summary}")
