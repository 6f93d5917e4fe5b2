"""`crosscheck simulate`: a run of one model, in a process of its own, into a NetCDF file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from crosscheck.file_types import TRAJECTORY
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import Diverged, InputError, Unfinished
from crosscheck.models.files import is_robot
from crosscheck.models.loading import Case, load_case
from crosscheck.models.robot.case import RobotCase, load_robot_case
from crosscheck.models.robot.robot import Robot
from crosscheck.output import require_file, write_files
from crosscheck.provenance import record_provenance
from crosscheck.registry import (
    MODELS,
    build,
    engine_of,
    find_robot_model,
    get_entry,
    require_usable_numbers,
)
from crosscheck.runner.outcomes import Failure, SelfKeyedTask
from crosscheck.runner.workers import perform_all


@dataclass(frozen=True, eq=False)
class SimulationRequest(SelfKeyedTask):
    """A run that a user asks for by name; see ``api.simulate``."""

    model: str
    case: Case | RobotCase
    force: bool
    rtol: float | None = None
    cost = 3600.0  # rough seconds; a user may well ask for a run of hours

    def perform(self) -> tuple[bytes, str] | InputError | Diverged:
        """The content of the run's file and what is said of it; or what is wrong."""
        from crosscheck.api import simulate
        from crosscheck.models.trajectory import encode_netcdf

        mechanism, *experiment = self.case
        try:
            with require_usable_numbers(self.model, mechanism):
                model = build(self.model, mechanism, *experiment)
                run = simulate(model, force=self.force, rtol=self.rtol)
        except (InputError, Diverged) as error:
            return error
        entry = MODELS[self.model if isinstance(mechanism, Arm) else engine_of(self.model)]
        record = record_provenance(mechanism, 0, False, packages=entry.versioned_packages)
        run.attrs |= {"provenance": record.model_dump_json(), "command": record.command}
        final = describe_joints(mechanism, run["theta"].values[-1])
        return encode_netcdf(run), f"{run.sizes['time']} times{final}"


def describe_joints(mechanism: Arm | Robot, positions: Sequence[float]) -> str:
    """Positions of the joints at a run's end, as the summary of the file has them."""
    if isinstance(mechanism, Arm):
        return f", theta at the end {', '.join(f'{angle:.9g}' for angle in positions)} rad"
    units = ["m" if joint.kind == "prismatic" else "rad" for joint in mechanism.joints]
    joints = zip(mechanism.joints, positions, units, strict=True)
    return f"; at the end {', '.join(f'{j.name} {value:.9g} {unit}' for j, value, unit in joints)}"


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
    case: Case | RobotCase
    if is_robot(arm):
        for switch, value in switches.items():
            allowed = "is for planar arms: the teeth of robots follow their joints' angles"
            raise InputError(f"--{switch.replace('_', '-')}", "", value, allowed)
        case = load_robot_case(arm, scenario, settings)
        find_robot_model(model, case.robot)
    else:
        case = load_case(arm, scenario, switches, settings)
        get_entry(model)
    request = SimulationRequest(model, case, force, rtol)
    require_file(out, TRAJECTORY, "--out")
    experiment = case.scenario
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
