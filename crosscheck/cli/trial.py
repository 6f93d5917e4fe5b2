"""`crosscheck trial`: judges a user's equations of motion, as functions or a table of answers."""

from __future__ import annotations

import os
import shlex
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from crosscheck.cli.output import print_and_write, write_requested
from crosscheck.file_types import AGREEMENT, JUNIT, TRIAL, TRIAL_PAGE, FileType
from crosscheck.mechanisms import supply
from crosscheck.models.errors import InputError, make_printable
from crosscheck.models.inputs import remember
from crosscheck.models.loading import Selection
from crosscheck.models.mechanism import find_section, select_mechanism
from crosscheck.models.refusals import refuse
from crosscheck.output import require_files, require_writable, write_files
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.report.answers import format_agreement_json
from crosscheck.report.formatting import format_count
from crosscheck.report.junit import format_junit
from crosscheck.report.terminal import print_agreement
from crosscheck.run import CrossCheck
from crosscheck.runner.progress import show_progress
from crosscheck.trial.arms.model import select_switches
from crosscheck.trial.fmu.archive import (
    MappedUnit,
    draft_mapping,
    load_unit,
    read_description,
    unpack_fmu,
)
from crosscheck.trial.fmu.unit import (
    build_fmu_equations,
    compare_unit_runs,
    require_comparable,
    require_running,
)
from crosscheck.trial.input.equations import Coordinates, Equations, load_coordinates
from crosscheck.trial.request import TrialRequest, prepare_equations
from crosscheck.trial.result import Trial
from crosscheck.trial.tables.answers import build_table_equations, next_row, read_trial_answers
from crosscheck.trial.tables.state_requests import (
    AnsweredTrial,
    collect_inverse_requests,
    collect_state_request,
)
from crosscheck.trial.trial import run_trial


def make_trial_request(
    model: str, chosen: Selection, *, quick: bool, seed: int, jobs: int = 1
) -> TrialRequest:
    """The request of a command line for a trial; runs the model's code. Raises InputError."""
    remember(Path(model.rpartition(":")[0]))
    what = model.replace(os.sep, "/").rpartition("/")[2], prepare_equations(model, chosen, model)
    return TrialRequest(
        *what, chosen.mechanism, chosen.scenarios, chosen.switches, quick, seed, jobs
    )


def run_trial_with_progress(
    request: TrialRequest, chosen: CrossCheckRequest, jobs: int
) -> CrossCheck:
    """Try equations with the request's seed, showing progress; returns the cross-check."""
    return _try_equations(replace(request, seed=chosen.seed, jobs=jobs)).cross_check


def _try_equations(request: TrialRequest) -> Any:
    with show_progress(f"trying {make_printable(request.name)}") as progress:
        return run_trial(request, progress)


@dataclass(frozen=True)
class TrialOptions:
    """The options of `crosscheck trial`; names: MODEL and ARM, or ARM where answers are a table."""

    names: tuple[str, ...]
    scenarios: list[str]
    settings: list[str]
    quick: bool
    seed: int
    jobs: int
    json_file: Path | None
    junit: Path | None
    out: Path | None
    ask: bool
    answers: tuple[Path, ...]
    after: tuple[Path, ...]
    coordinates: Path | None
    run_code: bool

    @property
    def page(self) -> Path | None:
        """Path of the page, where one is wanted."""
        return None if self.out is None else self.out / "trial.html"

    @property
    def files(self) -> tuple[tuple[Path | None, FileType], ...]:
        """Paths of the files to write, None if not requested, and their types."""
        return (self.json_file, TRIAL), (self.junit, JUNIT), (self.page, TRIAL_PAGE)

    @property
    def fmu(self) -> Path | None:
        """Path of the FMU, where MODEL is one."""
        is_fmu = bool(self.names) and self.names[0].endswith(".fmu")
        return Path(self.names[0]) if is_fmu else None

    @property
    def arm(self) -> str:
        """Name or file of the arm."""
        index = 0 if self.answers or (self.ask and not self.fmu) else 1
        return self.names[index] if len(self.names) > index else "paper-labelled"

    def table(self) -> AnsweredTrial:
        """The trial of a table of answers. Raises InputError."""
        chosen = select_mechanism(self.arm, (), self.settings)
        coordinates, level = load_coordinates(self.coordinates)
        given = chosen.mechanism, coordinates, level, chosen.switches, self.quick, self.seed
        return supply("make_table", chosen.mechanism.section)(*given)

    def format_shared_options(self) -> str:
        """The options that --ask and --answers must share."""
        words = [self.arm, *(word for setting in self.settings for word in ("--set", setting))]
        words += ["--coordinates", str(self.coordinates)] if self.coordinates else []
        words += ["--quick"] if self.quick else []
        return shlex.join(words + (["--seed", str(self.seed)] if self.seed else []))


