"""`crosscheck simulate`: one run of one model, in a process of its own, into a NetCDF file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from crosscheck.file_types import TRAJECTORY
from crosscheck.models.errors import Diverged, InputError, Unfinished
from crosscheck.models.loading import Case, load_case
from crosscheck.output import require_file, write_files
from crosscheck.provenance import record_provenance
from crosscheck.registry import build, get_entry, require_usable_numbers
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
    """Simulate one model into a NetCDF file."""
    case = load_case(arm, scenario, switches, settings)
    get_entry(model)
    require_file(out, TRAJECTORY, "--out")
    request = SimulationRequest(model, case, force, rtol)
    about = escape(f"{model}, {case.scenario.name}, {case.scenario.duration_s:g} s")
    with Console(stderr=True).status(about):
        written = perform_all([request], 1, lambda key: None)[request]
    if isinstance(written, Failure):
        raise Unfinished(f"{model}: {written}")
    if isinstance(written, Exception):
        raise written
    content, summary = written
    write_files({out: content})
    print(f"wrote {out}: {summary}")
