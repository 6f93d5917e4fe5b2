"""Drawings of a study's result, chosen by its axes: curves, maps, distributions."""

from __future__ import annotations

import io
import math
import re
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from crosscheck.models.errors import InputError
from crosscheck.report.formatting import format_unit
from crosscheck.studies.batches.netcdf_file import StudyResultFile
from crosscheck.studies.batches.result_file import CHECKED
from crosscheck.studies.definition.axes import SAMPLE, START
from crosscheck.studies.measures.columns import DIVERGED

REPEAT_DIMENSIONS = (SAMPLE, START)  # dimensions along which a member is made again by chance
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
FEW = 0.02
TWO_STATES = 0.5  # width of an empty gap, over the range, that splits members into two states
MOST_DRAWN = 40  # drawings, one above the other
MOST_WORDS = 40  # along an axis
LONGEST = 90  # characters of a title or label
# What is measured of a signal of joints, in a name that a study makes: kind and noun in words.
MEASURED = re.compile(
    "(theta_ddot|theta_dot|theta|torque)_(peak_to_peak|peak|mean|band_rms|rms|final)(?=_joint|$)"
)
NOUNS = {"theta": "angle", "theta_dot": "rate", "theta_ddot": "acceleration"}
OF_ANGLES = re.compile("theta_(?=settling|final_error|rigid_deviation)")  # says nothing more
STYLE: dict[Any, Any] = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False}
WIDTH, HEIGHT = 6.4, 3.6  # inches of a drawing
DPI = 140


def drawable_names(result: StudyResultFile) -> list[str]:
    """Names of the quantities of a result that can be drawn."""
    return [
        str(name)
        for name, values in result.content.data_vars.items()
        if name != DIVERGED and not {CHECKED, "time"} & set(values.dims)
    ]


def draw_selected(quantities: list[str], result: StudyResultFile) -> bytes:
    """PNG content: drawings of these quantities, or of all that there are. Raises InputError."""
    available_names = drawable_names(result)
    for name in quantities:
        if name not in available_names:
            allowed = f"not in {result.path}; there are {', '.join(available_names)}"
            raise InputError("--quantity", "", name, allowed)
    names = list(dict.fromkeys(quantities)) or available_names
    panels = sum(result.content[name].sizes.get("joint", 1) for name in names)
    if not 0 < panels <= MOST_DRAWN:
        allowed = f"{panels} drawings, 1 to {MOST_DRAWN} are possible; name some by --quantity"
        raise InputError(str(result.path), "", None, allowed)
    return draw_png(result.read_variables(names), names)


def draw_png(result: xr.Dataset, names: Sequence[str]) -> bytes:
    """PNG content: a drawing for each quantity, and for each joint of it."""
    stream = io.BytesIO()
    with mpl.rc_context(STYLE):
        figure = make_study_figure(result, names)
        figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": "geararm-crosscheck"})
    return stream.getvalue()


def make_study_figure(result: xr.Dataset, names: Sequence[str]) -> Figure:
    """The figure with a drawing for each quantity, and for each joint of it."""
    panels = list[xr.DataArray]()
    for values in (result[name] for name in names):
        joints = values["joint"].values if "joint" in values.dims else ()
        panels += [values.sel(joint=joint) for joint in joints] or [values]
    rows = len(panels)
    figure = Figure(figsize=(WIDTH, HEIGHT * rows), layout="constrained")
    places = figure.subplots(rows, 1, squeeze=False)[:, 0]
    for axes, values in zip(places, panels, strict=True):
        _draw(axes, values)
    figure.suptitle(_cut(result.attrs.get("title", "")), fontsize=10)
    return figure


def _draw(axes: Axes, values: xr.DataArray) -> None:
    """Draw values by their axes: one as a curve, two as a map, none as a distribution."""
    axis_dims = [
        str(dim) for dim in values.dims if dim not in REPEAT_DIMENSIONS and values.sizes[dim] > 1
    ]
    single = [dim for dim in values.dims if dim not in (*axis_dims, *REPEAT_DIMENSIONS)]
    values = values.isel(dict.fromkeys(single, 0))
    axes.set_title(_panel_title(values), fontsize=9)
    if not np.isfinite(values.values).any() and len(axis_dims) != 1:
        axes.text(0.5, 0.5, "undefined in every member", transform=axes.transAxes, ha="center")
    elif not axis_dims:
        _draw_distribution(axes, values)
    elif len(axis_dims) == 1:
        _draw_curve(axes, values, axis_dims[0])
    else:
        _draw_map(axes, values, axis_dims)


