"""The picture of the case study: the paper's mass matrix beside an engine's, entry by entry.

``python -m tools.readme_picture`` writes docs/mass-matrix.svg.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

import numpy as np

import crosscheck
from crosscheck.report.heat_map import HeatMap, make_heat_map

OUT = Path(__file__).parents[1] / "docs" / "mass-matrix.svg"
ENGINE = "exudyn:tree"
TITLES = {"analytic:printed": "as printed in the paper", "analytic:physical": "corrected"}
STATES, SEED = 200, 0
TOLERANCE = 1e-10  # a tick: rounding is below it, every error above
MESH_M = 1e-4  # displacements of the teeth in the random states
CELL, ROW, LEFT, TOP, GAP, LETTER = 62, 30, 58, 58, 26, 8  # pixels
STYLE = """
text { font: 13px system-ui, sans-serif; fill: #1c2733; text-anchor: middle; }
.title { font-weight: 600; text-anchor: start; } .row { text-anchor: end; }
rect { fill: none; stroke: #d8dfe6; } .s0 { fill: #1a6e3f; }
rect.s1 { fill: #fdecea; } rect.s2 { fill: #f9d3ce; } rect.s3 { fill: #f0aaa2; }
rect.s4 { fill: #a61f17; } text.s4 { fill: #fff; } rect.s0 { fill: none; }
@media (prefers-color-scheme: dark) {
  text { fill: #e4e9ee; } rect { stroke: #3a444e; } text.s0 { fill: #6fce96; }
  rect.s1 { fill: #33211f; } rect.s2 { fill: #54282a; } rect.s3 { fill: #7a2c2a; }
  rect.s4 { fill: #b3261e; } text.s4 { fill: #fff; }
}
"""


def compare_mass_matrices() -> Iterator[HeatMap]:
    """How far each form of the paper's equations is from the engine, by random states."""
    arm, scenario = crosscheck.load_arm("paper-labelled"), crosscheck.load_scenario("pd")
    engine = crosscheck.build(ENGINE, arm, scenario)
    names, draw = engine.coordinates, np.random.default_rng(SEED)
    ranges = [np.pi if name.startswith("theta") else MESH_M for name in names]
    states = draw.uniform(-1, 1, (STATES, len(names))) * ranges
    expected = np.array([engine.mass_matrix(state) for state in states])
    root = np.sqrt(np.einsum("kii->ki", expected))
    size = root[:, :, None] * root[:, None, :]
    for model, title in TITLES.items():
        form = crosscheck.build(model, arm, scenario)
        values = np.array([form.mass_matrix(state) for state in states])
        relative = (np.abs(values - expected) / size).max(axis=0)
        yield make_heat_map(f"mass matrix, {title}", names, names, relative.tolist(), TOLERANCE)


def measure_map(heat_map: HeatMap) -> tuple[int, int]:
    """Widths of the names at the left of a map, and of a cell, by their letters [pixels]."""
    rows, columns = (max(map(len, names)) for names in (heat_map.rows, heat_map.columns))
    return max(LEFT, LETTER * rows + 2), max(CELL, LETTER * columns + 6)


def draw_map(heat_map: HeatMap, left: float) -> Iterator[str]:
    """The elements of a map, its names at the left and above."""
    margin, wide = measure_map(heat_map)
    yield f'<text class="title" x="{left + margin}" y="20">{escape(heat_map.title)}</text>'
    for number, name in enumerate(heat_map.columns):
        middle = left + margin + (number + 0.5) * wide
        yield f'<text x="{middle}" y="{TOP - 9}">{escape(name)}</text>'
    for number, (name, cells) in enumerate(zip(heat_map.rows, heat_map.cells, strict=True)):
        top = TOP + number * ROW
        yield f'<text class="row" x="{left + margin - 7}" y="{top + 20}">{escape(name)}</text>'
        for column, cell in enumerate(cells):
            at = left + margin + column * wide
            yield (
                f'<rect class="s{cell.shade}" x="{at}" y="{top}" width="{wide}" height="{ROW}"/>'
                f'<text class="s{cell.shade}" x="{at + wide / 2}" y="{top + 20}">{cell.text}</text>'
            )


def draw_maps(maps: Sequence[HeatMap]) -> str:
    """Maps side by side as SVG."""
    elements: list[str] = []
    left = 0
    for each in maps:
        elements += draw_map(each, left)
        margin, wide = measure_map(each)
        left += margin + max(wide * len(each.columns), LETTER * len(each.title)) + GAP
    width, height = left - GAP + 4, TOP + ROW * max(len(each.rows) for each in maps) + 4
    description = "; ".join(each.described for each in maps)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}"'
        f' height="{height}" role="img" aria-label="{escape(description)}">'
        f"<style>{STYLE}</style>{''.join(elements)}</svg>\n"
    )


if __name__ == "__main__":
    OUT.write_text(draw_maps(list(compare_mass_matrices())), encoding="utf-8")
    print(f"wrote {OUT}")
