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
    """Files of the folder by name; told: the options that --answers needs too."""
    found: dict[str, str | bytes] = {}
    for asked in sheets:
        found |= _tables(trial, asked, "")
    return found | _texts(trial, sheets, told, [])


def probe_files(
    trial: TableTrial, probes: Sequence[AskedStates], told: str
) -> dict[str, str | bytes]:
    """Files of the second round by name: each probe's arm and what is asked on it."""
    found: dict[str, str | bytes] = {}
    stems = [f"probe-{number}" for number in range(1, len(probes) + 1)]
    for stem, asked in zip(stems, probes, strict=True):
        found[f"{stem}.toml"] = arm_toml(asked.arm)
        found |= _tables(trial, asked, f"{stem}-")
    return found | _texts(trial, probes, told, stems)


def _tables(trial: TableTrial, asked: AskedStates, begins: str) -> dict[str, str | bytes]:
    """The rows that are asked as CSV and MAT files, by name, with the arguments that they have.

    Those of inverse dynamics, which take accelerations, are in files of their own.
    """
    found: dict[str, str | bytes] = {}
    named = argument_columns(asked.frame, trial.coordinates, asked.arm)
    for name, here, arguments in (
        ("states", ~asked.apart, ("t", "x", "v", "torque")),
        ("inverse_dynamics", asked.apart, ("x", "v", "a")),
    ):
        rows = np.flatnonzero(here)
        if not rows.size:
            continue
        numbers = asked.first + rows
        flags = np.array([asked.needed[part][rows] for part in PARTS], dtype=int).T
        values = np.hstack([asked.arguments[each][rows] for each in arguments])
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([ROW, *(column for each in arguments for column in named[each]), *NEEDED])
        lines = zip(numbers.tolist(), values.tolist(), flags.tolist(), strict=True)
        writer.writerows([number, *row, *flag] for number, row, flag in lines)
        variables: dict[str, Any] = {ROW: numbers[:, None].astype(float)}
        variables |= {LETTERS.get(each, each): asked.arguments[each][rows] for each in arguments}
        variables |= dict(zip(NEEDED, flags.T[:, :, None].astype(float), strict=True))
        found[f"{begins}{name}.csv"] = text.getvalue()
        found[f"{begins}{name}.mat"] = mat_file(variables)
    return found


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
    """The TOML text of an arm's file, which is read back as the same arm."""
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
    return json.dumps(value)
