"""Every claim has a planted world in which its verdict is another one: none is true by its making.

A world changes what runs show, never a claim's own function: every experiment is given the record
of a made-up run, measured as a real one is, and the claim is judged of that.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.claim_quantities import (
    DEFAULT,
    EDGES,
    ENDS,
    QUANTITIES,
    WIDER,
    accumulation,
    find_factor,
    relative_change,
)
from crosscheck.audit.claims.measured import MEASURES
from crosscheck.audit.claims.study_plan import FULL
from crosscheck.audit.experiments.ensembles import (
    ConstantTorqueQuestion,
    EnsembleNumbersQuestion,
    SwingQuestion,
)
from crosscheck.audit.experiments.experiments import (
    BACK,
    BACK_EVEN,
    BACKLASH,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    PD,
    WIDE_BEGINNING,
    PaperExperiment,
    build_question,
)
from crosscheck.audit.experiments.paper_conditions import PRINTED, Condition
from crosscheck.audit.judging.quantities import ConditionResults, Quantity
from crosscheck.audit.judging.rule import VerdictKind, evaluate_claim, verdict
from crosscheck.audit.judging.sample import Sample
from tests.audit.planted_runs import pools

WORLDS = 3000
CELL = Condition(PRINTED, FULL.shaken[0], planets="lumped")


def _kind(source: PaperExperiment) -> str:
    asked = build_question(source, CELL, (1,))
    if isinstance(asked, ConstantTorqueQuestion):
        return "constant torque"
    return "back and forth" if isinstance(asked, SwingQuestion) else "pd"


def _members(generator: np.random.Generator, sample: Sample, count: int) -> np.ndarray:
    """Which made-up run each member of a family is, (members, worlds).

    In some worlds in the order of a number, in others size changes nothing.
    """
    chosen = generator.integers(sample.diverged.size, size=(count, WORLDS))
    names = list(sample.numbers)
    kinds = generator.random(WORLDS)
    chosen[:, kinds > 0.8] = chosen[:1, kinds > 0.8]
    for world in np.flatnonzero(kinds < 0.6):
        by = sample.numbers[names[generator.integers(len(names))]]
        order = np.argsort(by[chosen[:, world]])
        chosen[:, world] = chosen[:, world][order[:: generator.choice([-1, 1])]]
    return chosen


@pytest.fixture(scope="module", autouse=True)
def _forgotten() -> Iterator[None]:
    """The worlds, 150 MB, with the last test that asks for them."""
    yield
    worlds.cache_clear()
    world_of.cache_clear()


@cache
def worlds() -> ConditionResults:
    """Every experiment of a setting; start i of all of them is the i-th world."""
    generator = np.random.default_rng(20150401)
    sources = [*FULL.experiments(CELL), WIDE_BEGINNING, BACKLASH(DEFAULT_B_UM), ERROR(DEFAULT_E_UM)]
    made: dict[PaperExperiment, Sample] = {}
    for family in (BACKLASH, ERROR, BACK, BACK_EVEN):
        own = sorted((s for s in sources if s.kind == family.kind), key=lambda s: s.size_um or 0)
        sample = pools()[_kind(own[0])]
        for source, runs in zip(own, _members(generator, sample, len(own)), strict=True):
            made[source] = _taken(sample, runs)
    for source in sources:
        if source not in made:
            sample = pools()[_kind(source)]
            made[source] = _taken(sample, generator.integers(sample.diverged.size, size=WORLDS))
    # In a third of the worlds an experiment changes nothing.
    for source in made:
        if source.size_um is None:
            same = generator.random(WORLDS) < 1 / 3
            plain = _plain(made, source)
            for name, values in made[source].numbers.items():
                values[same] = plain.numbers[name][same]
    return ConditionResults(made)


def _plain(made: dict[PaperExperiment, Sample], source: PaperExperiment) -> Sample:
    """The experiment of the same kind that changes nothing."""
    return next(made[one] for one in made if one.size_um is None and _kind(one) == _kind(source))


def _taken(sample: Sample, runs: np.ndarray) -> Sample:
    return Sample({name: values[runs] for name, values in sample.numbers.items()}, _no_run())


def _no_run(starts: int = WORLDS) -> np.ndarray:
    return np.zeros(starts, dtype=bool)


@cache
def world_of(number: int) -> ConditionResults:
    """A single one: every experiment of one start."""
    return ConditionResults(
        {
            source: Sample(
                {name: values[[number]] for name, values in sample.numbers.items()},
                np.array([number % 2 == 1]),
            )
            for source, sample in worlds().items()
        }
    )


def _by_choice() -> Iterator[object]:
    """Every claim that runs decide, by each choice of its free parameter alone."""
    for claim in (claim for claim in CLAIMS if not claim.static):
        for choice, quantity in claim.choices.items():
            name = f"{claim.id} {choice}".strip()
            yield pytest.param(replace(claim, quantity=quantity), id=name)


@pytest.mark.slow
@pytest.mark.parametrize("claim", list(_by_choice()))
def test_a_claim_that_runs_decide_holds_in_one_world_and_not_in_another(claim):
    diverging = "diverge" in claim.quantity.id
    found = set()
    for number in range(WORLDS):
        known = world_of(number)
        if not diverging:  # a run that diverges has no numbers, and these worlds have all
            known = ConditionResults(
                {s: replace(one, diverged=_no_run(1)) for s, one in known.items()}
            )
        found.add(verdict(evaluate_claim(claim, [(CELL, known)])).kind)
        if {VerdictKind.HOLDS, VerdictKind.FAILS} <= found:
            return
    pytest.fail(f"{claim.id}: {found}")


def test_the_size_of_a_change_does_not_hang_on_the_sign_of_what_changes():
    """theta_1 is negative: a change of a half is one of a half all the same."""
    known = ConditionResults({ONE: _one_start(made=-2.0), OTHER: _one_start(made=-3.0)})
    assert relative_change(_made(OTHER), _made(ONE))(known) == pytest.approx([0.5])


def test_a_factor_is_above_1_whichever_is_the_larger():
    known = ConditionResults({ONE: _one_start(made=2.0), OTHER: _one_start(made=8.0)})
    for pair in ((ONE, OTHER), (OTHER, ONE)):
        assert find_factor(*map(_made, pair))(known) == pytest.approx([4.0])


def test_of_a_family_the_least_or_the_greatest_member_counts():
    """Clearances of 5, 10, 50 and 100 um, of which neither the first nor the last is the least."""
    forces, decays = (30.0, 20.0, 40.0, 60.0), (0.01, 0.02, 0.07, 0.05)
    members = {
        BACKLASH(size): _one_start(
            second_force_N=force,
            third_force_N=force / 2,
            first_decay_s=decay,
            second_decay_s=np.nan,
        )
        for size, force, decay in zip((5.0, 10.0, 50.0, 100.0), forces, decays, strict=True)
    }
    errors = {
        ERROR(size): _one_start(first_decay_s=0.01, second_decay_s=0.02) for size in (0.8, 1.6, 3.2)
    }
    pd_run = {PD: _one_start(second_force_N=50.0, third_force_N=10.0)}
    known = ConditionResults(members | errors | pd_run)
    right = {EDGES: 30 / 20, DEFAULT: 50 / 20, WIDER: 0.07}
    right[MEASURES.series_minimum(BACKLASH, "second_force_N")] = 20.0
    right[MEASURES.series_maximum(BACKLASH, "second_force_N")] = 60.0
    for quantity, value in right.items():
        assert quantity(known) == pytest.approx([value]), quantity.id
    sizes = (8.0, np.nan, 2.0)  # not every run has an impact
    known = ConditionResults(
        {BACKLASH(b): _one_start(second=size) for b, size in zip((5, 10, 50), sizes, strict=True)}
    )
    assert QUANTITIES["4-03"](known) == pytest.approx([2.0])
    grown = dict(zip(ENDS["1"], (1.0, 3.0, 6.0, 30.0), strict=True))
    known = ConditionResults(
        {BACK(DEFAULT_B_UM): _one_start(**{f"error_{end}_s": e for end, e in grown.items()})}
    )
    assert accumulation(BACK, "1")(known) == pytest.approx([2.0])


ONE, OTHER = (PaperExperiment(name) for name in ("one", "other"))


def _one_start(**numbers: float) -> Sample:
    return Sample({name: np.array([v]) for name, v in numbers.items()}, np.zeros(1, bool))


def _made(source: PaperExperiment) -> Quantity:
    return Quantity(str(source), "1", lambda known: known[source]["made"])


def test_every_experiment_of_the_page_has_made_up_runs():
    assert {type(build_question(s, CELL, (1,))) for s in FULL.experiments(CELL)} <= set(
        EnsembleNumbersQuestion.__subclasses__()
    )
