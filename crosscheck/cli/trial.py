"""`crosscheck trial`: a user's equations of motion, judged: functions, or a table of answers."""

from __future__ import annotations

import os
import shlex
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from crosscheck.cli.answer import answer, write_asked
from crosscheck.kinds import AGREEMENT, EXPLAINED, JUNIT, ROBOT_JUNIT, TRIAL, TRIAL_PAGE
from crosscheck.models.errors import InputError
from crosscheck.models.files import is_robot
from crosscheck.models.inputs import remember
from crosscheck.models.loading import Chosen, load_chosen
from crosscheck.models.robot.file import load_robot
from crosscheck.output import require_files, require_writable, write_files
from crosscheck.planning.plan import Wanted
from crosscheck.report.answers import agreement_json
from crosscheck.report.junit import junit_xml
from crosscheck.report.terminal import print_agreement
from crosscheck.report.words import counted, printable
from crosscheck.run import CrossCheck
from crosscheck.runner.progress import shown_progress
from crosscheck.trial.fmu.archive import MappedUnit, described, drafted, mapped_unit, unpacked
from crosscheck.trial.fmu.unit import beside, fmu_equations, require_comparable, require_running
from crosscheck.trial.input.equations import Coordinates, Equations, coordinates_of
from crosscheck.trial.input.loading import handed_over, robot_equations
from crosscheck.trial.model import switches_of
from crosscheck.trial.robots.output import (
    lines,
    robot_trial_json,
    robot_trial_junit,
    robot_trial_page,
)
from crosscheck.trial.robots.trial import try_equations
from crosscheck.trial.tables.answers import answered, equations_of, following
from crosscheck.trial.tables.asked import TableTrial, asked_apart, asked_on_probes, asked_states
from crosscheck.trial.tables.folder import ask_files, probe_files
from crosscheck.trial.trial import Asked, Trial, tried


def asked_of(
    model: str, arm: str, scenarios: list[str], settings: list[str], *, quick: bool, seed: int
) -> Asked:
    """What a command line asks to be tried; this runs the model's code. Raises InputError."""
    chosen = load_chosen(arm, scenarios, settings)
    remember(Path(model.rpartition(":")[0]))
    equations = handed_over(model, chosen.arm, chosen.scenarios[0] if chosen.scenarios else None)
    name = model.replace(os.sep, "/").rpartition("/")[2]
    return Asked(
        name, equations, chosen.arm, chosen.scenarios, chosen.switches, quick=quick, seed=seed
    )


def tried_aloud(asked: Asked, chosen: Wanted, jobs: int) -> CrossCheck:
    """Try equations at the seed of what is wanted, with progress; returns the cross-check."""
    with shown_progress(f"trying {printable(asked.name)}") as told:
        return tried(replace(asked, seed=chosen.seed), jobs=jobs, told=told).cross_check


@dataclass(frozen=True)
class TrialOptions:
    """The options of `crosscheck trial`; names: MODEL and ARM, or ARM where answers are a table.

    jobs: None where the command line says none.
    """

    names: tuple[str, ...]
    scenarios: list[str]
    settings: list[str]
    quick: bool
    seed: int
    jobs: int | None
    json_file: Path | None
    junit: Path | None
    out: Path | None
    ask: bool
    answers: tuple[Path, ...]
    after: tuple[Path, ...]
    coordinates: Path | None
    run_code: bool

    @property
    def processes(self) -> int:
        """Number of processes that work: all cores by default."""
        return self.jobs or os.cpu_count() or 1

    @property
    def page(self) -> Path | None:
        """Path of the page, where one is wanted."""
        return None if self.out is None else self.out / "trial.html"

    @property
    def fmu(self) -> Path | None:
        """Path of the FMU, where MODEL is one."""
        own = bool(self.names) and self.names[0].endswith(".fmu")
        return Path(self.names[0]) if own else None

    @property
    def arm(self) -> str:
        """Name or file of the arm."""
        own = 0 if self.answers or (self.ask and not self.fmu) else 1
        return self.names[own] if len(self.names) > own else "paper-labelled"

    def table(self) -> TableTrial:
        """The trial of a table of answers. Raises InputError."""
        chosen = load_chosen(self.arm, [], self.settings)
        coordinates, level = coordinates_of(self.coordinates)
        return TableTrial(chosen.arm, coordinates, level, chosen.switches, self.quick, self.seed)

    def as_written(self) -> str:
        """The options that --ask and --answers must share."""
        words = [self.arm, *(word for setting in self.settings for word in ("--set", setting))]
        words += ["--coordinates", str(self.coordinates)] if self.coordinates else []
        words += ["--quick"] if self.quick else []
        return shlex.join(words + (["--seed", str(self.seed)] if self.seed else []))


