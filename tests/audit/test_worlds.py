"""Every claim has a planted world in which its verdict is another one: none is true by its making.

A world changes what runs show, never a claim's own function: every experiment is given the record
of a made-up run, measured as a real one is, and the claim is judged of that.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from crosscheck.audit.claims.catalogue import CLAIMS, read_quantity
from crosscheck.audit.claims.measured import ENDS
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
    WIDE_BEGINNING,
    PaperExperiment,
    build_question,
    find_experiment,
)
from crosscheck.audit.experiments.paper_conditions import PRINTED, Condition
from crosscheck.audit.judging.quantities import ConditionResults, Sample
from crosscheck.audit.judging.rule import VerdictKind, evaluate_claim, verdict
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
        own = sorted((s for s in sources if s.kind == family.kind), key=lambda s: s.size or 0)
        sample = pools()[_kind(own[0])]
        for source, runs in zip(own, _members(generator, sample, len(own)), strict=True):
            made[source] = _taken(sample, runs)
    for source in sources:
        if source not in made:
            sample = pools()[_kind(source)]
            made[source] = _taken(sample, generator.integers(sample.diverged.size, size=WORLDS))
    # In a third of the worlds an experiment changes nothing.
    for source in made:
        if source.size is None:
            same = generator.random(WORLDS) < 1 / 3
            plain = _plain(made, source)
            for name, values in made[source].numbers.items():
                values[same] = plain.numbers[name][same]
    return ConditionResults(made)


def _plain(made: dict[PaperExperiment, Sample], source: PaperExperiment) -> Sample:
    """The experiment of the same kind that changes nothing."""
    return next(made[one] for one in made if one.size is None and _kind(one) == _kind(source))


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


NAN = np.nan
GROWN = dict(zip(ENDS["1"], (1.0, 3.0, 6.0, 30.0), strict=True))
# Of five clearances [um], of which neither the first nor the last has the least or the most of all;
# not every run has an impact.
CLEARANCES = {
    "second_force_N": (30.0, 20.0, 40.0, 40.0, 60.0),
    "third_force_N": (15.0, 10.0, 20.0, 20.0, 30.0),
    "first_decay_s": (0.01, 0.02, 0.07, 0.05, 0.0),
    "second_decay_s": (NAN, NAN, NAN, NAN, NAN),
    "second": (8.0, NAN, 2.0, 9.0, 9.0),
    "third": (300.0, 200.0, 100.0, 0.1, 100.0),
    "frequency_Hz": (1600.0, 1500.0, 1400.0, 9000.0, NAN),
}
ONE_START = {
    "pd": {"second_force_N": 50.0, "third_force_N": 10.0, "third": -2.0, "first": 8.0},
    "no error": {"third": -3.0, "first": 2.0},
    **{
        f"backlash {b} um": {name: values[place] for name, values in CLEARANCES.items()}
        for place, b in enumerate((5, 10, 25, 50, 500))
    },
    **{f"tooth error {e} um": {"first_decay_s": 0.01, "second_decay_s": 0.02} for e in (0.8, 2, 3)},
    "back and forth, backlash 50 um": {f"error_{end}_s": e for end, e in GROWN.items()},
    "back and forth, backlash 0 um": {f"error_{end}_s": 0.5 for end in GROWN},
}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pd: first", 8.0),
        (["less", "pd: first", "no error: first"], 6.0),
        (["over", "pd: first", "no error: first"], 4.0),
        (["size", "pd: third"], 2.0),
        (["min", "pd: first", "no error: third"], -3.0),
        (["max", "pd: first", "no error: third"], 8.0),
        (["max", "pd: first", "backlash 10 um: second"], NAN),
        (["any start's", "pd: third"], -2.0),
        (["times", 0.5, "1", "pd: first"], 4.0),
        (["where above", "MINOR", "pd: first", "pd: third"], -2.0),
        (["where above", 8.0, "pd: first", "pd: third"], NAN),
        (["where below", "EVIDENT", "pd: first", "pd: third"], -2.0),
        (["where below", 8.0, "pd: first", "pd: third"], NAN),
        (["least", "backlash: second_force_N"], 20.0),
        (["greatest", "backlash: second_force_N"], 60.0),
        (["least", "backlash: second"], NAN),
        (["least of those with", "backlash: second"], 2.0),
        (["rank", "backlash: third"], -8 / 95**0.5),  # two of the ranks are one
        (["rank where above", 10.0, "backlash: third", "frequency_Hz"], -1.0),
        (["rank where above", 150.0, "backlash: third", "frequency_Hz"], NAN),  # of two sizes
        (["accumulation", "back and forth, backlash", "1"], 2.0),
        (["accumulation", "back and forth, backlash", "1", 0.0], 11 / 5),
        ("edges", 30 / 20),
        ("default", 50 / 20),
        ("wider", 0.07),
        ("as_wide", 0.01),
        ("owed", 1.0),
    ],
    ids=str,
)
def test_a_quantity_that_is_written_as_data_has_its_value(text, value):
    known = ConditionResults(
        {
            find_experiment(name): Sample(
                {key: np.array([x]) for key, x in numbers.items()}, _no_run(1)
            )
            for name, numbers in ONE_START.items()
        }
    )
    assert read_quantity(text)(known) == pytest.approx([value], rel=1e-3, nan_ok=True)


def test_every_experiment_of_the_page_has_made_up_runs():
    assert {type(build_question(s, CELL, (1,))) for s in FULL.experiments(CELL)} <= set(
        EnsembleNumbersQuestion.__subclasses__()
    )
