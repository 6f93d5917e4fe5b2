"""Fig. 15's experiment, back and forth: what backlash adds, and what the rigid arm foretells.

The error is the joints' angle with backlash less that without, start i of
the one against start i of the other. The rigid arm's sensitivity to its start is found by moving
that a little; one fixed combination of the four sensitivities, fitted early, is all there is to
foretell the error's later course.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosscheck import signals
from crosscheck.analytic.model import PhysicalModel, RigidCoupled
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, Condition
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.judging.rule import State, state
from crosscheck.audit.judging.shares import Share, share_of
from crosscheck.audit.measures.rigid import COUPLED, remove_gears
from crosscheck.audit.measures.run_signals import RunSignals, simulate_signals
from crosscheck.audit.measures.undefined import (
    JsonObject,
    combine_answers,
    float_or_none,
    quotient,
)
from crosscheck.models.errors import Diverged
from crosscheck.studies.members.starts import perturb_start

DRIVES = ("sqrt_time", "time")  # 2000 sin(20 pi sqrt(t)) as printed, 2000 sin(20 pi t)
ZETAS = (0.05, 0.005)
BACKLASH_M = 5e-5  # Table I's
NUDGE = 1e-7  # of the rigid arm's start [rad, rad/s]: its error grows a thousandfold, still small
SMALL_S = (0.3, 1.2)  # where errors are small and the start's transients over
LEARNT_S = (0.1, 0.6)  # where the coefficients of the rigid prediction are fitted
SAME_RATE, SAME_SIZE = 0.25, 0.1
EVERY_S = 1e-3
DURATION_S = 2.0  # the paper's text does not say of Fig. 15


@dataclass(frozen=True)
class StartMeasures:
    """The numbers of one start, each None where its run ends before.

    growth_per_s [1/s]: of the error; misfit: of the rigid prediction, over the largest error;
    largest_rad: largest error [rad] of the shoulder.
    """

    growth_per_s: float | None
    misfit: float | None
    largest_rad: float


@dataclass(frozen=True)
class ShakingResult:
    """Results of one drive and damping ratio. starts: all that did not diverge.

    rigid_growth_per_s: of the rigid arm's error when its elbow is nudged; largest_sensitivity:
    d theta_1 / d theta_2(0).
    """

    drive: str
    zeta: float
    starts: tuple[StartMeasures, ...]
    rigid_growth_per_s: float | None
    largest_sensitivity: float

    @property
    def own(self) -> Share | None:
        """The share of starts in which the error's growth is the rigid arm's own."""
        rigid = self.rigid_growth_per_s
        return share_of(
            is_rigid_sensitivity(start.growth_per_s, rigid, start.misfit) for start in self.starts
        )

    def span(self, name: str) -> tuple[float | None, float | None]:
        """The least and largest value of a number over the starts; None without any."""
        values = [getattr(start, name) for start in self.starts]
        defined_values = [value for value in values if value is not None]
        return min(defined_values, default=None), max(defined_values, default=None)

    @property
    def largest_rad(self) -> float:
        """The largest error [rad] in any start."""
        return max(start.largest_rad for start in self.starts)

    def to_dict(self) -> JsonObject:
        """The results as a JSON object; spans are the least and largest of the starts."""
        return {
            "id": f"finding/accumulation/{self.drive}/{self.zeta:g}",
            "own": str(self.own),
            "largest_rad": self.largest_rad,
            "rigid_growth_per_s": self.rigid_growth_per_s,
            "largest_sensitivity": self.largest_sensitivity,
            "growth_per_s": list(self.span("growth_per_s")),
            "misfit": list(self.span("misfit")),
        }


def judge_drive(results: Sequence[ShakingResult]) -> State | None:
    """Whether the growth is the rigid arm's own, at all damping ratios alike; else None."""
    states = {state(result.own) for result in results}
    return states.pop() if len(states) == 1 else None


def run_shaking(study: Study, scale: Scale) -> dict[str, list[ShakingResult]]:
    """The results at every damping ratio, by drive."""
    questions = [
        ShakingQuestion(drive, zeta, scale.seeds, scale.limit_duration(DURATION_S))
        for drive in DRIVES
        for zeta in ZETAS
    ]
    results = study.answer_questions(questions, "back and forth")
    return {drive: [result for result in results if result.drive == drive] for drive in DRIVES}


