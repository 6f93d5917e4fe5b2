"""What vibrates without any tooth error: dampers that act only in contact, and the controller.

With dampers always at work and every tooth in contact, the controlled arm is stable above some
damping (H6). A damper that acts in contact alone is missing while the teeth fly: the larger the
vibration, the less damping, and what is stable in the small need not be so in the large. And a
start in a hundred or so at the smallest damping runs away: the printed law lets it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosscheck import signals
from crosscheck.audit.experiments.ensembles import EnsembleQuestion, TransientPdQuestion
from crosscheck.audit.experiments.experiments import PD, build_question
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, PRINTED, ZETAS, Condition, Law
from crosscheck.audit.experiments.samples import Sample
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.measures import events, run_signals, shares
from crosscheck.audit.measures.third_fluctuation import Quantiles, ThirdFluctuation, quantiles
from crosscheck.audit.measures.thresholds import EVIDENT
from crosscheck.audit.measures.undefined import float_or_none
from crosscheck.audit.phase import runs

QUIET_S = 0.45  # with dampers always at work all vibration but rounding is gone by then
QUIET_ZETA = 0.01
RUNAWAY_ZETA = 0.003
RUNAWAY_LAWS = (PRINTED, INTEGRAL)
RUNAWAY_STARTS, AT_ONCE = 256, 32
FAST_RAD_PER_S = 10.0  # ten times what the controller ever asks for
LATE_S = (0.2, 0.7)  # after the handover: the rest of the third fluctuation


# What is left out of the arm without tooth error.
AS_IT_STANDS = runs.Change("dampers in contact alone", (runs.NO_ERROR,), (runs.CONTACT,))
ALWAYS = replace(AS_IT_STANDS, name="dampers always at work", settings=())
PLAYED_BACK = replace(
    AS_IT_STANDS, name="no feedback: the rigid arm's torque played back", recorded=True
)
STEADY = replace(
    AS_IT_STANDS,
    name="constant stiffness",
    meshes=(runs.NO_ERROR, "arm.joints.*.*_mesh.stiffness.amplitude_N_per_m=0.0"),
)
TIGHT = replace(
    AS_IT_STANDS, name="no backlash", meshes=(runs.NO_ERROR, "arm.joints.*.*_mesh.backlash_m=0.0")
)
ABLATIONS = (AS_IT_STANDS, ALWAYS, PLAYED_BACK, STEADY, TIGHT)
FLUTTERING = (
    ALWAYS,
    *(
        replace(item, name=f"{ALWAYS.name}; {item.name}", settings=())
        for item in (PLAYED_BACK, STEADY, TIGHT)
    ),
)
FLUTTER_ZETA = 0.003  # below the controller's own threshold
STILL = 0.1  # rad/s^2: a hundredth of what counts as a fluctuation


@dataclass(frozen=True)
class DamperAblation:
    """The third fluctuation without tooth error under a change of the arm, at a damping ratio."""

    ablation: runs.Change
    zeta: float
    third: ThirdFluctuation


@dataclass(frozen=True)
class DecayTest(EnsembleQuestion[list[float | None]]):
    """A question: vibration [rad/s^2] with dampers in contact alone, begun without any.

    The variant's run is quiet until its end, QUIET_S, dampers always at work; its states go on for
    so long with dampers in contact alone. None for a start that diverges.
    """

    cost = 0.5

    duration_s: float

    def answer(self) -> list[float | None]:
        before = runs.simulate_motion(runs.build_models(self.variant, self.seeds))
        whole = replace(self.variant, duration_s=events.THIRD_S[1])
        after = replace(whole, settings=(runs.CONTACT,), duration_s=self.duration_s).case()
        states = zip(before.q[-1].T.copy(), before.v[-1].T.copy(), strict=True)
        run = runs.simulate_motion([runs.ContinuedModel(after, q, v) for q, v in states], QUIET_S)
        excess = runs.shoulder_excess(whole, run.time, run.shoulder)
        part = signals.window(run.elapsed_s, *LATE_S)
        return [float_or_none(signals.amplitude(column)) for column in excess[part].T]


@dataclass(frozen=True)
class DamperResult:
    """Third fluctuations without tooth error, over damping and with other things left out.

    over_zeta: dampers in contact alone; ablated: at QUIET_ZETA; rest: begun without vibration
    there [rad/s^2]; fluttering: dampers always at work, at FLUTTER_ZETA.
    """

    over_zeta: Sequence[DamperAblation]
    ablated: Sequence[DamperAblation]
    rest: Quantiles
    fluttering: Sequence[DamperAblation]

    def median(self, name: str) -> float | None:
        """The median size [rad/s^2] with one thing left out, by its name; None where undefined."""
        return next(
            result for result in self.ablated if result.ablation.name == name
        ).third.quantiles[1]

    @property
    def excited_hard(self) -> bool | None:
        """Whether the vibration is there, and needs feedback, backlash, and something to begin it.

        And does not need a varying stiffness.
        """
        needed = [self.median(change.name) for change in (PLAYED_BACK, TIGHT, ALWAYS)] + [
            self.rest[1]
        ]
        kept = [self.median(change.name) for change in (AS_IT_STANDS, STEADY)]
        gone = [None if size is None else size < STILL for size in needed]
        there = [None if size is None else size > EVIDENT for size in kept]
        return None if None in (*gone, *there) else all((*gone, *there))

    @property
    def largest_zeta(self) -> float | None:
        """Largest damping ratio at which half of the starts vibrate evidently, E = 0; or None."""
        zetas = [
            result.zeta for result in self.over_zeta if (result.third.quantiles[1] or 0.0) > EVIDENT
        ]
        return max(zetas, default=None)


def run_damper_tests(study: Study, scale: Scale) -> DamperResult:
    """The vibrations without tooth error, the phase an integral, planets free."""
    cases = [(AS_IT_STANDS, zeta) for zeta in ZETAS]
    cases += [(item, QUIET_ZETA) for item in ABLATIONS if item != AS_IT_STANDS]
    cases += [(item, FLUTTER_ZETA) for item in FLUTTERING]
    questions = {
        (item, zeta): item.question(Condition(INTEGRAL, zeta), scale) for item, zeta in cases
    }
    answers = study.answer_by_key(questions, "phase: dampers")
    results = [
        DamperAblation(*pair, ThirdFluctuation.from_samples(Sample.from_numbers(item)))
        for pair, item in answers.items()
    ]
    contact_results = [item for item in results if item.ablation == AS_IT_STANDS]
    at_quiet = [item for item in results if item.zeta == QUIET_ZETA]
    seconds = scale.limit_duration(events.THIRD_S[1] - QUIET_S)
    quiet = runs.build_pd_variant(Condition(INTEGRAL, QUIET_ZETA), QUIET_S, runs.NO_ERROR)
    (rest,) = study.answer_questions(
        [DecayTest(quiet, scale.seeds, seconds)], "phase: laid to rest"
    )
    fluttering = [
        item for item in results if item.ablation in FLUTTERING and item.zeta == FLUTTER_ZETA
    ]
    return DamperResult(
        contact_results, at_quiet, quantiles(np.array(rest, dtype=float)), fluttering
    )


class TopSpeed(TransientPdQuestion):
    """A question: top speeds [rad/s] of either joint over the whole run, and the rigid arm's."""

    def numbers(
        self, run: run_signals.RunSignals, rigid: tuple[run_signals.RunSignals, ...]
    ) -> Numbers:
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
    share: shares.Share
    diverged: int
    top_rad_per_s: tuple[float, ...]
    calm_rad_per_s: float
    asked_rad_per_s: float


