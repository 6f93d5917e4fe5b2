"""Annotations of a GitHub workflow, one for each error that a trial found.

``python tools/annotate_trial.py trial.json my_model.py``; it needs nothing but Python. Of a trial
that ended before it could judge, and wrote nothing, there is one annotation that says so.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any


def format_annotations(trial: dict[str, Any], model: Path) -> Iterator[str]:
    """A line for each edit that corrects the model's file, else for each wrong entry; then notes.

    trial: what the JSON of a trial holds.
    """
    change = trial["change"]
    edits = [edit for edit in change["edits"] if edit["file"] == model.name] if change else []
    for edit in edits:
        place = f"{model},line={edit['line']}"
        new = f"should be {edit['new']}" if edit["new"] else "should be left out"
        remedy = escape_message(f"{edit['old']} {new}")
        yield f"::error file={place},title=Wrong line::{remedy}"
    for wrong in trial["wrong"] if not edits else ():
        place, source = str(model), wrong["source"]
        if source is not None and source["file"] == model.name:
            place += f",line={source['line']}"
        message = f"{wrong['name']}: {wrong['cause'] or 'differs'}"
        yield f"::error file={place},title=Wrong entry::{escape_message(message)}"
    for note in (*trial["causes"], *trial["notes"]):
        yield f"::notice file={model}::{escape_message(note)}"


def escape_message(text: str) -> str:
    """The text as a workflow command takes it."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


if __name__ == "__main__":
    answers, model_file = Path(sys.argv[1]), Path(sys.argv[2])
    if answers.is_file():
        content = json.loads(answers.read_text(encoding="utf-8"))
        print(*format_annotations(content, model_file), sep="\n")
    else:
        print(f"::error file={model_file}::the trial judged nothing: its step says why")
