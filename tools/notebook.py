"""Notebooks of Python cells: read from a script, run, shown as a page.

A script's cells begin with a line ``# %%``, those of text with ``# %% [markdown]``, as editors have
it. Cells run in one namespace and in the current folder; what they print is kept, what their last
expression shows, and the figures that they draw.
"""

from __future__ import annotations

import ast
import base64
import io
import re
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from typing import Any

INK = "#7d8790"  # of axes and their text: to be read on white and on black


@dataclass(frozen=True)
class Cell:
    """Text in Markdown, or code with what it showed: MIME type and content."""

    source: str
    is_code: bool = False
    outputs: tuple[tuple[str, str], ...] = field(default=(), kw_only=True)


def read_cells(script: str) -> list[Cell]:
    """The cells of a script."""
    cells = []
    for kind, body in re.findall(r"^# %%(.*)\n((?:(?!# %%).*\n?)*)", script, re.M):
        source = body.strip("\n")
        if "[markdown]" in kind:
            source = re.sub(r"^# ?", "", source, flags=re.M)
        cells.append(Cell(source, is_code="[markdown]" not in kind))
    return cells


def run_cells(cells: Sequence[Cell], names: dict[str, Any] | None = None) -> list[Cell]:
    """The cells with what they show.

    Args:
        cells: Text and code.
        names: Namespace that the code finds and leaves, its values as ``Out``; or a new one.

    Raises:
        Exception: Whatever a cell raises.
    """
    names = {} if names is None else names
    names |= {"__name__": "__main__", "Out": {}}
    return [
        Cell(cell.source, is_code=True, outputs=tuple(_run(cell.source, number, names)))
        if cell.is_code
        else cell
        for number, cell in enumerate(cells, 1)
    ]


def _run(source: str, number: int, names: dict[str, Any]) -> list[tuple[str, str]]:
    """What a cell printed, and its figures or else the value of its last expression."""
    printed, result = io.StringIO(), None
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    with redirect_stdout(printed):
        exec(compile(tree, f"cell {number}", "exec"), names)
        if isinstance(last, ast.Expr):
            expression = ast.Expression(last.value)
            result = eval(compile(expression, f"cell {number}", "eval"), names)
    names["Out"][number] = result
    outputs = [("text/plain", printed.getvalue())] if printed.getvalue() else []
    if figures := _take_figures():
        return outputs + [("image/svg+xml", each) for each in figures]
    return outputs if result is None else [*outputs, _show(result)]


def _show(result: Any) -> tuple[str, str]:
    """What a notebook shows of a value."""
    if hasattr(result, "_repr_html_"):
        return "text/html", result._repr_html_()
    return "text/plain", repr(result)


def _take_figures() -> list[str]:
    """Every open figure as SVG, for light and dark pages alike; all are closed."""
    if "matplotlib.pyplot" not in sys.modules:
        return []
    import matplotlib.pyplot as plt

    drawn = []
    for number in plt.get_fignums():
        figure = plt.figure(number)
        for axes in figure.axes:
            axes.patch.set_alpha(0)
            axes.tick_params(which="both", colors=INK)
            axes.title.set_color(INK)
            for label in (axes.xaxis.label, axes.yaxis.label):
                label.set_color(INK)
            for spine in axes.spines.values():
                spine.set_color(INK)
        if figure.get_suptitle():
            figure.suptitle(figure.get_suptitle(), color=INK)
        file = io.StringIO()
        figure.savefig(
            file, format="svg", transparent=True, bbox_inches="tight", metadata={"Date": None}
        )
        drawn.append(file.getvalue())
        plt.close(figure)
    return drawn


def format_page(cells: Sequence[Cell]) -> str:
    """The notebook as a page in Markdown."""
    blocks = []
    for cell in cells:
        blocks.append(f"```python\n{cell.source}\n```" if cell.is_code else cell.source)
        for kind, content in cell.outputs:
            if kind == "text/plain":
                blocks.append(f"```text\n{content.rstrip()}\n```")
            elif kind == "text/html":
                blocks.append(f"```{{raw}} html\n{content.strip()}\n```")
            else:
                coded = base64.b64encode(content.encode()).decode()
                picture = f'<img alt="what the cell draws" src="data:{kind};base64,{coded}">'
                blocks.append(f"```{{raw}} html\n{picture}\n```")
    return "\n\n".join(blocks) + "\n"


def format_notebook(cells: Sequence[Cell]) -> dict[str, Any]:
    """The notebook as Jupyter has it, nbformat 4.5."""
    found: list[dict[str, Any]] = []
    for number, cell in enumerate(cells, 1):
        common = {"id": f"cell-{number}", "metadata": {}, "source": _lines(cell.source)}
        if not cell.is_code:
            found.append({"cell_type": "markdown", **common})
            continue
        outputs = [
            {"output_type": "display_data", "metadata": {}, "data": {kind: _lines(content)}}
            for kind, content in cell.outputs
        ]
        found.append({"cell_type": "code", **common, "execution_count": number, "outputs": outputs})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return {"cells": found, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)
