"""Many models run side by side, in the lanes of one kernel.

Models of one structure (joints, planets, laws, switches), step, duration and recording stand in
one group; what one does is bit for bit the same whichever others stand beside it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

import numpy as np

from crosscheck.analytic.kernel.batch import BLOCK_LANES, Batch, Records, SteppedModel
from crosscheck.analytic.kernel.program import RUNS
from crosscheck.models.arm.layout import Meaning
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.drive import torques_along
from crosscheck.models.trajectory import recorded_times

if TYPE_CHECKING:
    from crosscheck.analytic.model import AnalyticModel

GROUP_SIZE = 4 * BLOCK_LANES  # members of a group: a processor works on several blocks at a time
CHUNK = 2**20  # numbers of a chunk: 8 MB, beyond which a call for each no longer counts


class GroupedModel(SteppedModel, Protocol):
    """A model that others can run beside; signal_layout: what of its signals' shapes is equal."""

    @property
    def name(self) -> str: ...

    @property
    def signal_layout(self) -> object: ...

    @property
    def chunk_class(self) -> type[RunChunk]: ...


ModelT = TypeVar("ModelT", bound=GroupedModel)


def _make_joint_signal(record: str) -> cached_property[np.ndarray]:
    """The signal of the joints' coordinates, rates or accelerations, as the records have them."""
    return cached_property(lambda chunk: chunk._joint_values(getattr(chunk.records, record)))


def _make_mesh_signal(mesh: Meaning, record: str) -> cached_property[np.ndarray]:
    """The signal of the displacements [m] of sun or ring meshes, or of their rates [m/s]."""
    return cached_property(lambda chunk: chunk._displacements(mesh, getattr(chunk.records, record)))


@dataclass(frozen=True)
class RunChunk(ABC):
    """Consecutive records of members that ran side by side, by the names of a run's signals.

    time (records,) [s]; records: in the coordinates of the members. Of a member that has diverged
    all is NaN from the first record on that is not finite. Signals are (records, joints, members)
    in SI units, those of meshes (records, joints, planets, members): lumped, one planet stands for
    all, and what a joint has none of is NaN.
    """

    time: np.ndarray
    models: Sequence[Any]
    records: Records

    theta = _make_joint_signal("q")
    theta_dot = _make_joint_signal("v")
    theta_ddot = _make_joint_signal("a")
    x_sp = _make_mesh_signal("x_sp", "q")
    x_pr = _make_mesh_signal("x_pr", "q")
    x_sp_dot = _make_mesh_signal("x_sp", "v")
    x_pr_dot = _make_mesh_signal("x_pr", "v")

    @cached_property
    def F_sp(self) -> np.ndarray:
        """Elastic force of sun meshes per planet [N]."""
        return self._forces(0)

    @cached_property
    def F_pr(self) -> np.ndarray:
        """Elastic force of ring meshes per planet [N]."""
        return self._forces(1)

    @cached_property
    def torque(self) -> np.ndarray:
        """Driving torques (records, joints, members) [N m], [N]; 0 of followers of others."""
        free, torques = list(self._free_joints), np.zeros_like(self.theta)
        for place, model in enumerate(self.models):
            moving = self.theta[:, free, place], self.theta_dot[:, free, place]
            torques[:, free, place] = torques_along(model.drive, self.time, *moving)
        return torques

    @property
    @abstractmethod
    def _free_joints(self) -> Sequence[int]:
        """Numbers of the joints that follow no other."""

    @abstractmethod
    def _joint_values(self, x: np.ndarray) -> np.ndarray:
        """Rows of the joints (records, joints, members) of the coordinates x, or rates."""

    @abstractmethod
    def _displacements(self, mesh: Meaning, x: np.ndarray) -> np.ndarray:
        """Displacements of all planets' teeth at sun or ring, or their rates, from x or x'."""

    @abstractmethod
    def _forces(self, side: int) -> np.ndarray:
        """Elastic forces of all planets with sun (0) or ring (1)."""


class Chunk(RunChunk):
    """Records of arms."""

    models: Sequence[AnalyticModel]

    @property
    def _free_joints(self) -> Sequence[int]:
        return range(len(self.models[0].arm.joints))

    def _joint_values(self, x: np.ndarray) -> np.ndarray:
        return x[:, self.models[0].layout.theta]

    def _forces(self, side: int) -> np.ndarray:
        return self._planet_values(self.records.forces[:, side::2])

    def _displacements(self, mesh: Meaning, x: np.ndarray) -> np.ndarray:
        layout = self.models[0].layout
        if not layout.free:
            return self._planet_values(x[:, layout.indices(mesh)])
        x_pr = x[:, layout.indices("x_pr")]
        if mesh == "x_pr":
            return self._planet_values(x_pr)
        x_s = x[:, np.repeat(layout.indices("x_s"), self._planet_counts())]
        return self._planet_values(x_s - x_pr)

    def _planet_counts(self) -> list[int]:
        """Number of planets that have coordinates, for each joint with meshes; 1 if lumped."""
        layout, joints = self.models[0].layout, self.models[0].arm.joints
        return [joints[joint].planet_count if layout.free else 1 for joint in layout.mesh_joints]

    def _planet_values(self, values: np.ndarray) -> np.ndarray:
        """Values (records, meshes of one kind, members) as (records, joints, planets, members).

        A view where all joints have as many planets; else NaN where a joint has no such planet.
        """
        layout, joints = self.models[0].layout, len(self.models[0].arm.joints)
        counts = self._planet_counts()
        if len(counts) == joints and len(set(counts)) == 1:
            return values.reshape(len(values), joints, counts[0], values.shape[2])
        padded_values = np.full(
            (len(values), joints, max(counts, default=0), values.shape[2]), np.nan
        )
        first = 0
        for joint, count in zip(layout.mesh_joints, counts, strict=True):
            padded_values[:, joint, :count] = values[:, first : first + count]
            first += count
        return padded_values


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
            yield self.models[0].chunk_class(part, self.models, records)

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
