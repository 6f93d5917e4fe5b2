"""Output of `crosscheck trial --ask`: states as CSV and MAT files, a README, templates."""

from __future__ import annotations

import csv
import io
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.files import format_toml_fields
from crosscheck.report.rendering import load_templates
from crosscheck.trial.tables.state_requests import (
    LETTERS,
    ROW,
    SHORT,
    AnsweredTrial,
    StateRequest,
    answer_columns,
    flag_column,
)

MAT_TEXT = b"MATLAB 5.0 MAT-file, states of a trial, geararm-crosscheck"
TEXT_LENGTH = 116  # length of the text at the head of a MAT file
TEMPLATES = ("README.md", "answers.m", "answers.c", "answers.jl", "answers.mos")


def render_request_files(
    trial: AnsweredTrial, sheets: Sequence[StateRequest], shared_options: str, folder: Path
) -> dict[str, str | bytes]:
    """Files of the folder by name; shared_options: the options that --answers needs too.

    folder: where these files will be, as seen from where the options hold.
    """
    first = shlex.quote(str(folder / "answers.csv"))
    facts = {"stem": "states", "output": "answers", "probes": (), "options": shared_options}
    facts |= {"first": first, "files": f"--answers {first}"}
    return _render_files(trial, sheets, "", facts)


def render_probe_files(
    trial: AnsweredTrial,
    probes: Sequence[StateRequest],
    shared_options: str,
    earlier: Sequence[Path],
    folder: Path,
) -> dict[str, str | bytes]:
    """Files of the second round by name: each probe's arm and what is asked on it.

    earlier: files of first answers; folder: where these files will be.
    """
    files: dict[str, str | bytes] = {}
    stems = {f"probe-{number}": f"answers_{number}" for number in range(1, len(probes) + 1)}
    answered = [*earlier, *(folder / f"{output}{earlier[-1].suffix}" for output in stems.values())]
    words = shlex.join([word for path in answered for word in ("--answers", str(path))])
    shared = {"options": shared_options, "files": words, "probes": list(stems)}
    for (stem, output), request in zip(stems.items(), probes, strict=True):
        files[f"{stem}.toml"] = format_arm_toml(request.arm)
        facts = shared | {"stem": f"{stem}-states", "output": output}
        files |= _render_files(trial, [request], f"{stem}-", facts)
    return files


def _render_tables(request: StateRequest, begins: str) -> dict[str, str | bytes]:
    """The rows that are asked as CSV and MAT files, by name, with the arguments that they have.

    Those of inverse dynamics, which take accelerations, are in files of their own.
    """
    files: dict[str, str | bytes] = {}
    named, needed = request.columns, [flag_column(part) for part in request.needed]
    for name, here, arguments in (
        ("states", ~request.inverse_dynamics_rows, ("t", "x", "v", "torque")),
        ("inverse_dynamics", request.inverse_dynamics_rows, ("x", "v", "a")),
    ):
        rows = np.flatnonzero(here)
        if not rows.size:
            continue
        numbers = request.first + rows
        flags = np.array([each[rows] for each in request.needed.values()], dtype=int).T
        values = np.hstack([request.arguments[each][rows] for each in arguments])
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([ROW, *(column for each in arguments for column in named[each]), *needed])
        lines = zip(numbers.tolist(), values.tolist(), flags.tolist(), strict=True)
        writer.writerows([number, *row, *flag] for number, row, flag in lines)
        variables: dict[str, Any] = {ROW: numbers[:, None].astype(float)}
        variables |= {LETTERS.get(each, each): request.arguments[each][rows] for each in arguments}
        variables |= dict(zip(needed, flags.T[:, :, None].astype(float), strict=True))
        files[f"{begins}{name}.csv"] = text.getvalue()
        files[f"{begins}{name}.mat"] = encode_mat_file(variables)
    return files


def encode_mat_file(variables: Mapping[str, np.ndarray]) -> bytes:
    """A MAT v5 file that is the same whenever it is made."""
    import scipy.io  # a fifth of a second, for MAT files alone

    file = io.BytesIO()
    scipy.io.savemat(file, dict(variables), do_compression=False)
    return MAT_TEXT.ljust(TEXT_LENGTH) + file.getvalue()[TEXT_LENGTH:]


def _render_files(
    trial: AnsweredTrial, sheets: Sequence[StateRequest], begins: str, facts: dict[str, Any]
) -> dict[str, str | bytes]:
    """The states that are asked, README, and templates that read ``stem`` and write ``output``.

    begins: the names of the files of states.
    """
    files: dict[str, str | bytes] = {}
    for sheet in sheets:
        files |= _render_tables(sheet, begins)
    texts = load_templates("crosscheck.trial.tables", lean=True)
    request, n = sheets[0], len(sheets[0].names)
    parts = [part for part in trial.parts if any(sheet.needed[part].any() for sheet in sheets)]
    facts |= {
        "arm": trial.mechanism.name,
        "is_robot": request.arm.section == "robot",
        "joints": len(request.columns["torque"]),
        "n": n,
        "names": request.names,
        "count": int((~request.inverse_dynamics_rows).sum()),
        "answers": {SHORT[part]: answer_columns(part, n) for part in trial.parts},
        "parts": [SHORT[part] for part in parts],
        "least_digits": trial.least_digits,
    }
    made = {name: texts.get_template(f"{name}.j2").render(facts) for name in TEMPLATES}
    return files | {
        name.replace("answers", facts["output"]): text.rstrip("\n") + "\n"
        for name, text in made.items()
    }


def format_arm_toml(arm: Arm) -> str:
    """The TOML text of an arm's file, which is read back as the same arm."""
    return "".join(f"{line}\n" for line in format_toml_fields(arm.model_dump(mode="json")))
