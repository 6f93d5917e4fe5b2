"""Whether two motions that begin next to each other part: the largest Lyapunov exponent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import tau

import numpy as np

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.analytic.paper.model import PrintedModel
from crosscheck.audit.experiments.ensembles import EnsembleNumbers, EnsembleQuestion
from crosscheck.audit.experiments.motion import (
    ContinuedModel,
    ContinuedPrintedModel,
    simulate_motion,
)
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.stage import geared_joint
from crosscheck.audit.measures.undefined import float_or_none
from crosscheck.models.loading import Case
from crosscheck.studies.members.starts import perturb_start

BLOCK_S = 0.005  # some seven periods of the vibration; the neighbour is then brought near again
ALIGNED = 10  # blocks in which the separation turns into the direction that grows fastest
NEAR_M = 1e-9  # far below a mesh's deflection of 1e-5 m, far above rounding
# By name, a model from the experiment's start and from any state.
MODELS: dict[
    str, tuple[type[PhysicalModel | PrintedModel], type[ContinuedModel | ContinuedPrintedModel]]
] = {
    PhysicalModel.name: (PhysicalModel, ContinuedModel),
    PrintedModel.name: (PrintedModel, ContinuedPrintedModel),
}
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
        model_class, continued_class = MODELS[self.variant.model]
        starts = [_cut(perturb_start(case, seed), begin_s) for seed in self.seeds]
        trajectory = simulate_motion([model_class(*start) for start in starts])
        states = zip(trajectory.q[-1].T, trajectory.v[-1].T, strict=True)
        models = [continued_class(_cut(case, BLOCK_S), *state) for state in [*states] * 2]
        rates = _growth_rates(models, (begin_s, end_s))
        numbers = {"lyapunov_per_s": [float_or_none(rate) for rate in rates]}
        return EnsembleNumbers(numbers, [None] * len(self.seeds), len(self.seeds))


def _cut(case: Case, duration_s: float) -> Case:
    """The experiment cut to this duration, with its first and last states alone recorded."""
    scenario = case.scenario.model_copy(update={"duration_s": duration_s})
    once = scenario.model_copy(update={"record_every": scenario.steps})
    return case._replace(scenario=once)


def _growth_rates(
    models: Sequence[ContinuedModel | ContinuedPrintedModel], span_s: tuple[float, float]
) -> Sequence[float]:
    """Mean growth rates [1/s] of the separation from motions at the states of half the models.

    Each runs one block; the second half runs the neighbours. nan without a block after ALIGNED.
    """
    model = models[0]
    q, v = np.swapaxes([model.state for model in models[: len(models) // 2]], 0, 1)
    radius_m = 2 * stage_geometry(geared_joint(model.arm)).r_cp
    lengths = np.where(model.layout.angular, radius_m, 1.0)  # along the line of action, (n,)
    scale = np.array([1.0, 1 / (tau * MESH_HZ)])[:, None] * lengths  # of coordinates and of rates
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
