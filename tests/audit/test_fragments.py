"""The pieces of a page are right."""

import markupsafe
import numpy as np
import pytest
from matplotlib.transforms import Bbox

from crosscheck.report import fragments
from crosscheck.report.plots import figures, joints


def test_links_to_what_is_not_there_become_text():
    page = figures.fix_links('<i id="here">x</i><a href="#here">1</a><a href="#there">2</a>')
    assert page == '<i id="here">x</i><a href="#here">1</a>2'


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


@pytest.mark.parametrize(
    ("names", "titles"), [("a", "x"), ("abc", "x"), ("a", "xy"), ("ab", "xyz")]
)
def test_joints_stand_below_each_other_and_ways_to_look_at_them_beside(names, titles, monkeypatch):
    drawn, kept = [], []

    def column(title: str) -> joints.JointColumn:
        def draw(joint, axes):
            drawn.append((title, joint))
            axes.plot([0, 1], [0, joint], label=f"{title}{joint}")

        return joints.JointColumn(f"title {title}", f"axis {title}", draw)

    monkeypatch.setattr(figures, "to_svg", lambda figure: kept.append(figure) or "svg")
    columns = [column(title) for title in titles]
    assert joints.draw_joints(names, columns, height=1.5, same_axis=False) == "svg"
    assert drawn == [(title, joint) for title in titles for joint in range(len(names))]
    (figure,) = kept
    assert figure.get_size_inches().tolist() == [9, 1.5 * len(names)]
    table = np.reshape(figure.axes, (len(names), len(titles)))
    last = len(names) - 1
    for (row, place), axes in np.ndenumerate(table):
        title = titles[place]
        assert axes.lines[0].get_label() == f"{title}{row}"
        assert axes.get_title() == f"title {title}" * (row == 0)
        assert axes.get_xlabel() == f"axis {title}" * (row == last)
        assert axes.get_ylabel() == names[row] * (place == 0)
        assert axes.get_legend() is None  # where curves may be
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [f"{titles[0]}0"]


def test_a_long_signal_is_drawn_as_a_band_and_a_short_one_as_a_line():
    """Up to two samples for each of 600 bins all are drawn; beyond them extremes alone."""
    _, grid = figures.make_figure(1, 2)
    for axes, count in zip(grid[0], (1200, 1201), strict=True):
        time = np.linspace(0, 1, count)
        figures.draw(axes, time, np.where(np.arange(count) == 700, 5.0, time), "a", "red")
    line, band = grid[0]
    assert ([len(each.lines) for each in grid[0]], len(band.collections)) == ([1, 0], 1)
    assert line.lines[0].get_ydata().max() == 5.0
    points = band.collections[0].get_paths()[0].vertices
    assert (points[:, 1].min(), points[:, 1].max()) == (0.0, 5.0)


def test_a_table_has_a_head_and_a_row_of_cells_each():
    rows = [["1", "<2"], [markupsafe.Markup("<b>3</b>"), "4"]]
    inner = (
        "<tr><th>a</th><th>b</th></tr><tr><td>1</td><td>&lt;2</td></tr>"
        "<tr><td><b>3</b></td><td>4</td></tr></table></div>"
    )
    begin = '<div class="wide" tabindex="0"><table>'
    assert fragments.render_table("ab", rows) == begin + inner