def trial_command(options: TrialOptions) -> int:
    """Judge supplied equations, or write the states to answer; returns the exit code."""
    _require_compatible(options)
    if not (options.ask and options.fmu):
        given: dict[str, Any] = {"after": options.after, "scenario": options.scenarios}
        given["run_code"] = options.run_code and options.fmu is None
        refuse(find_section(options.arm), "trial", **given)
    if options.ask:
        ask(options)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        chosen = select_mechanism(options.arm, options.scenarios, options.settings)
        unit = None
        if options.fmu is not None:
            assert options.coordinates is not None  # required above
            unit = load_unit(options.fmu, options.coordinates, chosen.mechanism, Path(folder))
            is_run = unit.description.kind == "co-simulation"
            where = str(options.fmu)
            refuse(chosen.mechanism.section, "trial", where, co_simulation=is_run)
            require_running(unit, where)
            if is_run:
                return _run_beside_engines(options, unit, chosen)
        request = _make_request(options, unit, chosen)
        require_files(*options.files)
        trial = _try_equations(request)
    return _report_trial(trial, options)


def _make_request(
    options: TrialOptions, unit: MappedUnit | None, chosen: Selection
) -> TrialRequest:
    """The trial of equations from a table, an FMU or the model. Raises InputError."""
    quick, seed, jobs = options.quick, options.seed, options.jobs
    if options.answers:
        table = options.table()
        equations = build_table_equations(read_trial_answers(table, options.answers))
        return replace(table.make_request(options.answers[0].name, equations), jobs=jobs)
    if unit is None:
        return make_trial_request(options.names[0], chosen, quick=quick, seed=seed, jobs=jobs)
    assert options.fmu is not None  # whose unit it is
    equations, laws = build_fmu_equations(unit, chosen.mechanism), chosen[1:3]
    return TrialRequest(
        options.fmu.name, equations, chosen.mechanism, *laws, quick=quick, seed=seed, jobs=jobs
    )


def _run_beside_engines(options: TrialOptions, unit: MappedUnit, chosen: Selection) -> int:
    """Run a unit for Co-Simulation beside the engines; returns the exit code. Raises InputError."""
    assert options.fmu is not None  # whose unit it is
    require_comparable(unit, str(options.coordinates))
    if not chosen.scenarios or options.out is not None:
        reason = "for Co-Simulation is run beside the engines: needs --scenario, and has no page"
        raise InputError(str(options.fmu), "", None, reason)
    require_files((options.json_file, AGREEMENT), (options.junit, JUNIT))
    coordinates = Coordinates(gearing=unit.coordinates.gearing)
    laws = select_switches(Equations(coordinates=coordinates), chosen.arm, chosen.switches)
    experiment = chosen.arm, chosen.scenarios, laws
    name = options.fmu.name
    with show_progress(f"running {make_printable(name)}") as progress:
        agreement = compare_unit_runs(unit, name, *experiment, options.jobs, progress)
    named = write_requested(
        (options.json_file, lambda: format_agreement_json(agreement, chosen.arm)),
        (options.junit, lambda: format_junit(agreement, f"trial {name} {chosen.arm.name}")),
    )
    print_agreement(agreement)
    for line in named:
        print(line)
    return agreement.exit_code


