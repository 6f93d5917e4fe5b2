"""What `crosscheck trial --ask` writes: states as CSV and MAT files, a README, templates."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.report.rendering import templates
from crosscheck.trial.tables.asked import (
    LETTERS,
    NEEDED,
    PARTS,
    ROW,
    SHORT,
    AskedStates,
    TableTrial,
    answer_columns,
    argument_columns,
)

MAT_TEXT = b"MATLAB 5.0 MAT-file, states of a trial, geararm-crosscheck"
TEXT_LENGTH = 116  # of what begins a MAT file
TEMPLATES = ("README.md", "answers.m", "answers.c", "answers.jl", "answers.mos")


def ask_files(
    trial: TableTrial, sheets: Sequence[AskedStates], told: str
) -> dict[str, str | bytes]:
    """Every file of the folder by its name; told: the options that --answers needs too."""
    found: dict[str, str | bytes] = {}
    for asked in sheets:
        found |= _tables(trial, asked, "")
    return found | _texts(trial, sheets, told, [])


def probe_files(
    trial: TableTrial, probes: Sequence[AskedStates], told: str
) -> dict[str, str | bytes]:
    """The second round: each probe's arm and what is asked on it."""
    found: dict[str, str | bytes] = {}
    stems = [f"probe-{number}" for number in range(1, len(probes) + 1)]
    for stem, asked in zip(stems, probes, strict=True):
        found[f"{stem}.toml"] = arm_toml(asked.arm)
        found |= _tables(trial, asked, f"{stem}-")
    return found | _texts(trial, probes, told, stems)


def _tables(trial: TableTrial, asked: AskedStates, begins: str) -> dict[str, str | bytes]:
    """All rows; those of inverse dynamics, which take accelerations, in files of their own."""
    found: dict[str, str | bytes] = {}
    for name, here in (("states", ~asked.apart), ("inverse_dynamics", asked.apart)):
        if here.any():
            found |= _table(trial, asked, begins + name, np.flatnonzero(here))
    return found


def _table(
    trial: TableTrial, asked: AskedStates, name: str, rows: np.ndarray
) -> dict[str, str | bytes]:
    """Rows as a CSV and a MAT file, with the arguments that they have."""
    apart = bool(asked.apart[rows].any())
    arguments = ("x", "v", "a") if apart else ("t", "x", "v", "torque")
    named = argument_columns(asked.frame, trial.coordinates, asked.arm)
    numbers = asked.first + rows
    flags = np.array([asked.needed[part][rows] for part in PARTS], dtype=int).T
    columns = [ROW, *(column for name in arguments for column in named[name]), *NEEDED]
    values = np.hstack([asked.arguments[name][rows] for name in arguments])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for number, row, flag in zip(numbers.tolist(), values.tolist(), flags.tolist(), strict=True):
        writer.writerow([number, *row, *flag])
    variables: dict[str, Any] = {ROW: numbers[:, None].astype(float)}
    variables |= {LETTERS.get(each, each): asked.arguments[each][rows] for each in arguments}
    variables |= dict(zip(NEEDED, flags.T[:, :, None].astype(float), strict=True))
    return {f"{name}.csv": text.getvalue(), f"{name}.mat": mat_file(variables)}


def mat_file(variables: Mapping[str, np.ndarray]) -> bytes:
    """A MAT v5 file that is the same whenever it is made."""
    import scipy.io  # a fifth of a second, for MAT files alone

    file = io.BytesIO()
    scipy.io.savemat(file, dict(variables), do_compression=False)
    return MAT_TEXT.ljust(TEXT_LENGTH) + file.getvalue()[TEXT_LENGTH:]


def _texts(
    trial: TableTrial, sheets: Sequence[AskedStates], told: str, probes: Sequence[str]
) -> dict[str, str | bytes]:
    texts = templates("crosscheck.trial.tables", lean=True)
    asked, n = sheets[0], len(sheets[0].frame.names)
    parts = [part for part in PARTS if any(sheet.needed[part].any() for sheet in sheets)]
    facts = {
        "arm": asked.arm.name,
        "joints": len(asked.arm.joints),
        "n": n,
        "names": asked.frame.names,
        "count": int((~asked.apart).sum()),
        "answers": {SHORT[part]: answer_columns(part, n) for part in PARTS},
        "parts": [SHORT[part] for part in parts],
        "told": told,
        "probes": probes,
        "stem": f"{probes[0]}-states" if probes else "states",
    }
    made = {name: texts.get_template(f"{name}.j2").render(facts) for name in TEMPLATES}
    return {name: text.rstrip("\n") + "\n" for name, text in made.items()}


def arm_toml(arm: Arm) -> str:
    """An arm's file, which is read back as the same arm."""
    return "".join(f"{line}\n" for line in _entries(arm.model_dump(mode="json")))


def _entries(record: Mapping[str, Any]) -> Iterator[str]:
    for key, value in record.items():
        if value is not None:
            yield f"{key} = {_value(value)}"


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(_entries(value))} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, str):
        return json.dumps(value)
    return json.dumps(value) if isinstance(value, bool) else repr(value)
