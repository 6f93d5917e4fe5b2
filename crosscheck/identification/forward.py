"""Runs of a model from a record's states under its torques: how long they stay with the record.

In the terms of ASME V&V 20: E = S - D, the simulation less the data; u_num, from steps half as
long; u_input, from the start, the torques and the stated tolerances of the mechanism; u_D, of the
smoothed angles. All are standard uncertainties, in quadrature u_val.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, CubicHermiteSpline

from crosscheck.identification.mechanism import ComparedMechanism, RigidLevel
from crosscheck.models.experiment.scenario import Start, TableDrive
from crosscheck.models.loading import make_rest_scenario
from crosscheck.models.robot.robot import remove_friction
from crosscheck.recordings.record import Record
from crosscheck.recordings.smoothing import DEGREE, Block, select_spacing, smooth_record

MOST_WINDOWS = 10
COVERED, LEFT = 2.0, 3.0  # of u_val: for 95 % of rows, and for the first row that is outside
DRAWS = 32  # draws of the noise of the start and the torques
LONGEST_ROWS = 20_000  # rows of a window
STEPS = 1000  # least steps in a window: the record's torques are lines between its rows


@dataclass(frozen=True)
class Window:
    """One run of a model from a state of the record.

    time (rows,) [s] of the record; error E and the uncertainties (rows, joints) [rad or m].
    """

    time: np.ndarray
    error: np.ndarray
    numerical: np.ndarray
    inputs: np.ndarray
    data: np.ndarray

    @property
    def validation(self) -> np.ndarray:
        """Validation uncertainty u_val, shape (rows, joints) [rad or m]."""
        return np.sqrt(self.numerical**2 + self.inputs**2 + self.data**2)

    @property
    def stays_s(self) -> float:
        """The time for which every joint stays within 3 u_val of the record [s]."""
        outside = (np.abs(self.error) > LEFT * self.validation).any(axis=1)
        last = int(np.argmax(outside)) if outside.any() else len(self.time) - 1
        return float(self.time[last] - self.time[0])

    @property
    def within(self) -> float:
        """Share of the rows and joints at which |E| is at most 2 u_val; 95 % by noise alone."""
        return float((np.abs(self.error) <= COVERED * self.validation).mean())


Friction = Callable[[np.ndarray], np.ndarray]  # estimated friction at rates (rows, n)


def run_windows(
    records: Sequence[tuple[Record, np.ndarray]],
    mechanism: ComparedMechanism,
    level: str,
    tolerances: Mapping[str, float],
    friction: Friction | None = None,
) -> Iterator[Window]:
    """At most ten runs, evenly over the records, each inside a block of its smoothing.

    Args:
        records: Each with its torques (rows, n).
        tolerances: Relative standard uncertainties of parameters, by path.
        friction: In place of the files': along the record's rates it is taken from the torques.
    """
    stated = {parameter.path: parameter.value for parameter in mechanism.parameters}
    changes = [{path: stated[path] * (1 + share)} for path, share in tolerances.items()]
    levels = [each.find_level(level) for each in (mechanism, *map(mechanism.change, changes))]
    if friction is not None:
        levels = [each._replace(robot=remove_friction(each.robot)) for each in levels]
    each_most = max(MOST_WINDOWS // len(records), 1)
    for record, torques in records[:MOST_WINDOWS]:
        for block in smooth_record(record, torques, select_spacing(record), each_most):
            window = _run_window(block, levels, friction)
            if window is not None:
                yield window


def _run_window(
    block: Block, levels: Sequence[RigidLevel], friction: Friction | None
) -> Window | None:
    """A run at a level, the first one; the others have its numbers at the ends of tolerances."""
    base, *others = levels
    time = (block.time - block.time[0])[:LONGEST_ROWS]
    rows, joints = time.size, block.position.shape[1]
    # The ends of a spline are its least certain part: windows begin and end inside.
    edge = rows // 8
    inner = slice(edge, rows - edge)
    clock, torques = time[inner] - time[edge], block.torques[:rows][inner]
    if friction is not None:
        torques = torques - friction(block.rates[:rows][inner])
    start = block.position[edge], block.rates[edge]
    of_data, of_start = _compute_state_noise(block, inner, edge)
    rng = np.random.default_rng(0)

    cases = [(base, start, torques)]
    # Together, since a motion that swings through may double one error by another.
    for _ in range(DRAWS):
        q, v = (
            each + noise * rng.normal(size=joints)
            for each, noise in zip(start, of_start, strict=True)
        )
        cases.append((base, (q, v), torques + block.torque_noise * rng.normal(size=torques.shape)))
    # Torques are taken for lines between rows; their mean is off by a twelfth of what they bend.
    curved = torques.copy()
    curved[1:-1] -= np.diff(torques, 2, axis=0) / 12
    cases.append((base, start, curved))
    cases += [(other, start, torques) for other in others]
    steps = max(clock.size - 1, STEPS)
    runs = _run_cases(cases, clock, steps)
    (finer,) = _run_cases(cases[:1], clock, 2 * steps)
    first = runs[0]
    if first is None or finer is None:
        return None
    moved_by = [np.zeros_like(first) if run is None else run - first for run in runs[1:]]
    noise = sum(each**2 for each in moved_by[:DRAWS]) / DRAWS
    inputs = np.sqrt(noise + sum(each**2 for each in moved_by[DRAWS:]))
    error = finer - block.position[:rows][inner]
    numerical = np.abs(first - finer)
    return Window(block.time[:rows][inner], error, numerical, inputs, of_data)


def _compute_state_noise(
    block: Block, inner: slice, edge: int
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Standard deviations of the smoothed positions (rows, n), and of the start's q and v."""
    noise, inverse = block.position_noise, np.linalg.inv(block.gram)

    def spread(basis: np.ndarray) -> np.ndarray:
        return np.sqrt(np.einsum("rk,kl,rl->r", basis, inverse, basis))

    positions = spread(block.basis[inner].toarray())
    splines = BSpline(block.knots, np.eye(len(inverse)), DEGREE)
    slope = spread(splines(block.time[[edge]], nu=1))[0]
    return positions[:, None] * noise, (positions[0] * noise, slope * noise)


