"""Every claim has a planted world in which its verdict is another one: none is true by its making.

A world changes what experiments measure, never a claim's own function. What is measured of a run
whose numbers are known is another test's.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from crosscheck.audit.claims.catalogue import CLAIMS, read_quantity
from crosscheck.audit.claims.measured import ENDS, MEASURED
from crosscheck.audit.experiments.experiments import NO_ERROR, PaperExperiment, find_experiment
from crosscheck.audit.judging.quantities import ConditionResults, Sample
from crosscheck.audit.judging.rule import evaluate_claim
from tests.audit.test_claims import CELL, sources

WORLDS = 4000
ENDS_OF_LIMITS = sorted(
    {abs(end) for claim in CLAIMS for end in (claim.limits.low, claim.limits.high)} - {0.0, np.inf}
)
ERRORS = [f"error_{end}_s" for end in ENDS["2"]]


def draw(name: str, count: int) -> np.ndarray:
    """Numbers (count, worlds) of any size, now and then negative or near the end of a limit."""
    rng = np.random.default_rng([20150401, *name.encode()])
    values = 10 ** rng.uniform(-7, 4, (count, WORLDS))
    near = rng.choice(ENDS_OF_LIMITS, WORLDS) * rng.uniform(0.7, 1.4, (count, WORLDS))
    values = np.where(rng.random(WORLDS) < 0.3, near, values)
    return values * np.where(rng.random((count, WORLDS)) < 0.1, -1, 1)


@cache
def draw_family(kind: str, varied: bool, name: str) -> np.ndarray:
    """A number of all experiments of a kind (members, worlds).

    In some worlds it rises or falls with what they vary, or hardly changes; in a third of them an
    experiment that varies nothing is like the others.
    """
    members = FAMILIES[kind, varied]
    values, way = draw(f"{kind} {varied} {name}", len(members)), np.linspace(0, 1, WORLDS)
    way = np.random.default_rng(20150401).permutation(way)
    if not varied:
        return np.where(way < 1 / 3, values[:1], values)
    rising, hardly = np.sort(values, axis=0), 1 + 0.01 * np.arange(len(members))
    values = np.where(way < 0.3, rising, np.where(way < 0.6, rising[::-1], values))
    return np.where(way > 0.8, values[:1] * hardly[:, None], values)


FAMILIES: dict[tuple[str, bool], list[PaperExperiment]] = {}
for each in sorted(sources(), key=lambda source: source.size or 0.0):
    FAMILIES.setdefault((each.kind, each.size is not None), []).append(each)


class World(Sample):
    """What an experiment measures in each of the worlds, which are starts; drawn when asked.

    quiet: in none of them there is a vibration without the tooth error.
    """

    def __init__(self, source: PaperExperiment, quiet: bool) -> None:
        super().__init__({}, np.arange(WORLDS) % 2 == 1)
        vars(self).update(source=source, quiet=quiet)  # a sample is frozen

    def __getitem__(self, name: str) -> np.ndarray:
        assert name in MEASURED
        kind, varied = self.source.kind, self.source.size is not None
        place = FAMILIES[kind, varied].index(self.source)
        if name in ERRORS:  # in half of the worlds an error grows with time
            errors = np.abs([draw_family(kind, varied, each)[place] for each in ERRORS])
            grown = np.where(np.arange(WORLDS) % 4 < 2, np.sort(errors, axis=0), errors)
            return grown[ERRORS.index(name)]
        values = draw_family(kind, varied, name)[place]
        return 1e-9 * values if self.quiet and self.source == NO_ERROR else values


def _by_choice() -> Iterator[object]:
    """Every claim that runs decide, by each choice of its free parameter alone."""
    for claim in (claim for claim in CLAIMS if not claim.static):
        for choice, quantity in claim.choices.items():
            name = f"{claim.id} {choice}".strip()
            yield pytest.param(replace(claim, quantity=quantity), id=name)


@pytest.mark.parametrize("claim", list(_by_choice()))
def test_a_claim_that_runs_decide_holds_in_one_world_and_not_in_another(claim):
    quiet = "any start's" in claim.quantity.id  # of which the largest of all worlds counts
    known = ConditionResults({source: World(source, quiet) for source in sources()})
    (answer,) = evaluate_claim(claim, [(CELL, known)])
    draw_family.cache_clear()
    assert 0 < answer.yes < len(answer.values)


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
                {key: np.array([x]) for key, x in numbers.items()}, np.zeros(1, dtype=bool)
            )
            for name, numbers in ONE_START.items()
        }
    )
    assert read_quantity(text)(known) == pytest.approx([value], rel=1e-3, nan_ok=True)
