"""A start in a hundred or so at the smallest damping runs away: the printed law lets it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.audit.experiments.cells import INTEGRAL, PRINTED, Cell, Law
from crosscheck.audit.experiments.experiments import PD, question
from crosscheck.audit.experiments.pool import Sample
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.starts import TransientPd
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.measures.course import Course
from crosscheck.audit.measures.shares import Share

ZETA = 0.003
LAWS = (PRINTED, INTEGRAL)
STARTS, AT_ONCE = 256, 32
FAST_RAD_PER_S = 10.0  # ten times what the controller ever asks for


class TopSpeed(TransientPd):
    """Of either joint [rad/s], over the whole run."""

    def numbers(self, run: Course, rigid: tuple[Course, ...]) -> Numbers:
        return {
            "top_rad_per_s": float(np.abs(run.theta_dot).max()),
            "asked_rad_per_s": float(np.abs(rigid[0].theta_dot).max()),
        }


@dataclass(frozen=True)
class Runaway:
    """Starts of a law: how many run away or diverge; top speeds [rad/s] of those that run away.

    calm_rad_per_s: the largest top speed of the others; asked_rad_per_s: the rigid arm's.
    """

    law: Law
    share: Share
    diverged: int
    top_rad_per_s: tuple[float, ...]
    calm_rad_per_s: float
    asked_rad_per_s: float


def runaways(study: Study, scale: Scale) -> list[Runaway]:
    """Many starts of 3 s with free planets."""
    count = scale.starts(STARTS) if scale.most_starts < AT_ONCE else STARTS
    seeds = range(scale.first_seed, scale.first_seed + count)
    parts = [tuple(seeds[k : k + AT_ONCE]) for k in range(0, count, AT_ONCE)]
    wanted = [(law, part) for law in LAWS for part in parts]
    asked = [_asked(law, part, scale) for law, part in wanted]
    found = study.answers(asked, "phase: runaways")
    samples = [(law, Sample.of(one)) for (law, _), one in zip(wanted, found, strict=True)]
    return [_runaway(law, [sample for own, sample in samples if own == law]) for law in LAWS]


def _asked(law: Law, seeds: tuple[int, ...], scale: Scale) -> TopSpeed:
    variant = question(PD, Cell(law, ZETA), ()).variant
    return TopSpeed(scale.cut(variant), seeds)


def _runaway(law: Law, samples: list[Sample]) -> Runaway:
    top = np.concatenate([sample["top_rad_per_s"] for sample in samples])
    asked = np.concatenate([sample["asked_rad_per_s"] for sample in samples])
    fast = top[top > FAST_RAD_PER_S]
    diverged = int(np.isnan(top).sum())
    calm = top[top <= FAST_RAD_PER_S]
    return Runaway(
        law,
        Share(int(fast.size) + diverged, int(top.size)),
        diverged,
        tuple(map(float, np.sort(fast))),
        float(calm.max()) if calm.size else np.nan,
        float(asked[np.isfinite(asked)].max()) if diverged < top.size else np.nan,
    )
