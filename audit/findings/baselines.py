"""Which rigid arm Figs. 6 and 7 compare with: what each of them leaves, by the claims' answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from crosscheck.audit.claims.catalogue import BY_ID, model_of
from crosscheck.audit.experiments.paper_conditions import (
    AS_MODELLED,
    DAMPING,
    LABELLED,
    READING,
    READINGS,
)
from crosscheck.audit.experiments.variant import COUPLED
from crosscheck.audit.figures.figure_data import ZETA
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.rule import Answer, State
from crosscheck.audit.measures.undefined import extreme_value, quotient
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, to_svg

THETA_1, THETA_2, TIP = "3.1-01", "3.1-02", "3.1-04"  # what Section 3.1 says of Fig. 6
LABELS = {THETA_1: "θ₁ [rad]", THETA_2: "θ₂ [rad]", TIP: "tip [mm]"}
LEVELS = {
    "links": "links, payload",
    "carriers": "links, payload, joint masses",
    "armature": "these, reflected inertia",
    COUPLED: "these, its coupling",
}
FEW = 0.1  # of a deviation: nearly all is something else


@dataclass(frozen=True)
class RigidResidual:
    """What a rigid level leaves of the printed equations' motion: answers by claim of LABELS."""

    arm: str
    level: str
    answers: Mapping[str, Answer]

    def size(self, claim: str) -> float:
        """The median of a deviation, in the claim's unit; nan if undefined."""
        median = self.answers[claim].median
        return np.nan if median is None else median

    def is_papers(self, claim: str) -> bool:
        """Whether a deviation is what the paper says."""
        return self.answers[claim].state == State.YES


@dataclass(frozen=True)
class BaselineFinding:
    """What every rigid arm leaves under constant torque, in every reading."""

    residuals: tuple[RigidResidual, ...]

    @property
    def fitting(self) -> tuple[RigidResidual, ...]:
        """Those of levels that leave the paper's theta_2 in all readings."""
        failing = {each.level for each in self.residuals if not each.is_papers(THETA_2)}
        return tuple(each for each in self.residuals if each.level not in failing)

    @property
    def nearest(self) -> RigidResidual | None:
        """The first that leaves the paper's theta_2, labelled reading, if one does."""
        labelled = (each for each in self.residuals if each.arm == LABELLED)
        return next((each for each in labelled if each.is_papers(THETA_2)), None)

    @property
    def gives_all(self) -> bool:
        """Whether one rigid arm leaves all of the paper's numbers."""
        return any(all(map(each.is_papers, LABELS)) for each in self.residuals)

    @property
    def most_meshes(self) -> float:
        """Largest share of the meshes in what the fitting levels leave; nan without any.

        The meshes' is what the rigid arm leaves that has all that the gears bring along rigidly.
        """
        last = {each.arm: each for each in self.residuals if each.level == COUPLED}
        return extreme_value(
            (
                quotient(last[each.arm].size(claim), each.size(claim))
                for each, claim in product(self.fitting, LABELS)
            ),
            max,
        )

    @property
    def is_inertia(self) -> bool | None:
        """Whether nearly all that fitting levels leave is the gears' inertia."""
        return None if np.isnan(self.most_meshes) else self.most_meshes <= FEW


def compare_baselines(judged_claims: Mapping[str, ClaimJudgement]) -> BaselineFinding:
    """The finding on the rigid baselines, from the claims' answers as modelled in the paper."""
    answers = {
        (answer.place.value_of(READING), answer.place.choice, claim): answer
        for claim in LABELS
        for answer in judged_claims[claim].answers
        if model_of(answer.place) == AS_MODELLED and answer.place.value_of(DAMPING) == ZETA
    }
    return BaselineFinding(
        tuple(
            RigidResidual(arm, level, {claim: answers[arm, level, claim] for claim in LABELS})
            for arm in dict.fromkeys(arm for arm, _, _ in answers)
            for level in RIGID_LEVELS
        )
    )


def draw_baselines(residuals: Sequence[RigidResidual]) -> str:
    """The sizes of what every baseline leaves, beside what the paper says, as svg."""
    figure, grid = make_figure(1, len(LABELS), 2.6)
    for axes, (claim, label) in zip(grid[0], LABELS.items(), strict=True):
        limits = BY_ID[claim].limits
        axes.axvspan(limits.low, limits.high, color="#999999", alpha=0.3, label="paper")
        for arm, marker, colour in zip(READINGS, "os", COLOURS, strict=False):
            arm_residuals = [residual for residual in residuals if residual.arm == arm]
            sizes = [residual.size(claim) for residual in arm_residuals]
            rows = [RIGID_LEVELS.index(residual.level) for residual in arm_residuals]
            axes.plot(sizes, rows, marker, color=colour, ms=5, label=READINGS[arm])
        axes.set(xscale="log", xlabel=f"left of {label}", yticks=[])
        axes.set_ylim(len(RIGID_LEVELS) - 0.5, -0.5)
    grid[0, 0].set_yticks(range(len(RIGID_LEVELS)), [LEVELS[level] for level in RIGID_LEVELS])
    draw_legend(figure, grid[0, 0])
    return to_svg(figure)