def _report_trial(trial: Trial, options: TrialOptions) -> int:
    """Write and print the answer of a trial; returns the exit code. Raises InputError."""
    from crosscheck.report.trials.output import (
        format_trial_json,
        format_trial_junit,
        render_trial_page,
    )

    texts = format_trial_json, format_trial_junit, render_trial_page
    paths = (path for path, _ in options.files)
    requests = ((path, partial(text, trial)) for path, text in zip(paths, texts, strict=True))
    print_and_write(trial.lines, *requests)
    return trial.exit_code


def ask(options: TrialOptions) -> None:
    """Write the folder of states to answer, after first answers those of other arms.

    For an FMU the folder holds a draft of its mapping. No file is overwritten, since somebody may
    have filled in a template. Raises InputError.
    """
    from crosscheck.trial.tables.folder import render_probe_files, render_request_files

    assert options.out is not None  # required above
    if options.fmu is not None:
        with tempfile.TemporaryDirectory() as folder:  # none of its code is run
            unpack_fmu(options.fmu, Path(folder))
            variables = read_description(str(options.fmu), Path(folder))
        draft = draft_mapping(make_printable(options.fmu.name), variables)
        _write_new(options.out, {"map.toml": draft})
        print(f"wrote {make_printable(str(options.out / 'map.toml'))}: check every name in it")
        return
    table = options.table()
    if options.after:
        first = read_trial_answers(table, options.after)
        states = first.here[0]
        after = next_row((states, *collect_inverse_requests(table, states)))
        state_sets = table.collect_probe_requests(first.parts, after)
        where = options.after, options.out
        files = render_probe_files(table, state_sets, options.format_shared_options(), *where)
    else:
        states = collect_state_request(table)
        state_sets = [states, *collect_inverse_requests(table, states)]
        shared = options.format_shared_options()
        files = render_request_files(table, state_sets, shared, options.out)
    _write_new(options.out, files)
    count = format_count(sum(each.count for each in state_sets), "state")
    readme = make_printable(str(options.out / "README.md"))
    print(f"wrote {make_printable(str(options.out))}: {count}; {readme} says how to answer them")


def _write_new(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write files that are not there yet, all or none. Raises InputError."""
    require_writable(folder)
    for name in files:
        if os.path.lexists(folder / name):
            raise InputError(str(folder / name), "", None, "exists already; name another folder")
    write_files({folder / name: content for name, content in files.items()})


def _require_compatible(options: TrialOptions) -> None:
    """Raise InputError for options that do not go together."""
    asks, fmu, coordinates = options.ask, options.fmu, options.coordinates
    table = "--ask" if asks else "--answers" if options.answers else ""
    draft = shlex.join(("crosscheck", "trial", "--ask", str(fmu), "--out", "map"))
    runs_fmu, conflicts = fmu is not None and not asks, f"cannot be used with {table}"
    needless = "is for --ask and --answers; a MODEL has its own"
    unnamed = f"is missing: the file that names an FMU's variables; {draft} drafts it"
    for option, is_wrong, reason in (
        ("--scenario", table and options.scenarios, conflicts),
        ("--json", asks and options.json_file, conflicts),
        ("--junit", asks and options.junit, conflicts),
        ("--answers", asks and options.answers, conflicts),
        ("--coordinates", runs_fmu and coordinates is None, unnamed),
        ("--run-code", runs_fmu and not options.run_code, f"is needed: {fmu} is code"),
        ("--coordinates", coordinates and not (table or fmu), needless),
        ("--after", options.after and not asks, "needs --ask"),
        ("--ask", asks and options.out is None, "needs --out, the folder to write"),
    ):
        if is_wrong:
            raise InputError(option, "", None, reason)
    if table and len(options.names) > (2 if fmu else 1):
        names = " ".join(options.names)
        raise InputError(table, "", names, "takes the place of MODEL; name the ARM alone")
    if options.arm.partition(":")[0].endswith(".py"):
        raise InputError(
            options.arm, "", None, "is Python, no arm or robot; write MODEL before ARM"
        )
    if not table and not options.names:
        raise InputError(
            "trial", "MODEL", None, "missing: name your equations, or use --ask and --answers"
        )