def trial_command(options: TrialOptions) -> int:
    """Put equations on trial, or write what is asked of them; returns the exit code."""
    _require_meant(options)
    if is_robot(options.arm):
        _require_for_robots(options)
        return _try_robot(options)
    if options.ask:
        ask(options)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        chosen = load_chosen(options.arm, options.scenarios, options.settings)
        unit = None
        if options.fmu is not None:
            assert options.coordinates is not None  # as was required
            unit = mapped_unit(options.fmu, options.coordinates, chosen.arm, Path(folder))
            require_running(unit, str(options.fmu))
        if unit is not None and unit.description.kind == "co-simulation":
            return _beside(options, unit, chosen)
        asked = _asked(options, unit, chosen)
        require_files(
            (options.json_file, TRIAL), (options.junit, JUNIT), (options.page, TRIAL_PAGE)
        )
        with shown_progress(f"trying {printable(asked.name)}") as told:
            trial = tried(asked, jobs=options.processes, told=told)
    return _told(trial, options)


def _try_robot(options: TrialOptions) -> int:
    """Judge a user's equations of a robot; returns the exit code. Raises InputError."""
    text, robot = options.names[0], load_robot(options.arm)
    files = options.json_file, options.junit, options.page
    require_files(*zip(files, (EXPLAINED, ROBOT_JUNIT, TRIAL_PAGE), strict=True))
    remember(Path(text.rpartition(":")[0]))
    equations = robot_equations(text, robot)
    with shown_progress(f"trying {printable(text)}") as told:
        trial = try_equations(
            equations, robot, name=text, seed=options.seed, jobs=options.processes, told=told
        )
    texts = robot_trial_json, robot_trial_junit, robot_trial_page
    answer(lines(trial), *zip(files, (partial(text, trial) for text in texts), strict=True))
    return trial.exit_code


def _asked(options: TrialOptions, unit: MappedUnit | None, chosen: Chosen) -> Asked:
    """The equations to be tried: a table's, an FMU's or the model's. Raises InputError."""
    quick, seed = options.quick, options.seed
    if options.answers:
        table = options.table()
        equations = equations_of(answered(table, options.answers))
        return table.asked(options.answers[0].name, equations)
    if unit is None:
        given = options.names[0], options.arm, options.scenarios, options.settings
        return asked_of(*given, quick=quick, seed=seed)
    assert options.fmu is not None  # whose unit it is
    equations, laws = fmu_equations(unit, chosen.arm), (chosen.scenarios, chosen.switches)
    return Asked(options.fmu.name, equations, chosen.arm, *laws, quick=quick, seed=seed)


def _beside(options: TrialOptions, unit: MappedUnit, chosen: Chosen) -> int:
    """Run a unit for Co-Simulation beside the engines; returns the exit code. Raises InputError."""
    assert options.fmu is not None  # whose unit it is
    require_comparable(unit, str(options.coordinates))
    if not chosen.scenarios or options.out is not None:
        reason = "for Co-Simulation is run beside the engines: needs --scenario, and has no page"
        raise InputError(str(options.fmu), "", None, reason)
    require_files((options.json_file, AGREEMENT), (options.junit, JUNIT))
    own = Coordinates(gearing=unit.coordinates.gearing)
    laws = switches_of(Equations(coordinates=own), chosen.arm, chosen.switches)
    experiment = chosen.arm, chosen.scenarios, laws
    name = options.fmu.name
    with shown_progress(f"running {printable(name)}") as told:
        agreement = beside(unit, name, *experiment, options.processes, told)
    named = write_asked(
        (options.json_file, lambda: agreement_json(agreement, chosen.arm)),
        (options.junit, lambda: junit_xml(agreement, f"trial {name} {chosen.arm.name}")),
    )
    print_agreement(agreement)
    for line in named:
        print(line)
    return agreement.exit_code


