"""Observers that watch members chunk after chunk, and give a study's quantities in the end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from crosscheck import signals
from crosscheck.analytic.ensemble import group_models
from crosscheck.mechanisms import supply
from crosscheck.models.experiment.scenario import Scenario, Start
from crosscheck.studies.definition import quantities
from crosscheck.studies.definition.functions import call_function
from crosscheck.studies.measures import folds
from crosscheck.studies.measures.columns import require_measurable
from crosscheck.studies.members.cases import MemberCase
from crosscheck.studies.members.members import PreparedStudy

STEP_RATIO = 10  # steps of the geared arm in one of the rigid arm, which is smooth


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


def make_observer(
    quantity: quantities.Quantity, cases: Sequence[MemberCase], study: PreparedStudy
) -> Observer:
    """The observer of a study's quantity. Raises InputError where it means nothing for a member."""
    for case in cases:
        require_measurable(quantity, case, study.file)
    if isinstance(quantity, quantities.Function):
        return _FunctionObserver(quantity, cases, study.sources[quantity.function])
    if isinstance(quantity, quantities.Trajectories):
        return _TrajectoryObserver(quantity, cases)
    if isinstance(quantity, quantities.RigidDeviation):
        return _DeviationObserver(quantity, cases)
    return _FoldObserver(quantity, cases)


class _FoldObserver:
    """Observer of a signal of one joint, or of all, folded over a window."""

    def __init__(self, quantity: quantities.Quantity, cases: Sequence[MemberCase]) -> None:
        self.name, self.window = quantity.result_name, getattr(quantity, "window_s", None)
        self.signal = getattr(quantity, "signal", "theta")
        self.planet = getattr(quantity, "planet", 1)
        joint = getattr(quantity, "joint", None)
        self.joints = slice(None) if joint is None else joint - 1
        self.fold = _make_fold(quantity, cases, self.joints)
        # If the last value alone counts, earlier records are skipped.
        scenario = cases[0].scenario
        late = scenario.step_s * (scenario.steps - scenario.stride / 2)
        self.after_s = late if self.fold.ends and self.window is None else -np.inf
        self.seen = 0  # records

    def observe(self, chunk: ChunkRecords) -> None:
        window = (0.0, np.inf) if self.window is None else self.window
        part = signals.window(chunk.time, *window)
        if part.stop > part.start and chunk.time[-1] > self.after_s:
            self.fold.take(chunk.time[part], self.values(chunk, part))
        self.seen += chunk.time.size

    def values(self, chunk: ChunkRecords, part: slice) -> np.ndarray:
        """The values that are folded, (records of the part, [joints,] members)."""
        return _signal(chunk, self.signal, self.planet)[part, self.joints]

    def results(self) -> Mapping[str, np.ndarray]:
        numbers = self.fold.numbers()
        named = zip(self.fold.parts, numbers, strict=True)
        return {self.name + part: value.T for part, value in named}


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
        return {
            self.prefix + name: np.moveaxis(self.join_signal(name, self.planets), -1, 0)
            for name in self.values
        }


class _FunctionObserver(_SignalRecorder):
    """Observer that keeps runs for a function of the user's."""

    def __init__(
        self, quantity: quantities.Function, cases: Sequence[MemberCase], source: str
    ) -> None:
        super().__init__(cases[0].signals)
        self.quantity, self.cases, self.source = quantity, cases, source

    def results(self) -> Mapping[str, np.ndarray]:
        time = np.concatenate(self.time)
        answers: dict[str, list[float]] = {name: [] for name in self.quantity.returns}
        planets = self.cases[0].planet_counts  # the same for all members of a group
        whole = {name: self.join_signal(name, planets) for name in self.values}
        for name in set(whole) - set(quantities.JOINT_SIGNALS):
            if np.isnan(whole[name][0]).all():  # of meshes that are not there
                del whole[name]
        for place, case in enumerate(self.cases):
            single = {name: values[..., place] for name, values in whole.items()}
            run = supply("make_member_run", case.mechanism.section)(case, time, single)
            is_finite = np.isfinite(run["theta"].values).all()
            function_numbers = call_function(self.quantity, self.source, run) if is_finite else {}
            for name, numbers in answers.items():
                numbers.append(function_numbers.get(name, np.nan))
        return {name: np.array(numbers) for name, numbers in answers.items()}


def _make_fold(
    quantity: quantities.Quantity, cases: Sequence[MemberCase], joints: slice | int
) -> folds.Fold:
    """The fold of a quantity of these joints: all, or one."""
    # (joints, members), or (members,) of one joint
    columns = np.empty((len(cases[0].planet_counts), len(cases)))[joints].shape
    match quantity:
        case quantities.FinalError():
            return folds.LastFold(columns, _targets(cases)[joints])
        case quantities.Settling(target_rad=None):
            return folds.SettlingFold(_targets(cases)[joints], quantity.band_rad)
        case quantities.Settling():
            return folds.SettlingFold(np.full(columns, quantity.target_rad), quantity.band_rad)
        case quantities.ContactLoss():
            return folds.FirstLossFold(columns)
        case quantities.NoContactShare():
            return folds.NoContactShareFold(columns)
        case quantities.BandRms():
            return folds.SpectrumFold(columns, signals.band_rms, quantity.band_Hz)
        case quantities.SpectralPeak():
            parts = "_frequency", "_amplitude"
            return folds.SpectrumFold(columns, signals.largest_line, quantity.band_Hz, parts)
        case quantities.Crossing(side="above"):
            return folds.FirstTimeFold(columns, lambda values: values > quantity.level)
        case quantities.Crossing():
            return folds.FirstTimeFold(columns, lambda values: values < quantity.level)
        case quantities.Size(kind="final"):
            return folds.LastFold(columns)
        case quantities.Size(kind="peak_to_peak"):
            return folds.RangeFold(columns)
        case quantities.Size(kind="mean" | "rms"):
            return folds.AverageFold(columns, squared=quantity.kind == "rms")
        case _:
            return folds.PeakFold(columns)


def _targets(cases: Sequence[MemberCase]) -> np.ndarray:
    """Targets of the PD drives [rad], (joints, members)."""
    return np.array([case.targets() for case in cases]).T


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
