"""Observers that watch members chunk after chunk, and give a study's quantities in the end."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np

from crosscheck import signals
from crosscheck.studies.definition import quantities
from crosscheck.studies.definition.functions import call_function
from crosscheck.studies.measures import folds
from crosscheck.studies.measures.columns import require_measurable
from crosscheck.studies.members.cases import MemberCase
from crosscheck.studies.members.rigid import simulate_rigid_angles


class ChunkRecords(Protocol):
    """Part of a chunk that an observer needs; see crosscheck.analytic.ensemble.Chunk."""

    @property
    def time(self) -> np.ndarray: ...


class Observer(Protocol):
    """An observer of members that run side by side."""

    def observe(self, chunk: ChunkRecords) -> None:
        """Take in the next chunk in the order of time."""

    def results(self) -> Mapping[str, np.ndarray]:
        """The numbers found by the names of columns, (members, *the column's shape)."""


class MemberGroup(NamedTuple):
    """Members that run side by side; sources: text of the user's functions; file: the study's."""

    cases: Sequence[MemberCase]
    sources: Mapping[str, str]
    file: str


def make_observer(quantity: quantities.Quantity, group: MemberGroup) -> Observer:
    """The observer of a quantity. Raises InputError where it means nothing for a member."""
    for case in group.cases:
        require_measurable(quantity, case, group.file)
    if isinstance(quantity, quantities.Function):
        return _FunctionObserver(quantity, group)
    if isinstance(quantity, quantities.Trajectories):
        return _TrajectoryObserver(quantity, group.cases)
    if isinstance(quantity, quantities.RigidDeviation):
        return _DeviationObserver(quantity, group.cases)
    return _FoldObserver(quantity, group.cases)


class _FoldObserver:
    """Observer of a signal of one joint, or of all, folded over a window."""

    def __init__(self, quantity: quantities.Quantity, cases: Sequence[MemberCase]) -> None:
        self.name, self.window = quantity.result_name, getattr(quantity, "window_s", None)
        self.signal = getattr(quantity, "signal", "theta")
        self.planet = getattr(quantity, "planet", 1)
        self.joints = _joints(quantity, cases)
        self.fold, self.less = _make_fold(quantity, cases, self.joints)
        # If the last value alone counts, earlier records are skipped.
        scenario = cases[0].scenario
        late = scenario.step_s * (scenario.steps - scenario.stride / 2)
        self.after_s = late if self.fold.ends and self.window is None else -np.inf
        self.seen = 0  # records

    def observe(self, chunk: ChunkRecords) -> None:
        part = _window_slice(chunk.time, self.window)
        if part.stop > part.start and chunk.time[-1] > self.after_s:
            self.fold.take(chunk.time[part], self.values(chunk, part))
        self.seen += chunk.time.size

    def values(self, chunk: ChunkRecords, part: slice) -> np.ndarray:
        """The values that are folded, (records of the part, [joints,] members)."""
        return _signal(chunk, self.signal, self.planet)[part, self.joints]

    def results(self) -> Mapping[str, np.ndarray]:
        numbers = self.fold.numbers()
        named = zip(self.fold.parts, numbers, strict=True)
        return {self.name + part: (value - self.less).T for part, value in named}


class _DeviationObserver(_FoldObserver):
    """Observer of how far an angle gets from the rigid arm's."""

    def __init__(self, quantity: quantities.RigidDeviation, cases: Sequence[MemberCase]) -> None:
        super().__init__(quantity, cases)
        self.angles, self.whose = simulate_rigid_angles(quantity.level, cases)

    def values(self, chunk: ChunkRecords, part: slice) -> np.ndarray:
        here = slice(self.seen + part.start, self.seen + part.stop)
        rigid = np.moveaxis(self.angles[:, here][self.whose][..., self.joints], 0, -1)
        return super().values(chunk, part) - rigid


class _SignalRecorder:
    """Observer that keeps whole signals, (records, joints, [planets,] members) each."""

    def __init__(self, names: Sequence[str]) -> None:
        self.time: list[np.ndarray] = []
        self.values: dict[str, list[np.ndarray]] = {name: [] for name in names}

    def observe(self, chunk: ChunkRecords) -> None:
        self.time.append(chunk.time.copy())
        for name, pieces in self.values.items():
            pieces.append(getattr(chunk, name).copy())

    def join_signal(self, name: str, planets: Sequence[int]) -> np.ndarray:
        """A whole signal, (records, joints, [planets,] members).

        A signal of meshes is there for each of a joint's planets, also where one stands for all; it
        is nan beyond these, and where there are no meshes.
        """
        whole = np.concatenate(self.values[name])
        if whole.ndim == 3:
            return whole
        records, joints, planet_count, members = whole.shape
        signal = np.full((records, joints, max(1, *planets), members), np.nan)
        for joint, count in enumerate(planets):
            signal[:, joint, :count] = whole[:, joint, : 1 if planet_count == 1 else count]
        return signal


class _TrajectoryObserver(_SignalRecorder):
    """Observer that keeps trajectories for the result."""

    def __init__(self, quantity: quantities.Trajectories, cases: Sequence[MemberCase]) -> None:
        super().__init__(quantity.signals)
        self.prefix = f"{quantity.name}_" if quantity.name else ""
        self.planets = cases[0].planet_counts

    def results(self) -> Mapping[str, np.ndarray]:
        if not self.time:
            return {}
        return {
            self.prefix + name: np.moveaxis(self.join_signal(name, self.planets), -1, 0)
            for name in self.values
        }


class _FunctionObserver(_SignalRecorder):
    """Observer that keeps runs for a function of the user's."""

    def __init__(self, quantity: quantities.Function, group: MemberGroup) -> None:
        super().__init__(group.cases[0].signals)
        self.quantity, self.group = quantity, group

    def results(self) -> Mapping[str, np.ndarray]:
        if not self.time:
            return {}
        time, source = np.concatenate(self.time), self.group.sources[self.quantity.function]
        answers: dict[str, list[float]] = {name: [] for name in self.quantity.returns}
        planets = self.group.cases[0].planet_counts  # the same for all members of a group
        whole = {name: self.join_signal(name, planets) for name in self.values}
        whole = {name: values for name, values in whole.items() if _is_present(name, values)}
        for place, case in enumerate(self.group.cases):
            run = case.make_run(time, {name: values[..., place] for name, values in whole.items()})
            is_finite = np.isfinite(run["theta"].values).all()
            function_numbers = call_function(self.quantity, source, run) if is_finite else {}
            for name, numbers in answers.items():
                numbers.append(function_numbers.get(name, np.nan))
        return {name: np.array(numbers) for name, numbers in answers.items()}


def _make_fold(
    quantity: quantities.Quantity, cases: Sequence[MemberCase], joints: slice | int
) -> tuple[folds.Fold, np.ndarray | float]:
    """The fold of a quantity, and the value that is subtracted from its number."""
    columns = _columns(joints, cases)
    if isinstance(quantity, quantities.FinalError):
        return folds.LastFold(columns), _targets(cases)[joints]
    fold: folds.Fold
    if isinstance(quantity, quantities.Settling):
        aim = quantity.target_rad
        targets = _targets(cases)[joints] if aim is None else np.full(columns, aim)
        fold = folds.SettlingFold(targets, quantity.band_rad)
    elif isinstance(quantity, quantities.ContactLoss):
        fold = folds.FirstLossFold(columns)
    elif isinstance(quantity, quantities.NoContactShare):
        fold = folds.NoContactShareFold(columns)
    elif isinstance(quantity, quantities.BandRms):
        fold = folds.BandRmsFold(columns, *quantity.band_Hz)
    elif isinstance(quantity, quantities.SpectralPeak):
        fold = folds.LargestLineFold(columns, *quantity.band_Hz)
    elif isinstance(quantity, quantities.Crossing):
        beyond = operator.gt if quantity.side == "above" else operator.lt
        fold = folds.FirstTimeFold(columns, lambda values: beyond(values, quantity.level))
    elif isinstance(quantity, quantities.RigidDeviation):
        fold = folds.PeakFold(columns)
    else:
        assert isinstance(quantity, quantities.Size)
        sizes: dict[str, Callable[[tuple[int, ...]], folds.Fold]] = {
            "final": folds.LastFold,
            "peak": folds.PeakFold,
            "peak_to_peak": folds.RangeFold,
            "mean": partial(folds.AverageFold, squared=False),
            "rms": partial(folds.AverageFold, squared=True),
        }
        fold = sizes[quantity.kind](columns)
    return fold, 0.0


def _joints(quantity: quantities.Quantity, cases: Sequence[MemberCase]) -> slice | int:
    """Index of the joints that a quantity is of: all, or one."""
    joint = getattr(quantity, "joint", None)
    return slice(None) if joint is None else int(joint) - 1


def _columns(joints: slice | int, cases: Sequence[MemberCase]) -> tuple[int, ...]:
    if isinstance(joints, int):
        return (len(cases),)
    return len(cases[0].planet_counts), len(cases)


def _is_present(name: str, values: np.ndarray) -> bool:
    """Whether the members have a signal: it is NaN throughout where there are no such meshes."""
    return name in quantities.JOINT_SIGNALS or not np.isnan(values[0]).all()


def _targets(cases: Sequence[MemberCase]) -> np.ndarray:
    """Targets of the PD drives [rad], (joints, members)."""
    return np.array([case.targets() for case in cases]).T


def _window_slice(time: np.ndarray, window: tuple[float, float] | None) -> slice:
    return slice(0, time.size) if window is None else signals.window(time, *window)


def _signal(chunk: ChunkRecords, name: str, planet: int) -> np.ndarray:
    """A signal of a chunk, of one planet where it is a mesh's, (records, joints, members)."""
    values: np.ndarray = getattr(chunk, name)
    if name not in quantities.MESH_SIGNALS:
        return values
    if values.shape[2] == 1:
        return values[:, :, 0]
    if planet > values.shape[2]:  # none of that number, or no meshes at all
        return np.full((values.shape[0], values.shape[1], values.shape[3]), np.nan)
    return values[:, :, planet - 1]
