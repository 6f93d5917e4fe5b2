"""What the drawings of a study's result show, read back and worked out again from the result."""

from collections.abc import Iterator

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from crosscheck.studies import plot

ACROSS, DOWN, SAMPLES = np.geomspace(1e-6, 1e-4, 5), np.array([0.1, 0.3, 0.7]), 40
UNIT, SIZE, MISSING = "m", "a size", "never settles"
LABEL = f"size [{UNIT}]"


def _values(dims: tuple[str, ...], values: np.ndarray) -> xr.DataArray:
    coords = {
        "play": ("play", ACROSS, {"units": "mm"}),
        "mass": ("mass", DOWN, {"units": "kg"}),
        "joint": ("joint", [1, 2]),
    }
    own = {name: each for name, each in coords.items() if name in dims}
    attributes = {"units": UNIT, "long_name": SIZE, "comment": MISSING}
    return xr.DataArray(values, own, dims, "size", attributes)


def _drawn(values: xr.DataArray) -> list[Axes]:
    with mpl.rc_context(plot.STYLE):
        figure = plot.make_study_figure(xr.Dataset({"size": values}), ["size"])
    return figure.axes


def wrong_drawings() -> Iterator[str]:
    """Of curves, maps and distributions of a result."""
    yield from wrong_curves()
    yield from wrong_maps()
    yield from wrong_distributions()


def wrong_curves() -> Iterator[str]:
    """Of medians and bands over one axis, of each joint, and of the share of two states."""
    values = np.random.default_rng(6).normal(size=(5, SAMPLES, 2)) * [1.0, 1e-3] + [3.0, 0.0]
    # More and more members end in the upper of two states of the first joint.
    upper = np.arange(SAMPLES)[None] < np.array([2, 9, 17, 25, 36])[:, None]
    values[:, :, 0] += 100.0 * upper
    values[1, 5, 0] = values[4, :, 1] = np.nan
    first, second, *more = _drawn(_values(("play", "sample", "joint"), values))
    for joint, axes in enumerate((first, second)):
        own = values[:, :, joint]
        shown = 5 - joint  # the last point has no value of the second joint
        right = np.nanquantile(own[:shown], [0.05, 0.25, 0.5, 0.75, 0.95], axis=1)
        line, crosses = axes.lines
        if not np.allclose(line.get_xydata()[:shown], np.column_stack([ACROSS[:shown], right[2]])):
            yield f"median of joint {joint + 1}"
        if not np.array_equal(crosses.get_xdata(), ACROSS[[1, 4][joint : joint + 1]]):
            yield f"undefined points of joint {joint + 1}: {crosses.get_xdata()}"
        if not axes.get_xlim()[1] >= ACROSS[-1]:
            yield f"range of joint {joint + 1}: {axes.get_xlim()}"
        if [text.get_text() for text in axes.texts] != [f"{MISSING}: {[1, SAMPLES][joint]} of 200"]:
            yield f"count of undefined members: {axes.texts}"
        for band, rows in zip(axes.collections, ((0, 4), (1, 3)), strict=True):
            points = band.get_paths()[0].vertices
            for x, low, high in zip(ACROSS[:shown], *right[list(rows)], strict=True):
                at = points[np.isclose(points[:, 0], x, rtol=1e-9)][:, 1]
                if not np.allclose([at.min(), at.max()], [low, high]):
                    yield f"band of joint {joint + 1} at {x}"
        if (axes.get_xlabel(), axes.get_ylabel()) != ("play [mm]", LABEL):
            yield f"labels {axes.get_xlabel()}, {axes.get_ylabel()}"
        if axes.get_title() != f"{SIZE}, joint {joint + 1}" or axes.get_xscale() != "log":
            yield f"title {axes.get_title()}, {axes.get_xscale()}"
    (share,) = more  # of the first joint alone
    there = np.isfinite(values[:, :, 0]).sum(axis=1)
    right = (values[:, :, 0] > 50).sum(axis=1) / there
    if not np.allclose(share.lines[0].get_xydata(), np.column_stack([ACROSS, right])):
        yield f"share above: {share.lines[0].get_ydata()}, must be {right}"
    between = float(share.get_ylabel().removeprefix("share above "))
    if not 10 < between < 95:
        yield f"states parted at {between}"


def wrong_maps() -> Iterator[str]:
    """Of medians over two axes: as colours, at their places, with their names."""
    values = (
        np.random.default_rng(6).normal(size=(3, 5, SAMPLES)) + 10 * np.arange(3)[:, None, None]
    )
    axes, bar = _drawn(_values(("mass", "play", "sample"), values))
    (colours,) = axes.collections
    if not np.allclose(colours.get_array(), np.median(values, axis=2)):
        yield "colours of a map"
    corners = colours.get_coordinates()
    for place, right in enumerate((ACROSS, DOWN)):
        edges = corners[0, :, 0] if place == 0 else corners[:, 0, 1]
        if not all(low < at < high for low, at, high in zip(edges, right, edges[1:], strict=False)):
            yield f"places along axis {place}: {edges}"
    labels = axes.get_xlabel(), axes.get_ylabel(), bar.get_ylabel()
    if labels != ("play [mm]", "mass [kg]", LABEL):
        yield f"labels of a map: {labels}"
    if (axes.get_xscale(), axes.get_yscale()) != ("log", "linear"):
        yield f"scales of a map: {axes.get_xscale()}, {axes.get_yscale()}"


def wrong_distributions() -> Iterator[str]:
    """Of members along no axis: how many are in each bin, and what share is below each value."""
    values = np.append(np.random.default_rng(6).normal(size=SAMPLES), np.nan)
    axes, shares = _drawn(_values(("sample",), values))
    finite = np.sort(values[:-1])
    edges = [bar.get_x() for bar in axes.patches]
    counts = [bar.get_height() for bar in axes.patches]
    right = np.histogram(finite, bins=len(edges))[0]
    if not np.array_equal(counts, right) or not np.isclose(edges[0], finite[0]):
        yield f"bins {counts}, must be {right}"
    if axes.get_ylabel() != f"members, of {SAMPLES + 1}":
        yield f"label {axes.get_ylabel()}"
    points = shares.lines[0].get_xydata()
    for n, value in enumerate(finite, 1):
        if not np.isclose(points[points[:, 0] <= value, 1].max(), n / SAMPLES):
            yield f"share below {value}"
