"""The checker of pages finds what is wrong, and the pieces of a page are right."""

import numpy as np
import pytest
from matplotlib.transforms import Bbox

from crosscheck.report import fragments
from crosscheck.report.plots import figures
from tests.audit.markup import axis_problems, page_problems, uneven_tables

SOUND = '<h2 id="a">A</h2><p>b <b>c</b></p><a href="#a">a</a>'


@pytest.mark.parametrize(
    ("html", "what"),
    [
        ("<p>a<div>b</div></p>", "<div> in a <p>"),
        ("<p>a<table><tr><td>b</td></tr></table></p>", "<table> in a <p>"),
        ("<p>a<p>b</p></p>", "<p> in a <p>"),
        ("<p><b>a</p></b>", "mismatched tag"),
        ("<section>a", "mismatched tag"),
        ('<i id="a">a</i><i id="a">b</i>', "not unique"),
        ('<a href="#nowhere">a</a>', "leads nowhere"),
        ("<figure><svg></svg></figure>", "without a caption"),
        ("<svg></svg>", "outside of a <figure>"),
        ("<figure><svg><g></svg><figcaption>a</figcaption></figure>", "not XML"),
        ("<p>the size is nan rad</p>", "nan in the text"),
        ("<td>None</td>", "None in the text"),
    ],
)
def test_what_is_wrong_with_a_page_is_found(html, what):
    assert any(what in problem for problem in page_problems(SOUND + html))


def test_a_sound_page_has_no_problems():
    drawing = fragments.render_figure(_drawing("time [s]", "force [N]"), "caption")
    table = fragments.render_table(["a", "b"], [["1", "<2"]], "both")
    html = figures.fix_links(SOUND + drawing + drawing + table)
    assert page_problems(html) == []
    assert uneven_tables(html) == []


def test_uneven_tables_are_found():
    assert uneven_tables("<table><tr><th>a</th></tr><tr><td>1</td><td>2</td></tr></table>")


def test_links_to_what_is_not_there_become_text():
    page = figures.fix_links('<i id="here">x</i><a href="#here">1</a><a href="#there">2</a>')
    assert page == '<i id="here">x</i><a href="#here">1</a>2'


def _drawing(x: str, y: str) -> str:
    figure, grid = figures.make_figure(1, 2)
    for axes in grid[0]:
        axes.plot([0.0, 1.0], [0.0, 1.0])
    grid[0, 0].set(xlabel=x, ylabel=y)
    grid[0, 1].set(xlabel=x)
    return figures.to_svg(figure)


@pytest.mark.parametrize(
    ("x", "y", "count"),
    [
        ("time [s]", "force [N]", 0),
        ("t / T", "force [N]", 0),
        ("time", "force [N]", 2),
        ("time [s]", "", 2),
        ("", "", 4),
    ],
)
def test_axes_without_a_unit_are_found(x, y, count):
    """A label on the left serves the whole row; each column needs its own below."""
    assert len(axis_problems(_drawing(x, y))) == count


def test_a_legend_stands_beside_the_axes():
    figure, grid = figures.make_figure(2, 2)
    for number, axes in enumerate(grid.flat):
        for line in range(4):
            axes.plot([0, 1], [line, number], label=f"a rather long name {line}")
    figures.draw_legend(figure, *grid.flat)
    figure.draw_without_rendering()
    (box,) = (drawn.get_window_extent() for drawn in figure.legends)
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert not any(Bbox.intersection(box, axes.get_window_extent()) for axes in grid.flat)


def test_nothing_to_show_on_a_logarithmic_scale_is_said():
    figure, grid = figures.make_figure(1, 2)
    grid[0, 0].plot([0, 1], [np.nan, np.nan])
    grid[0, 1].plot([0, 1], [1.0, 10.0])
    for axes in grid[0]:
        figures.set_log_scale(axes)
    assert [axes.get_yscale() for axes in grid[0]] == ["linear", "log"]
    assert "the run ends before" in figures.to_svg(figure)
