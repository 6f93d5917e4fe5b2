"""Many models run side by side, in the lanes of one kernel.

Models of one structure (joints, planets, laws, switches), step, duration and recording stand in
one group; what one does is bit for bit the same whichever others stand beside it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from crosscheck.analytic.kernel.batch import BLOCK_LANES, Batch, Records, SteppedModel
from crosscheck.analytic.kernel.program import RUNS
from crosscheck.models.errors import Diverged
from crosscheck.models.signal_map import SignalMap
from crosscheck.models.trajectory import recorded_times

GROUP_SIZE = 4 * BLOCK_LANES  # members of a group: a processor works on several blocks at a time
CHUNK = 2**20  # numbers of a chunk: 8 MB, beyond which a call for each no longer counts


class GroupedModel(SteppedModel, Protocol):
    """A model that others can run beside, if what signal_layout says of its signals is equal."""

    @property
    def name(self) -> str: ...

    @property
    def signal_layout(self) -> object: ...

    @property
    def signals(self) -> SignalMap: ...


ModelT = TypeVar("ModelT", bound=GroupedModel)


def _make_signal(name: str, record: str) -> cached_property[np.ndarray]:
    """The signal of a name, by the records of coordinates, rates, accelerations or forces."""
    return cached_property(lambda chunk: chunk.signals.read(name, getattr(chunk.records, record)))


@dataclass(frozen=True)
class RunChunk:
    """Consecutive records of members that ran side by side, by the names of a run's signals.

    time (records,) [s]; records: in the coordinates of the members. Of a member that has diverged
    all is NaN from the first record on that is not finite. Signals are (records, joints, members)
    in SI units, those of meshes (records, joints, planets, members), and what a joint has none of
    is NaN. Joints are all that move.
    """

    time: np.ndarray
    models: Sequence[Any]
    records: Records

    theta_dot = _make_signal("theta", "v")
    theta_ddot = _make_signal("theta", "a")
    x_sp, x_sp_dot = _make_signal("x_sp", "q"), _make_signal("x_sp", "v")
    x_pr, x_pr_dot = _make_signal("x_pr", "q"), _make_signal("x_pr", "v")
    x_mesh, x_mesh_dot = _make_signal("x_mesh", "q"), _make_signal("x_mesh", "v")
    F_sp, F_pr = _make_signal("F_sp", "forces"), _make_signal("F_pr", "forces")
    F_mesh = _make_signal("F_mesh", "forces")

    @property
    def signals(self) -> SignalMap:
        """What signals are of the records."""
        signals: SignalMap = self.models[0].signals
        return signals

    @cached_property
    def theta(self) -> np.ndarray:
        """Positions [rad], [m]; a joint that follows another with its offset."""
        theta, offsets = self.signals.read("theta", self.records.q), self.signals.offsets
        return theta + offsets[:, np.newaxis] if offsets.any() else theta

    @cached_property
    def torque(self) -> np.ndarray:
        """Driving torques (records, joints, members) [N m], [N]; 0 of followers of others."""
        torques = np.zeros_like(self.theta)
        for place, model in enumerate(self.models):
            moving = self.theta[..., place], self.theta_dot[..., place]
            torques[..., place] = self.signals.find_torques(model.drive, self.time, *moving)
        return torques


@dataclass
class Group(Generic[ModelT]):
    """Models of any kind that run side by side.

    members: their places in what was asked; level: of the kernel's optimisation; diverged_s
    (members,): after the last chunk, the time [s] of the first record that is not finite, NaN if
    there is none.
    """

    members: tuple[int, ...]
    models: Sequence[ModelT]
    lanes: int = BLOCK_LANES
    level: int = RUNS
    diverged_s: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.diverged_s = np.full(len(self.members), np.nan)

    def chunks(self) -> Iterator[RunChunk]:
        """Run the members: their chunks in the order of time, every record in one of them."""
        time = recorded_times(self.models[0].scenario)
        first = 0
        for records in self._records():
            part = time[first : first + len(records.q)]
            first += len(records.q)
            self._mark(part, records)
            yield RunChunk(part, self.models, records)

    def _records(self) -> Iterator[Records]:
        scenario = self.models[0].scenario
        batch = Batch(self.models, self.lanes, self.level)
        n = len(batch.structure.coordinates)
        most = max(1, CHUNK // (4 * n * len(self.models)))
        left = scenario.steps // scenario.stride + 1
        for records in batch.run(left - 1, scenario.stride, most):
            yield records
            left -= len(records.q)
            if left and not np.isnan(self.diverged_s).any():
                yield self._nan_records(left)
                return

    def _nan_records(self, records: int) -> Records:
        """Records, all NaN, of members that have all diverged."""
        structure = self.models[0].equations.structure
        n, meshes = len(structure.coordinates), len(structure.meshes)
        shapes = [(records, rows, len(self.models)) for rows in (n, n, n, meshes)]
        return Records(*(np.full(shape, np.nan) for shape in shapes))

    def _mark(self, time: np.ndarray, records: Records) -> None:
        """Note which members have diverged, and make their records NaN from there on."""
        q, v, a, forces = records
        # A coordinate that is not finite stays so: checking the last record is enough.
        if np.isfinite(q[-1]).all() and np.isfinite(v[-1]).all():
            return
        finite = np.isfinite(q).all(axis=1) & np.isfinite(v).all(axis=1)
        finite &= np.isnan(self.diverged_s)
        if finite.all():
            return
        for member in np.flatnonzero(~finite.all(axis=0)):
            first = int(np.argmin(finite[:, member]))
            if np.isnan(self.diverged_s[member]):
                self.diverged_s[member] = time[first]
            for values in (q, v, a, forces):
                values[first:, :, member] = np.nan


def group_models(models: Sequence[ModelT]) -> list[Group[ModelT]]:
    """Groups of any models, as few as the models fit in."""
    places_by_key: dict[object, list[int]] = {}
    for place, model in enumerate(models):
        scenario, drive = model.scenario, model.drive
        grid = scenario.step_s, scenario.steps, scenario.stride
        table = drive.table_time.tobytes(), drive.table_torque.tobytes()
        key = model.signal_layout, model.equations.structure, grid, table
        places_by_key.setdefault(key, []).append(place)
    parts = [
        tuple(places[first : first + GROUP_SIZE])
        for places in places_by_key.values()
        for first in range(0, len(places), GROUP_SIZE)
    ]
    return [Group(part, [models[place] for place in part]) for part in parts]


def run_alone(model: GroupedModel, level: int = RUNS) -> Records:
    """Records (times, ...) of one model by itself. Raises Diverged."""
    group = Group((0,), [model], lanes=1, level=level)
    parts = [chunk.records for chunk in group.chunks()]
    if not np.isnan(group.diverged_s[0]):
        raise Diverged(model.name, float(group.diverged_s[0]))
    whole = (np.concatenate(each)[:, :, 0] for each in zip(*parts, strict=True))
    return Records(*map(np.ascontiguousarray, whole))
