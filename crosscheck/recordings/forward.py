"""Runs of a model from a record's states under its torques: how long they stay with the record.

In the terms of ASME V&V 20: E = S - D, the simulation less the data; u_num, from steps half as
long; u_input, from the start, the torques and the stated tolerances of the arm; u_D, of the
smoothed angles. All are standard uncertainties, in quadrature u_val.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.scenario import Scenario, Start, TableDrive
from crosscheck.recordings.parameters import change_parameters, find_parameters
from crosscheck.recordings.smoothing import Block, select_evenly
from crosscheck.registry import build, load_model_class

MOST_WINDOWS = 10
COVERED, LEFT = 2.0, 3.0  # of u_val: for 95 % of rows, and for the first row that is outside
DRAWS = 8  # of the torques' noise
LONGEST_ROWS = 20_000  # of a window
STEPS = 1000  # in a window, at least: the record's torques are lines between its rows


@dataclass(frozen=True)
class Window:
    """One run of a model from a state of the record.

    time (rows,) [s] of the record; error E and the uncertainties (rows, joints) [rad].
    """

    time: np.ndarray
    error: np.ndarray
    numerical: np.ndarray
    inputs: np.ndarray
    data: np.ndarray

    @property
    def validation(self) -> np.ndarray:
        """Validation uncertainty u_val, shape (rows, joints) [rad]."""
        return np.sqrt(self.numerical**2 + self.inputs**2 + self.data**2)

    @property
    def stays_s(self) -> float:
        """How long every joint stays within 3 u_val of the record [s]."""
        outside = (np.abs(self.error) > LEFT * self.validation).any(axis=1)
        last = int(np.argmax(outside)) if outside.any() else len(self.time) - 1
        return float(self.time[last] - self.time[0])

    @property
    def within(self) -> float:
        """Share of the rows and joints at which |E| is at most 2 u_val; 95 % by noise alone."""
        return float((np.abs(self.error) <= COVERED * self.validation).mean())


def run_windows(
    blocks: Sequence[Block], arm: Arm, level: str, tolerances: Mapping[str, float]
) -> Iterator[Window]:
    """At most ten runs, evenly over the record, each inside a block of its smoothing.

    tolerances: relative standard uncertainties of parameters, by path.
    """
    for block in select_evenly(blocks, MOST_WINDOWS):
        window = _run_window(block, arm, level, tolerances)
        if window is not None:
            yield window


def _run_window(
    block: Block, arm: Arm, level: str, tolerances: Mapping[str, float]
) -> Window | None:
    time = (block.time - block.time[0])[:LONGEST_ROWS]
    rows, joints = time.size, block.angles.shape[1]
    # The ends of a spline are its least certain part: windows begin and end inside.
    edge = rows // 8
    inner = slice(edge, rows - edge)
    clock, torques = time[inner] - time[edge], block.torques[:rows][inner]
    start = block.angles[edge], block.rates[edge]
    of_data, of_start = _state_noise(block, inner, edge)
    rng = np.random.default_rng(0)

    cases = [(arm, start, torques)]
    for joint in range(joints):
        for part in range(2):
            moved = [each.copy() for each in start]
            moved[part][joint] += of_start[part][joint]
            cases.append((arm, (moved[0], moved[1]), torques))
    cases += [
        (arm, start, torques + block.torque_noise * rng.normal(size=torques.shape))
        for _ in range(DRAWS)
    ]
    stated = {parameter.path: parameter.value for parameter in find_parameters(arm)}
    cases += [
        (change_parameters(arm, {path: stated[path] * (1 + share)}), start, torques)
        for path, share in tolerances.items()
    ]
    steps = max(clock.size - 1, STEPS)
    runs = _run_cases(level, cases, clock, steps)
    (finer,) = _run_cases(level, cases[:1], clock, 2 * steps)
    first = runs[0]
    if first is None or finer is None:
        return None
    moved_by = [np.zeros_like(first) if run is None else run - first for run in runs[1:]]
    drawn = slice(2 * joints, 2 * joints + DRAWS)
    noise = sum(each**2 for each in moved_by[drawn]) / DRAWS
    rest = [*moved_by[: 2 * joints], *moved_by[drawn.stop :]]
    inputs = np.sqrt(noise + sum(each**2 for each in rest))
    error = finer - block.angles[:rows][inner]
    numerical = np.abs(first - finer)
    return Window(block.time[:rows][inner], error, numerical, inputs, of_data)


def _state_noise(
    block: Block, inner: slice, edge: int
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Standard deviations of the smoothed angles (rows, joints), and of the start's q and v."""
    inverse = np.linalg.inv(block.gram)

    def spread(basis: np.ndarray) -> np.ndarray:
        return np.sqrt(np.einsum("rk,kl,rl->r", basis, inverse, basis))

    angles = spread(block.bases[0][inner].toarray())
    slope = spread(block.bases[1][[edge]].toarray())[0]
    noise = block.angle_noise
    return angles[:, None] * noise, (angles[0] * noise, slope * noise)


RunRequest = tuple[Arm, tuple[np.ndarray, np.ndarray], np.ndarray]


def _run_cases(
    level: str, cases: Sequence[RunRequest], clock: np.ndarray, steps: int
) -> list[np.ndarray | None]:
    """Angles (rows, joints) at the record's rows, of each case; None where a run diverges."""
    name = f"analytic:{level}"
    duration = float(clock[-1])
    models = []
    for arm, (q, v), torques in cases:
        drive = TableDrive.model_construct(
            kind="table", time_s=tuple(clock), torque_N_m=tuple(map(tuple, torques.T))
        )
        start = Start(theta_rad=tuple(map(float, q)), theta_dot_rad_per_s=tuple(map(float, v)))
        scenario = Scenario.model_construct(
            schema_version=1,
            name="window",
            title="",
            duration_s=duration,
            step_s=duration / steps,
            record_every=1,
            start=start,
            drive=drive,
        )
        models.append(build(name, arm, scenario))
    paths: list[np.ndarray | None] = []
    for run in load_model_class(name).simulate_together(models):
        if isinstance(run, Diverged):
            paths.append(None)
            continue
        path = CubicHermiteSpline(run["time"].values, run["theta"].values, run["theta_dot"].values)
        paths.append(path(np.minimum(clock, run["time"].values[-1])))
    return paths
