"""A study's quantities of members that ran side by side, from the whole signals of their runs.

Numbers are as in ``crosscheck.signals``, of many signals at once; nan means that the event did not
happen, or that there was no sample.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from crosscheck import signals
from crosscheck.analytic.ensemble import group_models
from crosscheck.mechanisms import supply
from crosscheck.models.experiment.scenario import Scenario, Start
from crosscheck.models.trajectory import recorded_times
from crosscheck.studies.definition import quantities
from crosscheck.studies.definition.functions import call_function
from crosscheck.studies.measures.columns import require_measurable
from crosscheck.studies.members.cases import MemberCase
from crosscheck.studies.members.members import PreparedStudy

STEP_RATIO = 10  # steps of the geared arm in one of the rigid arm, which is smooth


class ChunkRecords(Protocol):
    """Part of a chunk that is measured; see crosscheck.analytic.ensemble.RunChunk."""

    @property
    def time(self) -> np.ndarray: ...


class SignalName(NamedTuple):
    """The name of a signal, and the planet of whose meshes it is; None for all planets."""

    name: str
    planet: int | None = None


Signals = dict[SignalName, np.ndarray]  # over whole runs, see ``_signal``


def measure_members(
    study: PreparedStudy, cases: Sequence[MemberCase], chunks: Iterable[ChunkRecords]
) -> dict[str, np.ndarray]:
    """The numbers of members that run side by side, (members, *the column's shape) by column.

    Raises InputError where a quantity means nothing for a member.
    """
    for quantity in study.definition.quantities:
        for case in cases:
            require_measurable(quantity, case, study.file)
    names = {name for each in study.definition.quantities for name in list_signals(each, cases[0])}
    time = recorded_times(cases[0].scenario)
    whole = _keep_signals(names, time, chunks)
    numbers: dict[str, np.ndarray] = {}
    for quantity in study.definition.quantities:
        if isinstance(quantity, quantities.Function):
            source = study.sources[quantity.function]
            numbers |= _call_function(quantity, cases, source, time, whole)
        elif isinstance(quantity, quantities.Trajectories):
            prefix = f"{quantity.name}_" if quantity.name else ""
            for name in quantity.signals:
                numbers[prefix + name] = np.moveaxis(whole[SignalName(name)], -1, 0)
        else:
            numbers |= _measure_signal(quantity, cases, time, whole)
    return numbers


def list_signals(quantity: quantities.Quantity, case: MemberCase) -> Iterator[SignalName]:
    """The signals that a quantity is measured by."""
    if isinstance(quantity, quantities.Function):
        yield from map(SignalName, case.signals)
    elif isinstance(quantity, quantities.Trajectories):
        yield from map(SignalName, quantity.signals)
    else:
        name = getattr(quantity, "signal", "theta")
        yield SignalName(name, getattr(quantity, "planet", 1))


def _keep_signals(
    names: Iterable[SignalName], time: np.ndarray, chunks: Iterable[ChunkRecords]
) -> Signals:
    """The signals over all times (times,) of runs that come in chunks."""
    whole: Signals = {}
    first = 0
    for chunk in chunks:
        last = first + chunk.time.size
        for name in names:
            values = _signal(chunk, *name)
            if name not in whole:
                whole[name] = np.empty((time.size, *values.shape[1:]))
            whole[name][first:last] = values
        first = last
    return whole


def _signal(chunk: ChunkRecords, name: str, planet: int | None) -> np.ndarray:
    """A signal of a chunk, of one planet where it is a mesh's, (records, joints, members).

    Of all planets it is as the chunk has it, (records, joints, planets, members).
    """
    values: np.ndarray = getattr(chunk, name)
    if planet is None or name not in quantities.MESH_SIGNALS:
        return values
    if planet > values.shape[2]:  # none of that number, or no meshes at all
        return np.full((values.shape[0], values.shape[1], values.shape[3]), np.nan)
    return values[:, :, planet - 1]


def _call_function(
    quantity: quantities.Function,
    cases: Sequence[MemberCase],
    source: str,
    time: np.ndarray,
    whole: Signals,
) -> dict[str, np.ndarray]:
    """The numbers that a function of the user's returns for each run."""
    runs = {name: whole[SignalName(name)] for name in cases[0].signals}
    for name in set(runs) - set(quantities.JOINT_SIGNALS):
        if np.isnan(runs[name][0]).all():  # of meshes that are not there
            del runs[name]
    answers: dict[str, list[float]] = {name: [] for name in quantity.returns}
    for place, case in enumerate(cases):
        single = {name: values[..., place] for name, values in runs.items()}
        run = case.make_run(time, single)
        is_finite = np.isfinite(run["theta"].values).all()
        function_numbers = call_function(quantity, source, run) if is_finite else {}
        for name, numbers in answers.items():
            numbers.append(function_numbers.get(name, np.nan))
    return {name: np.array(numbers) for name, numbers in answers.items()}


def _measure_signal(
    quantity: quantities.Quantity, cases: Sequence[MemberCase], time: np.ndarray, whole: Signals
) -> dict[str, np.ndarray]:
    """The numbers of a signal of one joint, or of all, in a window."""
    (signal,) = list_signals(quantity, cases[0])
    joint = getattr(quantity, "joint", None)
    joints = slice(None) if joint is None else joint - 1
    part = signals.window(time, *(getattr(quantity, "window_s", None) or (0.0, np.inf)))
    values = whole[signal][part, joints]  # (records, [joints,] members)
    match quantity:
        case quantities.FinalError() | quantities.Settling(target_rad=None):
            values = values - np.array([case.targets() for case in cases]).T[joints]
        case quantities.Settling():
            values = values - quantity.target_rad
        case quantities.RigidDeviation():
            angles, whose = simulate_rigid_angles(quantity.level, cases)
            values = values - np.moveaxis(angles[:, part][whose][..., joints], 0, -1)
    parts = ("_frequency", "_amplitude") if isinstance(quantity, quantities.SpectralPeak) else ("",)
    undefined = np.full((len(parts), *values.shape[1:]), np.nan)
    numbers = measure_values(quantity, time[part], values) if values.size else undefined
    named = zip(parts, numbers, strict=True)
    return {quantity.result_name + suffix: value.T for suffix, value in named}


def measure_values(
    quantity: quantities.Quantity, time: np.ndarray, values: np.ndarray
) -> np.ndarray | tuple[np.ndarray]:
    """The numbers (*columns,) that a quantity is of values (records, *columns), one or two.

    Values are those of its signal, less the target or the rigid arm's where it has one.
    """
    match quantity:
        case quantities.SpectralPeak():
            return _measure_spectra(signals.largest_line, quantity.band_Hz, time, values)
        case quantities.BandRms():
            return _measure_spectra(signals.band_rms, quantity.band_Hz, time, values)
        case quantities.Settling():
            outside = ~(np.abs(values) <= quantity.band_rad)
            after = time.size - outside[::-1].argmax(axis=0)  # the record after the last outside
            return (np.append(time, np.nan)[np.where(outside.any(axis=0), after, 0)],)
        case quantities.Crossing():
            is_above = quantity.side == "above"
            is_beyond = values > quantity.level if is_above else values < quantity.level
            return (_find_first_times(time, is_beyond),)
        case quantities.ContactLoss():
            has_carried = np.logical_or.accumulate(values != 0, axis=0)
            return (_find_first_times(time, has_carried & (values == 0)),)
        case quantities.NoContactShare():
            return (np.where(np.isnan(values), np.nan, values == 0).mean(axis=0),)
        case quantities.FinalError() | quantities.Size(kind="final"):
            return (values[-1],)
        case quantities.Size(kind="peak_to_peak"):
            return (np.ptp(values, axis=0),)
        case quantities.Size(kind="mean"):
            return (values.mean(axis=0),)
        case quantities.Size(kind="rms"):
            return (np.sqrt(np.square(values).mean(axis=0)),)
    return (np.maximum(values.max(axis=0), -values.min(axis=0)),)  # the largest magnitude


def _find_first_times(time: np.ndarray, is_met: np.ndarray) -> np.ndarray:
    """Times (*columns,) of the first records at which a condition (records, *columns) is met."""
    return np.where(is_met.any(axis=0), time[is_met.argmax(axis=0)], np.nan)


def _measure_spectra(
    measure: Callable[..., float | tuple[float, ...]],
    band: tuple[float, float],
    time: np.ndarray,
    values: np.ndarray,
) -> np.ndarray:
    """Numbers of each column's spectrum in a band, (numbers, *columns); nan for one with gaps."""

    def measure_column(column: np.ndarray) -> np.ndarray:
        numbers = np.atleast_1d(measure(time, np.ascontiguousarray(column), *band))
        return np.where(np.isfinite(column).all(), numbers, np.nan)

    return np.apply_along_axis(measure_column, 0, values)


def simulate_rigid_angles(level: str, cases: Sequence[MemberCase]) -> tuple[np.ndarray, np.ndarray]:
    """Angles [rad] of distinct rigid models, (models, records, joints), and the model of each case.

    They are on the geared runs' own recording grid; nan where a run diverged. Members that differ
    in their meshes alone share a model.
    """
    places: dict[object, int] = {}
    models, whose = list[Any](), list[int]()
    find_rigid_model = supply("find_rigid_model", cases[0].mechanism.section)
    for case in cases:
        key, build_model = find_rigid_model(case, level, _smooth_scenario(case.scenario))
        if key not in places:
            places[key] = len(models)
            models.append(build_model())
        whose.append(places[key])
    scenario, joints = models[0].scenario, len(cases[0].planet_counts)
    angles = np.full((len(models), scenario.steps // scenario.stride + 1, joints), np.nan)
    for group in group_models(models):
        theta = np.concatenate([chunk.theta for chunk in group.chunks()])
        alive = np.isnan(group.diverged_s)
        angles[np.array(group.members)[alive]] = np.moveaxis(theta, -1, 0)[alive]
    return angles, np.array(whose)


def _smooth_scenario(scenario: Scenario) -> Scenario:
    """The experiment with nothing of meshes, in steps for a smooth motion."""
    longer = next(n for n in range(STEP_RATIO, 0, -1) if scenario.stride % n == 0)
    given = {name: getattr(scenario.start, name) for name in ("theta_rad", "theta_dot_rad_per_s")}
    changed = {
        "step_s": scenario.step_s * longer,
        "record_every": scenario.stride // longer,
        "start": Start(**given),
    }
    return scenario.model_copy(update=changed)
