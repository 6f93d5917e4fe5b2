"""Whether two motions that begin next to each other part: the largest Lyapunov exponent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import tau

import numpy as np

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.audit.experiments.ensembles import EnsembleNumbers, EnsembleQuestion
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.stage import geared_joint
from crosscheck.audit.measures.undefined import float_or_none
from crosscheck.audit.phase.runs import ContinuedModel, simulate_motion
from crosscheck.models.loading import Case
from crosscheck.studies.members.starts import perturb_start

BLOCK_S = 0.005  # some seven periods of the vibration; the neighbour is then brought near again
ALIGNED = 10  # blocks in which the separation turns into the direction that grows fastest
NEAR_M = 1e-9  # far below a mesh's deflection of 1e-5 m, far above rounding
MESH_HZ = 1500.0  # turns rates into lengths: of the paper's vibration


@dataclass(frozen=True)
class LyapunovQuestion(EnsembleQuestion[EnsembleNumbers]):
    """A question: growth rates in the third fluctuation by Benettin's method, neighbours kept near.

    lyapunov_per_s [1/s]: mean rate at which the separation grows, positive where motions that begin
    next to each other part exponentially.
    """

    @property
    def cost(self) -> float:
        return 2 * super().cost

    def answer(self) -> EnsembleNumbers:
        case = self.variant.case()
        begin_s, end_s = (min(limit, case.scenario.duration_s) for limit in THIRD_S)
        models = [PhysicalModel(*_cut(perturb_start(case, seed), begin_s)) for seed in self.seeds]
        trajectory = simulate_motion(models)
        rates = _growth_rates(
            _cut(case, BLOCK_S), trajectory.q[-1].T, trajectory.v[-1].T, (begin_s, end_s)
        )
        numbers = {"lyapunov_per_s": [float_or_none(rate) for rate in rates]}
        return EnsembleNumbers(numbers, [None] * len(self.seeds), len(self.seeds))


def _cut(case: Case, duration_s: float) -> Case:
    """The experiment cut to this duration, with its first and last states alone recorded."""
    scenario = case.scenario.model_copy(update={"duration_s": duration_s})
    once = scenario.model_copy(update={"record_every": scenario.steps})
    return case._replace(scenario=once)


def _growth_rates(
    block: Case, q: np.ndarray, v: np.ndarray, span_s: tuple[float, float]
) -> Sequence[float]:
    """Mean growth rates [1/s] of the separation from motions at states q, v (members, n).

    nan without a block after ALIGNED.
    """
    model = PhysicalModel(*block)
    radius_m = 2 * stage_geometry(geared_joint(model.arm)).r_cp
    lengths = np.where(model.layout.angular, radius_m, 1.0)  # along the line of action, (n,)
    scale = np.array([1.0, 1 / (tau * MESH_HZ)])[:, None] * lengths  # of coordinates and of rates
    models = [ContinuedModel(block, *state) for state in [*zip(q, v, strict=True)] * 2]
    away = np.zeros((len(q), 2, q.shape[1]))
    away[:, 0] = NEAR_M / lengths / np.sqrt(q.shape[1])
    folds = []
    blocks = round((span_s[1] - span_s[0]) / BLOCK_S)
    for number in range(blocks):
        near = zip(q + away[:, 0], v + away[:, 1], strict=True)
        for model, state in zip(models, [*zip(q, v, strict=True), *near], strict=True):
            model.state = state  # built once: that takes longer than a block's run
        trajectory = simulate_motion(models, span_s[0] + number * BLOCK_S)
        (q, near_q), (v, near_v) = (
            np.split(last[-1].T, 2) for last in (trajectory.q, trajectory.v)
        )
        away = np.stack([near_q - q, near_v - v], axis=1)
        in_metres = (away * scale).reshape(len(away), -1)
        grown = np.linalg.norm(in_metres, axis=1) / NEAR_M
        folds.append(np.log(grown))
        away /= grown[:, None, None]
    if blocks <= ALIGNED:
        return [np.nan] * len(q)
    mean: np.ndarray = np.mean(folds[ALIGNED:], axis=0) / BLOCK_S
    return list(map(float, mean))