@dataclass(frozen=True)
class ShakingQuestion(Question[ShakingResult]):
    """A question: the arm with and without backlash from many starts, beside the rigid arm."""

    drive: str
    zeta: float
    seeds: tuple[int, ...]
    duration_s: float

    @property
    def variant(self) -> Variant:
        """The variant with the arm's own backlash."""
        plain = Condition(INTEGRAL, self.zeta).variant("back-and-forth")
        drive = f"scenario.drive.argument={self.drive}"
        stride = round(EVERY_S / plain.case().scenario.step_s)
        return replace(plain, settings=(drive,), record_every=stride, duration_s=self.duration_s)

    def records(self) -> Records:
        return self.variant.case()

    @property
    def cost(self) -> float:
        return 0.2 * len(self.seeds) * self.duration_s

    def answer(self) -> ShakingResult:
        time, sensitivity = self._simulate_rigid()
        plain, with_play = self._simulate_geared(0.0), self._simulate_geared(BACKLASH_M)
        whole = [i for i in plain if i in with_play]
        if not whole:
            raise Diverged(self.variant.model, 0.0)
        elbow = sensitivity[:, 0, 1]
        return ShakingResult(
            self.drive,
            self.zeta,
            tuple(measure_start(time, with_play[i] - plain[i], sensitivity) for i in whole),
            float_or_none(growth_rate(time, elbow)),
            float(np.abs(elbow).max()),
        )

    def _simulate_geared(self, backlash_m: float) -> dict[int, np.ndarray]:
        """The angles theta (times, joints) [rad] of every start that did not diverge, by place."""
        meshes = (f"arm.joints.*.*_mesh.backlash_m={backlash_m!r}",)
        variant = replace(self.variant, meshes=meshes)
        case = variant.case()
        made = simulate_signals([PhysicalModel(*perturb_start(case, seed)) for seed in self.seeds])
        return {i: run.theta for i, run in enumerate(made) if isinstance(run, RunSignals)}

    def _simulate_rigid(self) -> tuple[np.ndarray, np.ndarray]:
        """The rigid arm's time (times,) [s] and sensitivity (times, 2, 4).

        The sensitivity is the derivative of theta by the start's states.
        """
        plain = remove_gears(self.variant, COUPLED)
        nudges = [
            f"scenario.start.{name}={[NUDGE * (joint == moved) for joint in range(2)]}"
            for name in ("theta_rad", "theta_dot_rad_per_s")
            for moved in range(2)
        ]
        variants = [plain, *(replace(plain, settings=(*plain.settings, x)) for x in nudges)]
        runs = simulate_signals([RigidCoupled(*variant.case()) for variant in variants])
        first, *nudged = (run for run in runs if isinstance(run, RunSignals))
        moved = [(run.theta - first.theta) / NUDGE for run in nudged]
        return first.time, np.stack(moved, axis=2)


def measure_start(time: np.ndarray, error: np.ndarray, sensitivity: np.ndarray) -> StartMeasures:
    """The numbers of one start, from its error (times, 2) and the rigid arm's sensitivity."""
    predicted = rigid_prediction(time, error, sensitivity)
    ahead = (time >= LEARNT_S[1]) & (time <= SMALL_S[1])
    misfit = quotient(*(signals.amplitude(x[ahead, 0]) for x in (predicted - error, error)))
    return StartMeasures(
        growth_per_s=float_or_none(growth_rate(time, error[:, 0])),
        misfit=float_or_none(misfit),
        largest_rad=float(np.abs(error[:, 0]).max()),
    )


def growth_rate(time: np.ndarray, values: np.ndarray) -> float:
    """Exponential rate [1/s] of the running maximum of |values| within SMALL_S; nan if not run."""
    part = (time >= SMALL_S[0]) & (time < SMALL_S[1])
    if part.sum() < 2:
        return np.nan
    largest = np.maximum.accumulate(np.abs(values)) + 1e-300  # so far at every time, never 0
    return float(np.polyfit(time[part], np.log(largest[part]), 1)[0])


def rigid_prediction(time: np.ndarray, error: np.ndarray, sensitivity: np.ndarray) -> np.ndarray:
    """The combination (times, 2) of sensitivities that fits the error (times, 2) in LEARNT_S.

    nan if the run ends before.
    """
    part = (time >= LEARNT_S[0]) & (time < LEARNT_S[1])
    causes = sensitivity.shape[2]
    if 2 * part.sum() < causes:
        return np.full(error.shape, np.nan)
    fit = np.linalg.lstsq(sensitivity[part].reshape(-1, causes), error[part].ravel(), rcond=None)
    return sensitivity @ fit[0]


def is_rigid_sensitivity(
    error_growth: float | None, rigid_growth: float | None, misfit: float | None
) -> bool | None:
    """Whether the rigid arm foretells the backlash error and both grow at one rate [1/s]."""
    rates = quotient(error_growth, rigid_growth)
    same_rate = None if not np.isfinite(rates) else bool(abs(rates - 1) <= SAME_RATE)
    same_size = None if misfit is None or not np.isfinite(misfit) else misfit <= SAME_SIZE
    return combine_answers((same_rate, same_size))
