"""Print a notebook with its cells run anew: tools/run_notebook.py FILE > NEW.

Plain Python cells, run in one namespace and in the current folder; what they print is kept.
"""

from __future__ import annotations

import io
import json
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any


def execute_notebook(notebook: dict[str, Any]) -> dict[str, Any]:
    """The notebook with fresh outputs. Raises what a cell raises."""
    names: dict[str, Any] = {"__name__": "__main__"}
    cells, count = [], 0
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            count += 1
            cell = {**cell, "execution_count": count, "outputs": _outputs(cell, count, names)}
        cells.append(cell)
    return {**notebook, "cells": cells}


def _outputs(cell: dict[str, Any], count: int, names: dict[str, Any]) -> list[dict[str, Any]]:
    printed = io.StringIO()
    with redirect_stdout(printed):
        exec(compile("".join(cell["source"]), f"cell {count}", "exec"), names)
    lines = printed.getvalue().splitlines(keepends=True)
    return [{"name": "stdout", "output_type": "stream", "text": lines}] if lines else []


if __name__ == "__main__":
    given = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    print(json.dumps(execute_notebook(given), indent=1, ensure_ascii=False))
