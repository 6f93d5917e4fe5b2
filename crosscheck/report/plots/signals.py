"""Signals of each experiment for the page's two plots: a run, and the others' distance from it.

Numbers travel as float32 in base64. A difference is formed in double precision first, so that one
of 1e-12 keeps its digits. Where the full rate of a quantity is more than its share of the page, the
least and the largest value of every few records are kept, so that no peak is lost, and the named
windows have the full rate.
"""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr

from crosscheck.models.trajectory import meaning_of, unit_of
from crosscheck.registry import MODELS
from crosscheck.report.formatting import format_unit

QUANTITIES = ("theta", "theta_ddot", "x_sp", "F_sp", "F_pr")
MOST_NUMBERS = 450_000  # on a page: 2.4 MB as base64 of float32, of 4 MB for all
HALF_WINDOW_S = 2e-3
CONTACT = "F_sp"  # signal that decides whether teeth are in contact


@dataclass(frozen=True)
class RecordStretch:
    """A stretch of records for drawing.

    start_s, step_s: of the times; count: how many; binned: whether every place holds the least and
    the largest of several records; data: by ``name`` of a Line, base64 of float32 (count,), or of
    (count, 2) where binned.
    """

    start_s: float
    step_s: float
    count: int
    binned: bool
    data: dict[str, str]


@dataclass(frozen=True)
class Line:
    """A signal of the reference run, or a model's difference from it (model minus reference).

    peak: the largest magnitude, in the quantity's unit.
    """

    name: str
    quantity: str
    joint: int
    model: str
    peak: float


@dataclass(frozen=True)
class SignalWindow:
    """A stretch of time [s] worth a look, with what happens in it.

    full_rate: all records of those quantities that are binned in the whole run.
    """

    title: str
    begin_s: float
    end_s: float
    full_rate: dict[str, RecordStretch]


@dataclass(frozen=True)
class Signals:
    """All that is drawn of an experiment: lines of the reference model and of the others.

    rigid: those of the others that are drawn when asked for; whole: the run by quantity.
    """

    experiment: str
    reference: str
    others: tuple[str, ...]
    rigid: tuple[str, ...]
    lines: tuple[Line, ...]
    whole: dict[str, RecordStretch]
    windows: tuple[SignalWindow, ...]


def format_signals(signal_sets: Sequence[Signals]) -> dict[str, object]:
    """Data for the page's script: experiments, and each quantity's unit and meaning."""
    used = dict.fromkeys(line.quantity for each in signal_sets for line in each.lines)
    quantities = {n: {"unit": format_unit(unit_of(n)), "meaning": meaning_of(n)} for n in used}
    return {"experiments": [asdict(each) for each in signal_sets], "quantities": quantities}


