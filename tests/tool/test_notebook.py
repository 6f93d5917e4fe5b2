"""docs/notebooks: every cell runs, and says today what is stored."""

import json
import re
from pathlib import Path

import pytest

from tests.processes import command_line

pytestmark = pytest.mark.system

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def shown_text(output: dict) -> str:
    """What a cell printed, or the text and the HTML of its value."""
    texts = [output["text"]] if "text" in output else output["data"].values()
    return "".join("".join(text) for text in texts)


def said(notebook: dict) -> list[list[str]]:
    """The words of every output; numbers, and the order of what is equally wrong, do not count."""
    outputs = [cell["outputs"] for cell in notebook["cells"] if cell["cell_type"] == "code"]
    texts = ["".join(map(shown_text, output)) for output in outputs]
    return [sorted(re.sub(r"[\d.,;]+(e-?\d+)?", "#", text).split()) for text in texts]


@pytest.mark.slow
@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_notebook_is_as_executed(file, tmp_path):
    stored = json.loads(file.read_text(encoding="utf-8"))
    assert (stored["nbformat"], stored["nbformat_minor"]) == (4, 5)
    env = {"PYTHONPATH": str(ROOT), "COLUMNS": "100"}
    script = (str(ROOT / "tools" / "run_notebook.py"),)
    answer = command_line(file, python=script, cwd=tmp_path, env=env, timeout=None)
    assert answer.returncode == 0, answer.stderr
    now = json.loads(answer.stdout)
    assert said(now) == said(stored)
    cells = [cell for cell in stored["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in cells] == [*range(1, len(cells) + 1)]
    assert any(cell["outputs"] for cell in cells)


def test_there_is_a_notebook():
    assert [file.name for file in NOTEBOOKS] == ["your-own-model.ipynb"]
