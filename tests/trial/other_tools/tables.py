"""Tables answered by Python models, as any other tool would answer them."""

import csv
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.calls import TAKES
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.supplied import SuppliedEquations, bind_equations
from crosscheck.trial.result import Trial
from crosscheck.trial.tables import state_requests
from crosscheck.trial.tables.answers import build_table_equations, next_row, read_trial_answers
from crosscheck.trial.trial import run_trial

STANDS_FOR = {"coriolis": "bias"}  # what is answered where C was supplied


def bound(equations: Equations, arm: Arm) -> SuppliedEquations:
    """Equations with an arm's numbers."""
    own = equations.adapt_to_arm(arm)
    return bind_equations(own, arm, build_frame(own.coordinates, arm))


def parts_of(model: SuppliedEquations) -> list[str]:
    """What a table of a model's answers has."""
    given = {STANDS_FOR.get(part, part) for part in model.given}
    return [part for part in state_requests.PARTS if part in given]


def answers(
    model: SuppliedEquations, asked: state_requests.StateRequest, everywhere: bool = False
) -> dict[str, np.ndarray]:
    """By part (rows, ...), NaN where it is not needed, or everywhere."""
    found = {}
    for part in parts_of(model):
        values = np.full((asked.count, *asked.shape(part)), np.nan)
        for row in np.flatnonzero(asked.needed[part] | everywhere):
            own = [asked.arguments[name][row] for name in TAKES[part]]
            own = [own[0][0], *own[1:]] if TAKES[part][0] == "t" else own
            values[row] = getattr(model, part)(*own)
        found[part] = values
    return found


def write_csv(
    file: Path, sheets: Iterable[tuple[state_requests.StateRequest, dict[str, np.ndarray]]]
) -> Path:
    """Answers of one or several sheets; rows that answer nothing are left out."""
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        for number, (asked, values) in enumerate(sheets):
            n = len(asked.names)
            columns = [name for part in values for name in state_requests.answer_columns(part, n)]
            if not number:
                writer.writerow(["row", *columns])
            flat = np.hstack([each.reshape(asked.count, -1) for each in values.values()])
            for row in np.flatnonzero(~np.isnan(flat).all(axis=1)):
                cells = [" " if np.isnan(value) else repr(float(value)) for value in flat[row]]
                writer.writerow([asked.first + int(row), *cells])
    return file


def judge_table(table: state_requests.TableTrial, *files: Path) -> Trial:
    """The trial of the answers in files."""
    equations = build_table_equations(read_trial_answers(table, files))
    return run_trial(table.make_request("yours", equations))


def sheets_of(
    table: state_requests.TableTrial, equations: Equations, probes: bool
) -> list[tuple[state_requests.StateRequest, dict[str, np.ndarray]]]:
    """All that is asked, with a model's answers; on probes too."""
    asked = [state_requests.collect_state_request(table)]
    parts = parts_of(bound(equations, table.mechanism))
    if probes or "inverse_dynamics" in parts:
        asked += state_requests.collect_inverse_requests(table, asked[0])
    if probes:
        asked += table.collect_probe_requests(parts, next_row(asked))
    return [(each, answers(bound(equations, each.arm), each)) for each in asked]