def _panel_title(values: xr.DataArray) -> str:
    joint = f", joint {int(values['joint'])}" if "joint" in values.coords else ""
    return f"{_cut(str(values.attrs.get('long_name', values.name)))}{joint}"


def _axis_label(values: xr.DataArray) -> str:
    """A name in words with its unit, which the names of many fields end with as well."""
    name, suffix = str(values.name), f"_{values.attrs.get('units', '').replace(' ', '_')}"
    unit = format_unit(values.attrs.get("units", ""))
    name = MEASURED.sub(lambda match: f"{match[2]}_{NOUNS.get(match[1], match[1])}", name)
    name = re.sub(r"_joint(\d+)$", r"_of_joint_\1", OF_ANGLES.sub("", name.removesuffix(suffix)))
    label = name.replace("_", " ")
    return _cut(f"{label} [{unit}]" if unit else label)


def _cut(text: str) -> str:
    """A text of a file as a label: not too long, and no formula, whatever signs it has."""
    short = text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
    return short.replace("$", r"\$")


def _stack_repetitions(values: xr.DataArray, *axis_dims: str) -> np.ndarray:
    """The values with all repetitions along the last axis, shape (*own, repetitions)."""
    ordered = values.transpose(*axis_dims, ...).values
    return ordered.reshape(*ordered.shape[: len(axis_dims)], -1)


def _draw_distribution(axes: Axes, values: xr.DataArray) -> None:
    """Draw a histogram, and the share of members that are below each value."""
    finite_values = values.values[np.isfinite(values.values)]
    axes.hist(finite_values, bins=min(max(10, math.isqrt(finite_values.size)), 100), color="0.75")
    axes.set_xlabel(_axis_label(values))
    axes.set_ylabel(f"members, of {values.size:,}")
    _note_undefined(axes, values)
    shares = axes.twinx()
    shares.ecdf(finite_values, color="C0")
    shares.set_ylabel("share below")
    shares.spines["right"].set_visible(True)


def _draw_curve(axes: Axes, values: xr.DataArray, axis_dim: str) -> None:
    """Draw the median and bands of repetitions over an axis, and the share of two states, if so."""
    repeats, at = _stack_repetitions(values, axis_dim), values[axis_dim]
    x = _positions(at)
    low, lower, middle, upper, high = _quantiles(repeats)
    axes.plot(x, middle, "o-" if at.size < 30 else "-", color="C0", markersize=3, label="median")
    _mark_undefined(axes, x, repeats)
    _note_undefined(axes, values)
    if repeats.shape[1] > 1:
        axes.fill_between(x, low, high, color="C0", alpha=0.15, label="5 to 95 %")
        axes.fill_between(x, lower, upper, color="C0", alpha=0.25, label="25 to 75 %")
        axes.legend(fontsize=7)
        _draw_state_share(axes, x, repeats)
    _mark(at, axes.set_xscale, axes.set_xticks)
    axes.set_xlabel(_axis_label(at))
    axes.set_ylabel(_axis_label(values))
    if not np.isfinite(repeats).any():
        axes.set_yticks([])


def _mark_undefined(axes: Axes, x: np.ndarray, repeats: np.ndarray) -> None:
    """Draw a cross at the foot of each point that has an undefined member.

    All panels of a study then have the same range, and missing values are visible.
    """
    missing = x[~np.isfinite(repeats).all(axis=1)]
    if missing.size:
        foot = axes.get_xaxis_transform()
        axes.plot(missing, np.zeros(missing.size), "x", color="C3", transform=foot, clip_on=False)


def _note_undefined(axes: Axes, values: xr.DataArray) -> None:
    """Say how many members have no value, if any."""
    missing = int(values.size - np.isfinite(values.values).sum())
    if missing:
        note = f"{_cut(values.attrs.get('comment', 'undefined'))}: {missing:,} of {values.size:,}"
        text = axes.text(0.99, 0.98, note, fontsize=8, color="C3", transform=axes.transAxes)
        text.set(ha="right", va="top")


