"""`crosscheck trial`: a user's equations of motion, judged."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from crosscheck.kinds import JUNIT, TRIAL, TRIAL_PAGE
from crosscheck.output import require_files, write_files
from crosscheck.planning.plan import Wanted
from crosscheck.report.junit import junit_xml
from crosscheck.report.words import printable
from crosscheck.run import CrossCheck
from crosscheck.runner.progress import shown_progress
from crosscheck.trial.input.loading import handed_over
from crosscheck.trial.trial import Asked, tried
from models.inputs import remember
from models.loading import load_chosen


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
    """The trial as a cross-check, at the seed of what is wanted, with its progress."""
    with shown_progress(f"trying {printable(asked.name)}") as told:
        return tried(replace(asked, seed=chosen.seed), jobs=jobs, told=told).cross_check


def trial_command(
    model: str,
    arm: str,
    scenarios: list[str],
    settings: list[str],
    *,
    quick: bool,
    jobs: int,
    seed: int,
    json_file: Path | None,
    junit: Path | None,
    out: Path | None,
) -> int:
    """Put equations on trial, print what is wrong, write what was asked; returns the exit code."""
    from crosscheck.report.trial import print_trial, trial_json

    page = None if out is None else out / "trial.html"
    asked = asked_of(model, arm, scenarios, settings, quick=quick, seed=seed)
    require_files((json_file, TRIAL), (junit, JUNIT), (page, TRIAL_PAGE))
    with shown_progress(f"trying {printable(asked.name)}") as told:
        trial = tried(asked, jobs=jobs, told=told)
    files: dict[Path, str] = {}
    if json_file is not None:
        files[json_file] = trial_json(trial)
    if junit is not None:
        files[junit] = junit_xml(trial.agreement, f"trial {asked.name} {asked.arm.name}")
    if page is not None:
        from crosscheck.report.trial_page import trial_page

        files[page] = trial_page(trial)
    write_files(files)
    print_trial(trial)
    for file in files:
        print(f"wrote {file}")
    return trial.exit_code
