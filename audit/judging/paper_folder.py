"""A paper as a folder of data: what it says, how that is measured, its equations in code.

paper.toml has the sentences and claims, study.toml the conditions and measures, as a study of its
own, and equations.py the transcript that paper.toml names. The conditions of the claims are the
study's axes; its experiments are the study with other settings.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple, Self

import numpy as np
import xarray as xr
from pydantic import Field, JsonValue, model_validator

from crosscheck import testing
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.quantities import (
    ConditionResults,
    MeasuredExperiment,
    Measures,
    Number,
    Quantity,
    Sample,
    combine_quantities,
)
from crosscheck.audit.judging.rule import Claim, Limits, evaluate_claim
from crosscheck.audit.judging.sentences import Sentence
from crosscheck.file_types import VERDICTS
from crosscheck.models.arm.quantities import Data, Name, Title
from crosscheck.models.errors import InputError
from crosscheck.models.files import read_toml
from crosscheck.models.loading import validate_record
from crosscheck.output import require_files, write_text
from crosscheck.report.records import format_json
from crosscheck.studies.api import measure_study
from crosscheck.studies.batches.run import ExecutionSettings
from crosscheck.studies.definition.files import read_study
from crosscheck.studies.members.members import PreparedStudy
from crosscheck.trial.input.calls import TAKES
from crosscheck.trial.result import Trial

PAPER, STUDY = "paper.toml", "study.toml"
START, DIVERGED = "start", "diverged_s"
PLAIN = "plain"  # the study as it is


class ClaimText(Data):
    """A statement of the paper, and the number that decides it."""

    id: Name
    """Of its section and a number that no other claim has."""
    statement: Title
    """What the paper says, paraphrased."""
    measure: Name
    """What the study calls the number."""
    experiment: Name = PLAIN
    """Where it is measured."""
    over: Name | None = None
    """Experiment whose number it is divided by."""
    above: float = -math.inf
    """The statement is true of larger numbers,"""
    below: float = math.inf
    """and of smaller ones."""
    because: Title
    """Why these limits."""
    reading: Title = ""
    """How the statement is understood, where it could be otherwise."""

    @model_validator(mode="after")
    def _can_be_false(self) -> Self:
        if math.isinf(self.above) and math.isinf(self.below):
            raise ValueError("above|give this or below; without a limit nothing is judged")
        return self


class PaperFile(Data):
    """What paper.toml says."""

    title: Title
    """Of the paper."""
    experiments: Annotated[dict[str, dict[str, JsonValue]], Field(default_factory=dict)]
    """Settings by the names of experiments beside the plain study."""
    equations: Name | None = None
    """The paper's equations of motion as ``trial`` takes them: ``file.py:name``, beside this file.

    Sentences name its parts, such as mass_matrix, as their errata.
    """
    claims: Annotated[tuple[ClaimText, ...], Field(min_length=1, strict=False)]
    """In the paper's order."""
    sentences: Annotated[tuple[Sentence, ...], Field(min_length=1, strict=False)]
    """All of the paper."""

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        ids = [claim.id for claim in self.claims]
        named = {name for sentence in self.sentences for name in sentence.claims}
        for name in ids:
            if ids.count(name) > 1:
                raise ValueError(f"claims|{name} is the id of two")
        for name in sorted(named ^ set(ids)):
            which = "is not a claim" if name in named else "is named by no sentence"
            raise ValueError(f"sentences|claim {name} {which}")
        parts = {name for sentence in self.sentences for name in sentence.errata}
        for name in sorted(parts - {*TAKES}):
            raise ValueError(f"sentences|{name} is not a part; allowed: {', '.join(TAKES)}")
        if parts and self.equations is None:
            raise ValueError("equations|is missing; sentences name parts of it")
        experiment_names = {PLAIN, *self.experiments}
        for claim in self.claims:
            for name in filter(None, (claim.experiment, claim.over)):
                if name not in experiment_names:
                    allowed = f"not an experiment; allowed: {', '.join(sorted(experiment_names))}"
                    raise ValueError(f"claims|{claim.id}: {name} {allowed}")
        return self


@dataclass(frozen=True)
class StudySetting:
    """A combination of the values of a study's axes."""

    conditions: Mapping[str, Hashable]

    @property
    def static_conditions(self) -> Mapping[str, Hashable]:
        """None: every claim of a folder is simulated."""
        return {}


@dataclass(frozen=True)
class PaperAudit:
    """A paper's claims with their verdicts, and the trial of its equations, if it has any."""

    paper: PaperFile
    judgements: tuple[ClaimJudgement, ...]
    trial: Trial | None

    @property
    def lines(self) -> list[str]:
        """Verdicts in a line each, and what the trial says."""
        verdicts = []
        for judgement in self.judgements:
            claim, verdict = judgement.claim, judgement.verdict
            on = f" on {', '.join(verdict.depends_on)}" if verdict.depends_on else ""
            counts = ", ".join(f"{n} {state}" for state, n in verdict.counts._asdict().items() if n)
            verdicts.append(f"{claim.id}: {verdict.kind}{on} ({counts}): {claim.statement}")
        return [self.paper.title, *verdicts, *self.equation_lines]

    def format_json(self) -> str:
        """The claims with their answers in every setting, and the trial's lines, as JSON."""
        claims = []
        for judgement in self.judgements:
            claim, verdict = judgement.claim, judgement.verdict
            settings = [
                dict(answer.place.conditions)
                | {"state": answer.state, "starts": answer.starts, "quantiles": answer.quantiles}
                for answer in judgement.answers
            ]
            yes_if = f"{claim.limits}: {claim.limits.because}"
            record = {"id": claim.id, "statement": claim.statement, "yes_if": yes_if}
            claims.append(record | verdict.to_dict() | {"settings": settings})
        document = {"schema_version": 1, "title": self.paper.title, "claims": claims}
        return format_json(document | {"equations": self.equation_lines})

    @property
    def equation_lines(self) -> list[str]:
        """What the trial says of the equations, if there are any."""
        return list(self.trial.lines) if self.trial else []