def _quantiles(repeats: np.ndarray) -> np.ndarray:
    """QUANTILES of each row, (quantiles, rows); nan where nothing is defined."""
    with warnings.catch_warnings(action="ignore", category=RuntimeWarning):
        return np.nanquantile(np.where(np.isfinite(repeats), repeats, np.nan), QUANTILES, axis=1)


def _draw_state_share(axes: Axes, x: np.ndarray, repeats: np.ndarray) -> None:
    """Draw the share of members in the upper of two states, where they fall into two."""
    between = find_state_boundary(repeats)
    if between is None:
        return
    finite_counts = np.isfinite(repeats).sum(axis=1)
    shares = (repeats > between).sum(axis=1) / np.maximum(finite_counts, 1)
    above = np.where(finite_counts > 0, shares, np.nan)
    share = axes.twinx()
    share.plot(x, above, "s--", color="C1", markersize=3)
    share.set_ylim(-0.05, 1.05)
    share.set_ylabel(f"share above {between:.3g}", color="C1")


def find_state_boundary(values: np.ndarray) -> float | None:
    """A number between two states that members fall into; None if there are no such two.

    What a few members do, fewer than FEW of all at either end, is no state.
    """
    finite_values = np.sort(values[np.isfinite(values)])
    few = int(FEW * finite_values.size)
    finite_values = finite_values[few : finite_values.size - few]
    if finite_values.size < 4:
        return None
    gaps = np.diff(finite_values)
    widest = int(gaps.argmax())
    if gaps[widest] <= TWO_STATES * (finite_values[-1] - finite_values[0]):
        return None
    return float(finite_values[widest] + finite_values[widest + 1]) / 2


def _draw_map(axes: Axes, values: xr.DataArray, axis_dims: Sequence[str]) -> None:
    """Draw medians over the last two axes, at the first point of any other."""
    down, across = axis_dims[-2:]
    fixed = dict.fromkeys(axis_dims[:-2], 0)
    part = values.isel(fixed)
    repeats = _stack_repetitions(part, down, across)
    grid = _quantiles(repeats.reshape(-1, repeats.shape[-1]))[2].reshape(repeats.shape[:2])
    x, y = _positions(part[across]), _positions(part[down])
    colours = axes.pcolormesh(x, y, grid, shading="nearest")
    _mark(part[across], axes.set_xscale, axes.set_xticks)
    _mark(part[down], axes.set_yscale, axes.set_yticks)
    axes.set_xlabel(_axis_label(part[across]))
    axes.set_ylabel(_axis_label(part[down]))
    if fixed:
        rest = ", ".join(_cut(f"{name} = {values[name].values[0]}") for name in fixed)
        axes.set_title(f"{_panel_title(values)}; {rest}", fontsize=9)
    axes.set_facecolor("0.85")  # where every member is undefined
    _note_undefined(axes, part)
    bar = axes.figure.colorbar(colours, ax=axes)
    bar.set_label(_axis_label(values))


def _mark(at: xr.DataArray, scale: Callable[[str], Any], ticks: Callable[..., Any]) -> None:
    """Put words in place of numbers, or a logarithmic scale, where a drawing's axis needs them."""
    if at.dtype.kind not in "if":
        shown = np.arange(0, at.size, math.ceil(at.size / MOST_WORDS))
        ticks(shown, [_cut(str(word)) for word in at.values[shown]])
    elif _is_logarithmic(at.values):
        scale("log")


def _positions(at: xr.DataArray) -> np.ndarray:
    return at.values if at.dtype.kind in "if" else np.arange(at.size)


def _is_logarithmic(x: np.ndarray) -> bool:
    """Whether the points are spaced by equal ratios rather than equal differences."""
    if x.size < 3 or (x <= 0).any():
        return False
    ratios, steps = np.diff(np.log(x)), np.diff(x)
    return bool(np.ptp(ratios) < 1e-6 * abs(ratios.mean()) and np.ptp(steps) > 1e-6 * abs(steps[0]))
