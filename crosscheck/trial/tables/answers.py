"""Equations out of tables of answers: no code runs, every answer is looked up by its state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.tables.answer_files import AnswerFile, TableColumns, read_answers
from crosscheck.trial.tables.state_requests import (
    ARGUMENTS,
    SHORT,
    AnsweredTrial,
    Call,
    StateRequest,
    TableTrial,
    collect_inverse_requests,
    collect_state_request,
)

# Tolerance between equal states, over a column's largest number (single precision).
SAME_STATE = 1e-4


@dataclass(frozen=True)
class TrialAnswers:
    """Files of answers beside what was asked.

    parts: those that are answered; here: what is asked on the arm, inverse dynamics apart; probes:
    what is asked on other arms, if that was answered.
    """

    trial: AnsweredTrial
    files: tuple[AnswerFile, ...]
    parts: tuple[str, ...]
    here: tuple[StateRequest, ...]
    probes: tuple[StateRequest, ...]


def read_trial_answers(trial: AnsweredTrial, paths: Sequence[Path]) -> TrialAnswers:
    """The answers in files. Raises InputError if anything that they must answer is missing."""
    request = collect_state_request(trial)
    columns = TableColumns(len(request.names), trial.parts, request.columns, trial.least_digits)
    files = tuple(read_answers(path, columns) for path in paths)
    parts = tuple(part for part in trial.parts if any(part in file.answers for file in files))
    here: tuple[StateRequest, ...] = (request,)
    last = max(int(file.rows.max()) for file in files)
    if last >= request.first + request.count:
        here = (request, *collect_inverse_requests(trial, request))
    probes: tuple[StateRequest, ...] = ()
    if last >= next_row(here):
        probes = tuple(trial.collect_probe_requests(parts, next_row(here)))
    for file in files:
        beyond = file.rows[file.rows >= next_row((*here, *probes))]
        if beyond.size:
            reason = (
                f"must be at most {next_row((*here, *probes)) - 1};"
                " arm, coordinates, --seed and --quick must be those of --ask"
            )
            raise InputError(file.where, "row", int(beyond[0]), reason)
        for sheet in (*here, *probes):
            _require_same_states(file, sheet)
    return TrialAnswers(trial, files, parts, here, probes)


def next_row(sheets: Sequence[StateRequest]) -> int:
    """The number of the row after the last one of these sheets."""
    return sheets[-1].first + sheets[-1].count


def build_table_equations(answers: TrialAnswers) -> Equations:
    """The answers as Equations, on the arm and on the probes. Raises InputError."""
    for part in answers.parts:
        if not any(sheet.needed[part].any() for sheet in answers.here):
            reason = "is not asked in these rows; what a row needs stands in the files of states"
            raise InputError(answers.files[0].where, SHORT[part], None, reason)
    here, trial = _arm_equations(answers, answers.here), answers.trial
    if not isinstance(trial, TableTrial):
        return here
    probe_equations = {
        sheet.arm.name: (sheet.arm, _arm_equations(answers, (sheet,))) for sheet in answers.probes
    }

    def select_equations(arm: Arm, scenario: Scenario | None) -> Equations:
        expected_arm, equations = probe_equations.get(arm.name, (trial.mechanism, whole))
        if expected_arm != arm:
            raise InputError(arm.name, "", None, "no answers are there for this arm")
        return equations

    whole = replace(here, rebuild=select_equations, any_arm=bool(probe_equations))
    return whole


def _arm_equations(answers: TrialAnswers, sheets: Sequence[StateRequest]) -> Equations:
    """Equations of an arm: each part answers from the sheet in which it is asked, if it is."""
    home = {part: sheet for part in answers.parts for sheet in sheets if sheet.needed[part].any()}
    values = {part: _values(answers, sheet, part) for part, sheet in home.items()}

    def answer(call: Call) -> np.ndarray:
        sheet = home[call.part]
        return values[call.part][sheet.row_of[call]].reshape(sheet.shape(call.part))

    equations = answers.trial.equations(answers.parts, answer)
    precision = max(file.precision for file in answers.files)
    assert equations.table is not None  # as they are made
    return replace(equations, table=replace(equations.table, precision=precision))


def _values(answers: TrialAnswers, sheet: StateRequest, part: str) -> np.ndarray:
    """Answers (rows, entries) of a part. Raises InputError for one that is missing."""
    values = np.full((sheet.count, int(np.prod(sheet.shape(part)))), np.nan)
    whose, near = np.full(sheet.count, "", dtype=object), ""  # near: a file that has such rows
    for file in answers.files:
        if part not in file.answers:
            continue
        places, here = _match_rows(file, sheet)
        near = near or (file.where if places.size else "")
        given = file.answers[part][here]
        there = ~np.isnan(given).all(axis=1)
        twice = places[there & (whose[places] != "")]
        if twice.size:
            reason = f"is answered in {whose[twice[0]]} already"
            raise InputError(
                file.where, f"{SHORT[part]} of row {sheet.first + twice[0]}", None, reason
            )
        values[places[there]], whose[places[there]] = given[there], file.where
    missing = sheet.needed[part] & ~np.isfinite(values).all(axis=1)
    if missing.any():
        row = int(np.flatnonzero(missing)[0])
        if not near:
            rows = f"{SHORT[part]} of rows {sheet.first} to {sheet.first + sheet.count - 1}"
            reason = f"is missing; no file has answers to the states of {sheet.arm.name}"
            raise InputError("--answers", rows, None, reason)
        where = whose[row] or near
        entry = values[row]
        problem = "is missing" if np.isnan(entry).any() else "is infinite"
        others = f", and {int(missing.sum()) - 1} more" if missing.sum() > 1 else ""
        field = f"row {sheet.first + row}{others}, {SHORT[part]}"
        raise InputError(where, field, None, f"{problem}; must be finite numbers")
    return values


def _match_rows(file: AnswerFile, sheet: StateRequest) -> tuple[np.ndarray, np.ndarray]:
    """Places in the sheet of the file's rows, and which of the file's rows these are."""
    places = file.rows - sheet.first
    here = (places >= 0) & (places < sheet.count)
    return places[here], here


def _require_same_states(file: AnswerFile, sheet: StateRequest) -> None:
    """Raise InputError for answers to other states, where these stand beside them."""
    places, here = _match_rows(file, sheet)
    for argument in ARGUMENTS:
        for column, name in enumerate(sheet.columns[argument]):
            if name not in file.state_columns:
                continue
            right, given = sheet.arguments[argument][places, column], file.state_columns[name][here]
            size = float(np.abs(sheet.arguments[argument][:, column]).max())
            # A column that was left empty, or belongs to the other file of states, says nothing.
            wrong = np.flatnonzero(np.abs(given - right) > SAME_STATE * size)
            if wrong.size:
                row = int(file.rows[here][wrong[0]])
                reason = (
                    f"answers to other states: must be {right[wrong[0]]:.6g};"
                    " arm, coordinates, --seed and --quick must be those of --ask"
                )
                raise InputError(file.where, f"row {row}, {name}", float(given[wrong[0]]), reason)
