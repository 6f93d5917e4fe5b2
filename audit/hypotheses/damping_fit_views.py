"""A drawing of how many of the paper's numbers a setting explains."""

from __future__ import annotations

from collections.abc import Sequence

from crosscheck.audit.experiments.cells import LAWS, READINGS
from crosscheck.audit.hypotheses.evidence.fit import PLANETS, DampingFit
from crosscheck.report.figures import legend, new_figure, to_svg
from crosscheck.report.fragments import COLOURS


def drawing(
    found: Sequence[DampingFit], chosen: Sequence[DampingFit], names: dict[str, str]
) -> str:
    """Over zeta, a panel for each reading and way of the planets; names: of the laws."""
    picture, grid = new_figure(len(PLANETS), len(READINGS), 2.4)
    for row, planets in zip(grid, PLANETS, strict=True):
        for axes, (arm, reading) in zip(row, READINGS.items(), strict=True):
            for law, colour in zip(LAWS, COLOURS, strict=False):
                mine = [
                    fit for fit in found
                    if (fit.cell.law, fit.cell.arm, fit.cell.planets) == (law, arm, planets)
                ]  # fmt: skip
                points = [(fit.cell.zeta, fit.mean) for fit in mine]
                best = [(fit.cell.zeta, fit.mean) for fit in mine if fit in chosen]
                axes.plot(*_columns(points), "o-", color=colour, ms=3, label=names[law.id])
                axes.plot(*_columns(best), "o", mfc="none", mec="k", ms=8, label="equally good")
            axes.set(xscale="log", ylim=(0, len(found[0].explained)),
                     title=f"{reading}, planets {_WORDS[planets]}")  # fmt: skip
    for axes in grid[-1]:
        axes.set_xlabel("ζ")
    for axes in grid[:, 0]:
        axes.set_ylabel("numbers explained [1]")
    legend(picture, grid[0, 0])
    return to_svg(picture)


_WORDS = {"free": "free", "lumped": "lumped"}


def _columns(points: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [x for x, _ in points], [y for _, y in points]