RunRequest = tuple[RigidLevel, tuple[np.ndarray, np.ndarray], np.ndarray]


def _run_cases(
    cases: Sequence[RunRequest], clock: np.ndarray, steps: int
) -> list[np.ndarray | None]:
    """Positions (rows, n) at the record's rows, of each case; None where a run diverges."""
    from crosscheck.analytic.ensemble import group_models
    from crosscheck.analytic.robot.runs import RobotMember

    duration, rest, members = float(clock[-1]), make_rest_scenario(), []
    length = {"duration_s": duration, "step_s": duration / steps, "record_every": 1}
    for level, (q, v), torques in cases:
        drive = TableDrive.model_construct(
            kind="table", time_s=tuple(clock), torque_N_m=tuple(map(tuple, torques.T))
        )
        start = Start(theta_rad=tuple(map(float, q)), theta_dot_rad_per_s=tuple(map(float, v)))
        scenario = rest.model_copy(update={**length, "start": start, "drive": drive})
        members.append(RobotMember(level.robot, level.level, scenario))
    paths: list[np.ndarray | None] = [None] * len(cases)
    free = len(cases[0][0].robot.coordinates)
    for group in group_models(members):
        chunks = list(group.chunks())
        times = np.concatenate([chunk.time for chunk in chunks])
        at = np.minimum(clock, times[-1])
        for lane, place in enumerate(group.members):
            if np.isnan(group.diverged_s[lane]):
                q, v = (
                    np.concatenate([chunk.records[part][:, :free, lane] for chunk in chunks])
                    for part in range(2)
                )
                paths[place] = CubicHermiteSpline(times, q, v)(at)
    return paths