def _told(trial: Trial, options: TrialOptions) -> int:
    """Write and print what was found; returns the exit code."""
    from crosscheck.report.trial import print_trial, trial_json

    def drawn() -> str:
        from crosscheck.report.trial_page import trial_page  # Matplotlib, for a page alone

        return trial_page(trial)

    title = f"trial {trial.problem.name} {trial.problem.case.arm.name}"
    named = write_asked(
        (options.json_file, lambda: trial_json(trial)),
        (options.junit, lambda: junit_xml(trial.agreement, title)),
        (options.page, drawn),
    )
    print_trial(trial)
    for line in named:
        print(line)
    return trial.exit_code


def ask(options: TrialOptions) -> None:
    """Write the folder of what a trial asks, of other arms after first answers. Raises InputError.

    Where an FMU is to be tried, the folder holds a draft of its mapping. No file is written over
    another one, which may be a template with somebody's equations in it.
    """
    assert options.out is not None  # as was required
    if options.fmu is not None:
        with tempfile.TemporaryDirectory() as folder:  # none of its code is run
            unpacked(options.fmu, Path(folder))
            variables = described(str(options.fmu), Path(folder))
        _write_new(options.out, {"map.toml": drafted(printable(options.fmu.name), variables)})
        print(f"wrote {printable(str(options.out / 'map.toml'))}: check every name in it")
        return
    table = options.table()
    if options.after:
        first = answered(table, options.after)
        states = first.here[0]
        after = following((states, *asked_apart(table, states)))
        asked = asked_on_probes(table, first.parts, after)
        files = probe_files(table, asked, options.as_written())
    else:
        states = asked_states(table)
        asked = [states, *asked_apart(table, states)]
        files = ask_files(table, asked, options.as_written())
    _write_new(options.out, files)
    count = counted(sum(each.count for each in asked), "state")
    readme = printable(str(options.out / "README.md"))
    print(f"wrote {printable(str(options.out))}: {count}; {readme} says how to answer them")


def _write_new(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write files that are not there yet, all or none. Raises InputError."""
    require_writable(folder)
    for name in files:
        if os.path.lexists(folder / name):
            raise InputError(str(folder / name), "", None, "exists already; name another folder")
    write_files({folder / name: content for name, content in files.items()})


def _require_for_robots(options: TrialOptions) -> None:
    """Raise InputError for options that are of arms alone."""
    of_arms = {
        "--ask": options.ask,
        "--answers": options.answers,
        "MODEL": options.fmu,
        "--scenario": options.scenarios,
        "--set": options.settings,
        "--quick": options.quick,
        "--run-code": options.run_code,
    }
    for name in (name for name, given in of_arms.items() if given):
        value = str(options.fmu) if name == "MODEL" else None
        raise InputError(name, "", value, f"is for arms; {options.arm} is a robot")


def _require_meant(options: TrialOptions) -> None:
    """Raise InputError for options that do not go together."""
    table = "--ask" if options.ask else "--answers" if options.answers else ""
    unlike = {
        "--scenario": bool(table and options.scenarios),
        "--json": bool(options.ask and options.json_file),
        "--junit": bool(options.ask and options.junit),
        "--answers": bool(options.ask and options.answers),
    }
    for name in (name for name, there in unlike.items() if there):
        raise InputError(name, "", None, f"cannot be used with {table}")
    if options.fmu is not None and not options.ask:
        if options.coordinates is None:
            reason = "is missing: the file that names an FMU's variables; --ask drafts it"
            raise InputError("--coordinates", "", None, reason)
        if not options.run_code:
            raise InputError("--run-code", "", None, f"is needed: {options.fmu} is code")
    if options.coordinates and not (table or options.fmu):
        raise InputError(
            "--coordinates", "", None, "is for --ask and --answers; a MODEL has its own"
        )
    if options.after and not options.ask:
        raise InputError("--after", "", None, "needs --ask")
    if options.ask and options.out is None:
        raise InputError("--ask", "", None, "needs --out, the folder to write")
    if table and len(options.names) > (2 if options.fmu else 1):
        raise InputError(
            table, "", " ".join(options.names), "takes the place of MODEL; name the ARM alone"
        )
    if not table and not options.names:
        raise InputError("trial", "MODEL", None, "is missing; or use --ask and --answers")