def find_runaways(study: Study, scale: Scale) -> list[Runaway]:
    """The runaways of each law among many starts of 3 s with free planets."""
    count = scale.limit_starts(RUNAWAY_STARTS) if scale.most_starts < AT_ONCE else RUNAWAY_STARTS
    seeds = range(scale.first_seed, scale.first_seed + count)
    parts = [tuple(seeds[k : k + AT_ONCE]) for k in range(0, count, AT_ONCE)]
    questions = {
        (law, part): TopSpeed(
            scale.cut(build_question(PD, Condition(law, RUNAWAY_ZETA), ()).variant), part
        )
        for law in RUNAWAY_LAWS
        for part in parts
    }
    answers = study.answer_by_key(questions, "phase: runaways")
    runaways = []
    for law in RUNAWAY_LAWS:
        samples = [Sample.from_numbers(answers[law, part]) for part in parts]
        top, rigid = (
            np.concatenate([sample[name][: sample.run] for sample in samples])
            for name in ("top_rad_per_s", "asked_rad_per_s")
        )
        fast, calm = top[top > FAST_RAD_PER_S], top[top <= FAST_RAD_PER_S]
        diverged = int(np.isnan(top).sum())
        runaway = Runaway(
            law=law,
            share=shares.Share(int(fast.size) + diverged, int(top.size)),
            diverged=diverged,
            top_rad_per_s=tuple(map(float, np.sort(fast))),
            calm_rad_per_s=float(calm.max()) if calm.size else np.nan,
            asked_rad_per_s=float(np.nanmax(rigid)) if diverged < top.size else np.nan,
        )
        runaways.append(runaway)
    return runaways