class PaperFolder(NamedTuple):
    """What a paper's folder says."""

    path: Path
    paper: PaperFile
    study: PreparedStudy


def read_folder(folder: Path, run_code: bool = False) -> PaperFolder:
    """Read a paper's folder.

    run_code: whether the equations and functions that its files name may run. Raises InputError.
    """
    paper = validate_record(PaperFile, read_toml(folder / PAPER), str(folder / PAPER))
    if paper.equations and not run_code:
        allowed = "its code would be run; allow that with --run-code"
        raise InputError(str(folder), "function", paper.equations, allowed)
    return PaperFolder(folder, paper, read_study(folder / STUDY, run_code))


def run_folder_command(
    folder: Path, figures: list[int], out: Path, jobs: int, run_code: bool
) -> None:
    """Judge the claims of a paper's folder, and try its equations. Raises InputError."""
    if figures:
        raise InputError("--figure", "", figures[0], "is of the case study; a folder has none")
    given = read_folder(folder, run_code)
    file = out / "verdicts.json"
    require_files((file, VERDICTS))
    audit = audit_paper(given, jobs)
    write_text(file, audit.format_json())
    print("\n".join([*audit.lines, f"wrote {file}"]))


def audit_paper(given: PaperFolder, jobs: int = 1) -> PaperAudit:
    """Simulate a paper's study, judge its claims, and try its equations. Raises InputError."""
    paper = given.paper
    results = {
        name: run_experiment(given, settings, jobs)
        for name, settings in {PLAIN: {}, **paper.experiments}.items()
    }
    settings = collect_results(results)
    measures = list_measures(results[PLAIN])
    judgements = []
    for text in paper.claims:
        claim = Claim(
            text.id,
            None,
            text.statement,
            build_quantity(text, measures, given.path / PAPER),
            Limits(text.above, text.below, text.because),
            reading=text.reading,
        )
        judgements.append(ClaimJudgement(claim, tuple(evaluate_claim(claim, settings))))
    return PaperAudit(paper, tuple(judgements), try_transcript(given, jobs))


def run_experiment(given: PaperFolder, settings: Mapping[str, JsonValue], jobs: int) -> xr.Dataset:
    """The study's result with other settings. Raises InputError."""
    study = read_study(given.path / STUDY, run_code=True, settings=settings)
    return measure_study(study, ExecutionSettings(jobs))


def collect_results(
    results: Mapping[str, xr.Dataset],
) -> list[tuple[StudySetting, ConditionResults]]:
    """For every combination of the axes' values, what the starts of each experiment measured."""
    first = next(iter(results.values()))
    axes = _list_axes(first)
    collected = []
    for place in np.ndindex(*(first.sizes[axis] for axis in axes)):
        chosen = dict(zip(axes, place, strict=True))
        by_experiment = ConditionResults()
        for name, result in results.items():
            members = result.isel(chosen)
            numbers = {
                name: np.atleast_1d(members[name].values) for name in list_measures(result).numbers
            }
            diverged = np.isfinite(np.atleast_1d(members[DIVERGED].values))
            by_experiment[MeasuredExperiment(name)] = Sample(numbers, diverged)
        conditions = {axis: first[axis].values[at].item() for axis, at in chosen.items()}
        collected.append((StudySetting(conditions), by_experiment))
    return collected


def list_measures(result: xr.Dataset) -> Measures:
    """What a study measures of every run, by its names for it; numbers of several joints are not.

    A quantity of the study that has no ``joint`` is such.
    """
    return Measures(
        {
            str(name): Number(str(column.attrs.get("long_name", name)), column.attrs["units"])
            for name, column in result.data_vars.items()
            if name != DIVERGED and {*column.dims} <= {*_list_axes(result), START}
        }
    )


def _list_axes(result: xr.Dataset) -> list[str]:
    """The names of the study's axes; every member has a time at which it diverged, or none."""
    return [str(name) for name in result[DIVERGED].dims if name != START]


def build_quantity(text: ClaimText, measures: Measures, file: Path) -> Quantity:
    """The quantity that decides a claim. Raises InputError for a number that is not measured."""
    if text.measure not in measures.numbers:
        allowed = f"the study measures of one joint: {', '.join(measures.numbers)}"
        raise InputError(str(file), f"claim {text.id}: measure", text.measure, allowed)
    quantity = measures.quantity_of(MeasuredExperiment(text.experiment), text.measure)
    if text.over is None:
        return quantity
    divisor = measures.quantity_of(MeasuredExperiment(text.over), text.measure)
    return combine_quantities("over", quantity, divisor)


def try_transcript(given: PaperFolder, jobs: int) -> Trial | None:
    """The trial of the paper's equations on the study's arm or robot. Raises InputError."""
    if given.paper.equations is None:
        return None
    return testing.try_equations(
        str(given.path / given.paper.equations),
        given.study.base.mechanism,
        jobs=jobs,
        name="the paper's equations",
    )
