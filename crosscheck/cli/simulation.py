"""`crosscheck simulate`: a run of one model, in a process of its own, into a NetCDF file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.markup import escape

from crosscheck.file_types import TRAJECTORY
from crosscheck.mechanisms import supply
from crosscheck.models.errors import Diverged, InputError, Unfinished
from crosscheck.models.loading import Selection
from crosscheck.models.mechanism import Mechanism, select_mechanism
from crosscheck.models.robot.robot import Robot
from crosscheck.output import require_file, require_netcdf_name, write_files
from crosscheck.provenance import record_provenance
from crosscheck.registry import build, require_usable_numbers
from crosscheck.runner.outcomes import Failure, SelfKeyedTask
from crosscheck.runner.workers import perform_all


@dataclass(frozen=True, eq=False)
class SimulationRequest(SelfKeyedTask):
    """A run that a user asks for by name; see ``api.simulate``."""

    model: str
    chosen: Selection
    force: bool
    rtol: float | None = None
    cost = 3600.0  # rough cost [s]: a run may take hours

    def perform(self) -> tuple[bytes, str] | InputError | Diverged:
        """The content and the summary of the run's file, or the error."""
        from crosscheck.api import simulate
        from crosscheck.models.trajectory import encode_netcdf

        mechanism, (scenario,), switches, _ = self.chosen
        try:
            with require_usable_numbers(self.model, mechanism):
                model = build(self.model, mechanism, scenario, switches)
                run = simulate(model, force=self.force, rtol=self.rtol)
        except (InputError, Diverged) as error:
            return error
        entry = supply("find_entry", mechanism.section)(self.model, mechanism)
        record = record_provenance(mechanism, 0, False, packages=entry.versioned_packages)
        run.attrs |= {"provenance": record.model_dump_json(), "command": record.command}
        positions = run["theta"].values
        summary = describe_joints(mechanism, positions[-1])
        summary += list_beyond_ranges(mechanism, positions)
        return encode_netcdf(run), f"{run.sizes['time']} times{summary}"


def describe_joints(mechanism: Mechanism, positions: Sequence[float]) -> str:
    """Positions of the joints at a run's end, as the summary of the file has them."""
    joints = zip(mechanism.joint_units.items(), positions, strict=True)
    return "; at the end " + ", ".join(f"{name} {q:.6g} {unit}" for (name, unit), q in joints)


def list_beyond_ranges(mechanism: Mechanism, positions: np.ndarray) -> str:
    """Joints that leave their ranges in a run (times, joints), which no model stops them from."""
    if not isinstance(mechanism, Robot):
        return ""
    extremes = zip(mechanism.joints, positions.min(axis=0), positions.max(axis=0), strict=True)
    beyond = [j.name for j, low, high in extremes if low < j.limits.lower or high > j.limits.upper]
    return f"; beyond the ranges, which no model enforces: {', '.join(beyond)}" if beyond else ""


def simulate_command(
    arm: str,
    model: str,
    scenario: str,
    settings: list[str],
    out: Path,
    force: bool,
    rtol: float | None = None,
) -> None:
    """Simulate one model of an arm or a robot into a NetCDF file."""
    chosen = select_mechanism(arm, [scenario], settings)
    mechanism, (experiment,), *_ = chosen
    supply("find_entry", mechanism.section)(model, mechanism)  # raises before anything is run
    request = SimulationRequest(model, chosen, force, rtol)
    require_file(require_netcdf_name(out), TRAJECTORY, "--out")
    about = escape(f"{model}, {experiment.name}, {experiment.duration_s:g} s")
    with Console(stderr=True).status(about):
        written = perform_all([request], 1)[request.key]
    if isinstance(written, Failure):
        raise Unfinished(f"{model}: {written}")
    if isinstance(written, Exception):
        raise written
    content, summary = written
    write_files({out: content})
    print(f"wrote {out}: {summary}")
