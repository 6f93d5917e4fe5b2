"""Annotations of a GitHub workflow, one for each error that a trial found.

``python tools/annotate_trial.py trial.json my_model.py``; it needs nothing but Python.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any


def format_annotations(trial: dict[str, Any], model: Path) -> Iterator[str]:
    """A line for each wrong entry, at its function where that is in the model's file."""
    for wrong in trial["wrong"]:
        place, source = str(model), wrong["source"]
        if source is not None and source["file"] == model.name:
            place += f",line={source['line']}"
        yield f"::error file={place},title=Wrong entry::{escape_message(wrong['told'])}"
    for note in trial["notes"]:
        yield f"::notice file={model}::{escape_message(note)}"


def escape_message(text: str) -> str:
    """The text as a workflow command takes it."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


if __name__ == "__main__":
    content = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    print(*format_annotations(content, Path(sys.argv[2])), sep="\n")