def collect_signals(
    reference: str, runs: Mapping[str, Mapping[str, xr.Dataset]], most: int = MOST_NUMBERS
) -> list[Signals]:
    """The signals of each experiment.

    runs: by experiment and model, recorded at the same times; most: numbers for all experiments.
    The quantities with the fewest come first, and the others share the rest.
    """
    tables = {name: dict(_values(reference, each)) for name, each in runs.items()}
    sizes: Counter[tuple[str, str]] = Counter()
    for name, table in tables.items():
        for line, values in table.items():
            sizes[name, line.quantity] += values.size
    widths, left = {}, most
    for place, (key, size) in enumerate(sorted(sizes.items(), key=lambda item: item[1])):
        share = left // (len(sizes) - place)
        widths[key] = 1 if size <= share else -(-2 * size // share)
        left -= size if widths[key] == 1 else 2 * size // widths[key]
    signal_sets = []
    for name, table in tables.items():
        bin_widths = {each: width for (of, each), width in widths.items() if of == name}
        signal_sets.append(_signals(name, reference, runs[name], table, bin_widths))
    return signal_sets


def _signals(
    experiment: str,
    reference: str,
    runs: Mapping[str, xr.Dataset],
    values: Mapping[Line, np.ndarray],
    widths: Mapping[str, int],
) -> Signals:
    """The signals of one experiment; widths: records in a bin of the whole run, by quantity."""
    time = runs[reference]["time"].values
    tables = {q: {line.name: v for line, v in values.items() if line.quantity == q} for q in widths}
    binned = {quantity: table for quantity, table in tables.items() if widths[quantity] > 1}
    windows = []
    for title, begin, end in _events(time, runs[reference], values):
        inside = slice(int(np.searchsorted(time, begin)), int(np.searchsorted(time, end, "right")))
        full_rate = {
            quantity: make_stretch(time[inside], {name: v[inside] for name, v in table.items()}, 1)
            for quantity, table in binned.items()
        }
        windows.append(SignalWindow(title, begin, end, full_rate))
    others = tuple(name for name in runs if name != reference)
    rigid = tuple(name for name in others if MODELS[name].is_rigid)
    whole = {name: make_stretch(time, table, widths[name]) for name, table in tables.items()}
    return Signals(experiment, reference, others, rigid, tuple(values), whole, tuple(windows))


def _values(reference: str, runs: Mapping[str, xr.Dataset]) -> Iterator[tuple[Line, np.ndarray]]:
    """Every line with its numbers (times,)."""
    first = runs[reference]
    for quantity in (name for name in QUANTITIES if name in first):
        for place, joint in enumerate(map(int, first["joint"].values)):
            base = first_planet(first[quantity])[:, place]
            for model, run in runs.items():
                if quantity not in run:
                    continue
                values = first_planet(run[quantity])[:, place]
                values = values if model == reference else values - base
                name = f"{quantity}/{joint}/{model}"
                peak = float(np.abs(values).max())
                yield Line(name, quantity, joint, model, peak), values


def first_planet(values: xr.DataArray) -> np.ndarray:
    """Values of planet 1, (times, joints); signals without planets are unchanged."""
    return (values.isel(planet=0) if "planet" in values.dims else values).values


def make_stretch(time: np.ndarray, table: Mapping[str, np.ndarray], width: int) -> RecordStretch:
    """Records in bins of ``width``; with one record each, the records themselves."""
    edges = np.arange(0, time.size, width)
    data = {}
    for name, values in table.items():
        kept = values
        if width > 1:
            kept = np.stack([f.reduceat(values, edges) for f in (np.minimum, np.maximum)], axis=1)
        data[name] = base64.b64encode(kept.astype("<f4").tobytes()).decode()
    step = float(time[-1] - time[0]) / max(time.size - 1, 1) * width
    return RecordStretch(float(time[0]), step, edges.size, width > 1, data)


def _events(
    time: np.ndarray, run: xr.Dataset, values: Mapping[Line, np.ndarray]
) -> Iterator[tuple[str, float, float]]:
    """Moments worth a look, with begin and end [s]; none for an arm without teeth."""
    if CONTACT not in run:
        return
    numbers = map(int, run["joint"].values)
    force = dict(zip(numbers, first_planet(run[CONTACT]).T, strict=True))
    joint = max(force, key=lambda number: float(np.abs(force[number]).max()))
    places = {f"largest {CONTACT}, joint {joint}": int(np.abs(force[joint]).argmax())}
    lost = {n: _first_index(each[1:] == 0, each[:-1] != 0) for n, each in force.items()}
    places |= _select_earliest("contact lost", lost)
    signed = {n: each * each[(each != 0).argmax()] for n, each in force.items()}
    other = {n: _first_index(each < 0) for n, each in signed.items()}
    places |= _select_earliest("contact on the other side", other)
    for line, difference in values.items():
        if (line.quantity, line.joint) == (CONTACT, joint) and line.model != run.attrs["model"]:
            title = f"largest difference of {line.model}, joint {joint}"
            places[title] = int(np.abs(difference).argmax())
    for title, place in places.items():
        begin, end = time[place] - HALF_WINDOW_S, time[place] + HALF_WINDOW_S
        yield title, float(max(begin, time[0])), float(min(end, time[-1]))


def _first_index(*conditions: np.ndarray) -> int | None:
    """The first place where all conditions hold; None where there is none."""
    held = np.logical_and.reduce(np.broadcast_arrays(*conditions))
    return int(held.argmax()) if held.any() else None


def _select_earliest(title: str, places: Mapping[int, int | None]) -> dict[str, int]:
    defined_places = {number: place for number, place in places.items() if place is not None}
    if not defined_places:
        return {}
    number = min(defined_places, key=lambda each: defined_places[each])
    return {f"{title}, joint {number}": defined_places[number]}
