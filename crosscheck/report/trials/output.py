"""The views of a trial: JSON, JUnit, a page, a notebook's summary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from crosscheck.models.errors import make_printable
from crosscheck.report.finding_groups import list_findings
from crosscheck.report.heat_map import HeatMap, make_heat_map
from crosscheck.report.junit import format_junit
from crosscheck.report.records import format_json, to_json_value
from crosscheck.report.rendering import render_page
from crosscheck.trial.changes.arms.term_words import describe_term_error
from crosscheck.trial.judge.entries import EntryMismatch, select_counted
from crosscheck.trial.result import PartDeviation, Trial

SCHEMA_VERSION = 4
NUMBER_FIELDS = ("name", "value", "parts", "goes_with")
SEARCH_FIELDS = ("place", "has_pairs", "is_late")
ENTRY_FIELDS = ("name", "share", "cause", "difference", "explanation", "shown_on")


def format_trial_json(trial: Trial) -> str:
    """Readable JSON as in crosscheck/schema/trial.schema.json, ending in a newline."""
    problem, diagnosis = trial.problem, trial.diagnosis
    numbers = diagnosis.ignored_numbers
    return format_json(
        {
            "schema_version": SCHEMA_VERSION,
            "equations": problem.name,
            "mechanism": problem.mechanism.name,
            "level": trial.level,
            "coordinates": problem.names,
            "headline": trial.headline,
            "change": to_json_value(trial.change),
            "search": _select_fields(trial.search, SEARCH_FIELDS),
            "causes": trial.causes,
            "wrong": [_wrong_record(each, trial) for each in trial.wrong],
            "hidden": [_wrong_record(each, trial) for each in diagnosis.hidden],
            "scope": trial.scope,
            "notes": trial.notes,
            "levels": to_json_value(trial.distances),
            "unfollowed": [_select_fields(each, NUMBER_FIELDS) for each in numbers],
            "tracebacks": trial.traces,
            "agreement": trial.agreement.to_dict(),
        }
    )


def _wrong_record(wrong: EntryMismatch, trial: Trial) -> dict[str, Any]:
    source, place = trial.sources.get(wrong.part), to_json_value(wrong.place)
    where = None if source is None else {"file": source.file, "line": source.first}
    return {**_select_fields(wrong, ENTRY_FIELDS), **place, "source": where}


def _select_fields(record: Any, names: Sequence[str]) -> dict[str, Any]:
    return {name: to_json_value(getattr(record, name)) for name in names}


def format_trial_junit(trial: Trial) -> str:
    """JUnit XML with a test case for each check."""
    problem = trial.problem
    return format_junit(trial.agreement, f"trial {problem.name} {problem.mechanism.name}")


def render_summary(trial: Trial) -> str:
    """HTML for notebooks: the lines of the terminal, and a heat map of each part."""
    lines = [make_printable(line) for line in trial.lines]
    changes = [make_printable(line) for line in trial.change.sentences] if trial.change else []
    maps = list(make_trial_maps(trial))
    return render_page("summary", lines=lines, changes=changes, maps=maps)


def render_trial_page(trial: Trial) -> str:
    """The page on a trial: HTML text."""
    sources = filter(None, trial.sources.values())
    return render_page(
        "trial",
        trial=trial,
        wrong=select_counted(trial.wrong),
        agreement=trial.agreement,
        maps=list(make_trial_maps(trial)),
        words=lambda errors: " and ".join(map(describe_term_error, errors)),
        sources=() if trial.change else tuple(sources),
        listed=list_findings(trial.agreement.findings),
        provenance=trial.agreement.to_dict()["provenance"],
    )


def make_trial_maps(trial: Trial) -> Iterator[HeatMap]:
    """A heat map of each part; of a bias by rates one for each row that deviates, if any does."""
    names = trial.problem.names
    for part in trial.parts:
        by_rates = part.relative.ndim == 3
        if by_rates and not (part.relative <= part.allowed).all():
            yield from _make_rate_maps(part, names)
        else:
            relative = part.relative.max(axis=(1, 2)) if by_rates else part.relative
            yield make_heat_map(part.title, names, relative, part.allowed)


def _make_rate_maps(part: PartDeviation, names: Sequence[str]) -> Iterator[HeatMap]:
    for name, relative in zip(names, part.relative, strict=True):
        if not (relative <= part.allowed).all():
            title = f"{part.title} of {name}, by rates"
            both = np.maximum(relative, relative.T)  # v1 v2 and v2 v1 are one product
            yield make_heat_map(title, names, both, part.allowed)
