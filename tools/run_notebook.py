"""Print a notebook with its cells run anew: tools/run_notebook.py FILE > NEW.

Plain Python cells, run in one namespace and in the current folder; what they print is kept, and
what their last expression shows.
"""

from __future__ import annotations

import ast
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
    printed, result = io.StringIO(), None
    tree = ast.parse("".join(cell["source"]))
    shown = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    with redirect_stdout(printed):
        exec(compile(tree, f"cell {count}", "exec"), names)
        if shown is not None:
            expression = ast.Expression(shown.value)
            result = eval(compile(expression, f"cell {count}", "eval"), names)
    lines = printed.getvalue().splitlines(keepends=True)
    outputs = [{"name": "stdout", "output_type": "stream", "text": lines}] if lines else []
    return outputs + ([] if result is None else [_show_result(result, count)])


def _show_result(result: Any, count: int) -> dict[str, Any]:
    """What a notebook shows of a value."""
    data = {"text/plain": repr(result).splitlines(keepends=True)}
    if hasattr(result, "_repr_html_"):
        data["text/html"] = result._repr_html_().splitlines(keepends=True)
    return {
        "data": data,
        "execution_count": count,
        "metadata": {},
        "output_type": "execute_result",
    }


if __name__ == "__main__":
    given = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    print(json.dumps(execute_notebook(given), indent=1, ensure_ascii=False))
