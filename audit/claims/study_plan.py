"""Which experiments are made in which settings, and what all chapters of the page work from."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, product

import numpy as np

from crosscheck.audit.claims.catalogue import CLAIMS, ModelJudgement
from crosscheck.audit.errata.erratum import Erratum
from crosscheck.audit.errata.finder import EFFECT_S, ErrataQuestion
from crosscheck.audit.errata.printed_equations import PlantedFaultQuestion, detectable_share
from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.experiments import paper_conditions
from crosscheck.audit.experiments.paper_conditions import (
    AS_MODELLED,
    LABELLED,
    Condition,
    GearModel,
)
from crosscheck.audit.experiments.samples import SampleRequest, Scale, collect_samples
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.judging.quantities import ConditionResults, Sample
from crosscheck.audit.judging.rule import evaluate_claim
from crosscheck.audit.statics.statics import Statics

VARIED = (run.PD, run.NO_ERROR)  # the experiments that are made of VARIANTS


@dataclass(frozen=True)
class StudyPlan:
    """What is simulated where. zetas: of all experiments but those of ``shaken``; sizes in um.

    shaken: of back and forth, the square wave, two planets, 3 s with b = 3000 um, links that turn
    back, preloaded constant torque, exact teeth in the elbow, and neither
    backlash nor tooth error;
    The second reading of Table I sweeps b and E at every second zeta. back: of Fig. 15, to which
    the claims add 1000 and 3000 um.
    """

    readings: tuple[str, ...] = tuple(paper_conditions.READINGS)
    zetas: tuple[float, ...] = paper_conditions.ZETAS
    shaken: tuple[float, ...] = (0.005, 0.02, 0.05)
    backlashes: tuple[float, ...] = (5.0, 10.0, 25.0, 500.0, 1000.0, 3000.0)
    errors: tuple[float, ...] = (0.8, 1.6, 3.2, 6.3)
    back: tuple[float, ...] = (0.0, 50.0, 100.0, 500.0)

    def claim_conditions(self) -> list[Condition]:
        """The settings of the claims: planets free, all laws."""
        every = product(paper_conditions.LAWS, self.readings, self.zetas)
        return [Condition(law, zeta, arm) for law, arm, zeta in every]

    def model_conditions(self, model: GearModel) -> list[Condition]:
        """The settings of a model of the gears, at every reading and damping ratio."""
        return [
            Condition(model.law, z, arm, model.planets, model.equations)
            for arm in self.readings
            for z in self.zetas
        ]

    def experiments(self, condition: Condition) -> Iterator[run.PaperExperiment]:
        """The experiments that are simulated in a setting of the claims."""
        is_shaken = condition.zeta in self.shaken
        is_corrected = is_shaken and condition.equations == "corrected"
        made = {"every": True, "shaken": is_shaken, "corrected": is_corrected}
        yield from (each for each in run.EXPERIMENTS.values() if made.get(each.where))
        if condition.arm == self.readings[0] or condition.zeta in self.zetas[::2]:
            backlashes = [run.BACKLASH(size_um) for size_um in self.backlashes]
            # Where WIDE is made, it begins with one of them.
            yield from (x for x in backlashes if not (is_shaken and x == run.WIDE_BEGINNING))
            yield from (run.ERROR(size_um) for size_um in self.errors)
        if is_shaken:
            for size_um in (*self.back, run.CHAOTIC_UM, 1e6 * run.WIDE_M):
                yield from (run.BACK(size_um), run.BACK_EVEN(size_um))
            yield run.SERIES["backlash, no error"](0.0)


FULL = StudyPlan()
ResultsByCondition = list[tuple[Condition, ConditionResults]]


def run_experiments(
    study: Study, scale: Scale, conditions: Sequence[Condition], label: str
) -> ResultsByCondition:
    """The chosen settings, each with its experiments and what follows from the arm's data."""
    requests = [
        (condition, experiment)
        for condition in conditions
        for experiment in FULL.experiments(condition)
    ]
    results_by_condition = _collect_results(study, scale, requests, label)
    statics = study.answer_questions(list(map(Statics, FULL.readings)), "claims: statics")
    planted = list(map(PlantedFaultQuestion, FULL.readings))
    changes = study.answer_questions(planted, "claims: planted slips")
    shares: list[Numbers] = [{"planted_shown": detectable_share(each)} for each in changes]
    for condition, results in results_by_condition.items():
        place = FULL.readings.index(condition.arm)
        results[run.STATIC] = _single_start_sample(statics[place])
        results[run.PLANTED] = _single_start_sample(shares[place])
        results.update(dict.fromkeys(run.DEFAULTS, results[run.PD]))
        if run.WIDE in results and run.WIDE_BEGINNING.size in FULL.backlashes:
            results[run.WIDE_BEGINNING] = results[run.WIDE]
    return list(results_by_condition.items())


def _collect_results(
    study: Study, scale: Scale, requests: Sequence[SampleRequest], label: str
) -> dict[Condition, ConditionResults]:
    """The samples of experiments by their settings."""
    results: dict[Condition, ConditionResults] = defaultdict(ConditionResults)
    samples = collect_samples(study, scale, requests, label)
    for condition, experiment in requests:
        results[condition][experiment] = samples[condition, experiment]
    return results


def _single_start_sample(numbers: Numbers) -> Sample:
    """A sample of one start whose numbers are these."""
    values = {name: np.array([value], float) for name, value in numbers.items()}
    return Sample(values, diverged=np.zeros(1, dtype=bool))


@dataclass(frozen=True)
class AuditContext:
    """What a page is made from, once; nothing is run before it is asked for."""

    study: Study
    scale: Scale

    @cached_property
    def settings(self) -> ResultsByCondition:
        """The settings of the claims with planets free, each with its experiments."""
        return run_experiments(self.study, self.scale, FULL.claim_conditions(), "claims")

    @cached_property
    def as_modelled(self) -> ResultsByCondition:
        """The settings of the paper's own model, each with its experiments."""
        chosen = FULL.model_conditions(AS_MODELLED)
        return run_experiments(self.study, self.scale, chosen, "claims, as modelled")

    @cached_property
    def variations(self) -> Mapping[GearModel, ResultsByCondition]:
        """The settings of further models of the gears, with the PD run's experiments alone."""
        by_model = {model: FULL.model_conditions(model) for model in paper_conditions.VARIANTS}
        requests = list(product(chain.from_iterable(by_model.values()), VARIED))
        results = _collect_results(self.study, self.scale, requests, "claims, variants")
        return {model: [(each, results[each]) for each in by_model[model]] for model in by_model}

    @property
    def effect_s(self) -> float:
        """How long [s] the runs behind the effects of errata last."""
        return self.scale.limit_duration(EFFECT_S)

    @cached_property
    def errata(self) -> Sequence[Erratum]:
        """The errors of equations, with Table I as its labels say."""
        question = ErrataQuestion(LABELLED, self.effect_s)
        (errata,) = self.study.answer_questions([question], "errata sheet")
        return errata

    @cached_property
    def judged_claims(self) -> Mapping[str, ModelJudgement]:
        """The claims with their answers in all settings, by id."""
        settings = [*self.as_modelled, *self.settings]
        return {c.id: ModelJudgement(c, tuple(evaluate_claim(c, settings))) for c in CLAIMS}

    def samples(self, requests: Iterable[SampleRequest], what: str) -> dict[SampleRequest, Sample]:
        """Samples of experiments in any settings, also the claims', from the scale's starts."""
        return collect_samples(self.study, self.scale, requests, what)
