"""The catalogue of claims: every one is made of known numbers, and has reasons."""

import math
import re
from contextlib import suppress
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from crosscheck.audit.claims.catalogue import BY_ID, CLAIMS, RETIRED, TEXTS
from crosscheck.audit.claims.claim_quantities import QUANTITIES
from crosscheck.audit.claims.measured import MEASURED
from crosscheck.audit.claims.study_plan import FULL
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    PLANTED,
    STATIC,
    WIDE_BEGINNING,
    PaperExperiment,
)
from crosscheck.audit.experiments.paper_conditions import PRINTED, Condition
from crosscheck.audit.experiments.samples import collect_samples
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.judging.quantities import ConditionResults, NotSimulatedError
from crosscheck.audit.judging.rule import evaluate_claim
from crosscheck.audit.judging.sample import Sample
from crosscheck.audit.statics.statics import Statics
from tests.loops import require_items

IDS = [claim.id for claim in CLAIMS]
DRAWS = 50
CELL = Condition(PRINTED, FULL.shaken[0])
BRIEF = Scale(longest_s=0.002, most_starts=2)


@cache
def sources() -> tuple[PaperExperiment, ...]:
    """Every experiment of the full page."""
    made = dict.fromkeys(FULL.experiments(CELL))
    return (*made, WIDE_BEGINNING, BACKLASH(DEFAULT_B_UM), ERROR(DEFAULT_E_UM), STATIC, PLANTED)


class Drawn(Sample):
    """Made-up numbers of an experiment, of any size, or undefined; asked: their names."""

    def __init__(self, source: PaperExperiment) -> None:
        super().__init__({}, np.zeros(DRAWS, dtype=bool))
        vars(self).update(source=source, asked=set())  # a sample is frozen

    def __getitem__(self, name: str) -> np.ndarray:
        assert name in MEASURED
        self.asked.add(name)
        own = np.random.default_rng([1, *name.encode(), *str(self.source).encode()])
        found = 10 ** own.uniform(-1, 3, DRAWS)
        found[own.random(DRAWS) < 0.02] = math.nan
        return found


def _drawn() -> ConditionResults:
    return ConditionResults({source: Drawn(source) for source in sources()})


def test_ids_are_sections_with_a_number_and_never_used_twice():
    assert len({*IDS, *RETIRED}) == len(IDS) + len(RETIRED)
    for name in (*IDS, *RETIRED):
        assert re.fullmatch(r"(Abstract|\d(\.\d)?)-\d\d", name)
    assert dict(zip(IDS, CLAIMS, strict=True)) == BY_ID


def test_every_limit_has_a_reason_and_every_quantity_a_unit():
    for claim in require_items(CLAIMS):
        assert claim.limits.because, claim.id
        assert claim.figure is None or 4 <= claim.figure <= 20, claim.id
        assert all(quantity.unit for quantity in claim.choices.values())


def test_what_one_quantity_is_called_is_its_own():
    """Equal ids are equal quantities: the same numbers whatever they are made of."""
    known = _drawn()
    first: dict[str, np.ndarray] = {}
    for claim in require_items(CLAIMS):
        for quantity in require_items(claim.choices.values()):
            try:
                values = quantity(known)
            except NotSimulatedError:
                continue
            assert np.array_equal(first.setdefault(quantity.id, values), values, equal_nan=True)


def test_what_claims_ask_of_the_widest_backlash_ends_before_the_short_run():
    """For there the numbers of the run of 1.2 s are those of the run of 3 s.

    The torque's fast part is filtered over the whole run, also where a window of it is looked at.
    """
    known = _drawn()
    known[WIDE_BEGINNING] = wide = Drawn(WIDE_BEGINNING)
    for claim in require_items(CLAIMS):
        for quantity in claim.choices.values():
            quantity(known)
    whole = {name for name in MEASURED if MEASURED[name].window == "whole run"}
    assert "third" in wide.asked
    assert not wide.asked & (whole | {"torque_follows", "torque_frequency_Hz"})


def test_a_claim_on_one_joint_asks_for_no_number_of_the_other():
    """Numbers of a joint have its number in their names, or the elbow's name."""
    others = {"shoulder|first link": r"_2(_|$)|_elbow", "elbow|second link": r"_1(_|$)|_shoulder"}
    of_joints = []
    for claim in require_items(CLAIMS):
        for quantity in claim.choices.values():
            named = [each for each in others if re.search(each, claim.statement.lower())]
            known = _drawn()
            with suppress(NotSimulatedError):
                quantity(known)
            asked = {name for sample in known.values() for name in sample.asked}
            if len(named) == 1:
                of_joints.append(claim.id)
                wrong = {name for name in asked if re.search(others[named[0]], name)}
                assert not wrong, f"{claim.id}: {claim.statement}"
    assert len(set(of_joints)) > 10


def test_every_statement_is_decided_once_and_nothing_else_is():
    decided = [name for name, said in TEXTS.said.items() if said.pd or said.torque or said.static]
    assert sorted([*decided, *QUANTITIES]) == sorted(IDS)
    assert {said.limits for said in TEXTS.said.values()} == {"", *TEXTS.limits}


def test_a_static_claim_is_asked_once_per_reading_and_choice():
    claim = next(claim for claim in CLAIMS if claim.static)
    known = ConditionResults(
        dict.fromkeys(
            (STATIC, PLANTED), Sample({n: np.array([1.0]) for n in MEASURED}, np.zeros(1, bool))
        )
    )
    cells = [Condition(PRINTED, zeta) for zeta in (0.005, 0.05)]
    found = evaluate_claim(claim, [(cell, known) for cell in cells])
    assert len(found) == len(claim.choices)
    assert all(answer.starts == 1 for answer in found)


@pytest.fixture(scope="module")
def brief(kept: Path) -> ConditionResults:
    """Every experiment of a setting, in runs of two milliseconds."""
    study = Study(kept)
    found = collect_samples(
        study, BRIEF, [(CELL, source) for source in FULL.experiments(CELL)], "test"
    )
    return ConditionResults({source: sample for (_, source), sample in found.items()})


@pytest.mark.slow
def test_an_experiment_measures_what_the_catalogue_says(brief, kept):
    """Every number of every experiment has a meaning, and every meaning is measured."""
    (static,) = Study(kept).answer_questions([Statics(CELL.arm)], "test")
    measured = {name for sample in brief.values() for name in sample.numbers}
    assert {*measured, *static, "planted_shown"} == set(MEASURED)
