"""Every claim is made of known numbers, has reasons, and leads from a sentence."""

import math
import re
from contextlib import suppress
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from crosscheck.audit.claims.catalogue import (
    BY_ID,
    CLAIMS,
    ModelJudgement,
    model_of,
    read_quantity,
)
from crosscheck.audit.claims.chapter import build_claim_record, render_claims
from crosscheck.audit.claims.measured import FUNCTIONS, MEASURED, NAMED
from crosscheck.audit.claims.statements import SENTENCES, TEXTS
from crosscheck.audit.claims.study_plan import FULL
from crosscheck.audit.errata.errata_texts import load_notes
from crosscheck.audit.errata.finder import find_errata
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    CONSTANT,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    NO_ERROR,
    PD,
    PLANTED,
    STATIC,
    WIDE_BEGINNING,
    PaperExperiment,
)
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    LAWS,
    MODELS,
    PRINTED,
    REPAIRED_RATE,
    VARIANTS,
    Condition,
)
from crosscheck.audit.experiments.samples import Scale, collect_samples
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.judging.quantities import ConditionResults, NotSimulatedError, Sample
from crosscheck.audit.judging.rule import Place, State, VerdictKind, evaluate_claim, verdict
from crosscheck.audit.judging.sentences import Sentence, load_sentences
from crosscheck.audit.statics.statics import Statics
from crosscheck.models.loading import load_arm
from crosscheck.report.records import format_json
from tests.audit.published import BRIEF
from tests.loops import require_items

IDS = [claim.id for claim in CLAIMS]
DRAWS = 50
CELL = Condition(PRINTED, FULL.shaken[0])


@cache
def sources() -> tuple[PaperExperiment, ...]:
    """Every experiment of the full page."""
    made = dict.fromkeys(FULL.experiments(CELL))
    return (*made, WIDE_BEGINNING, BACKLASH(DEFAULT_B_UM), ERROR(DEFAULT_E_UM), STATIC, PLANTED)


@pytest.mark.parametrize("model", dict.fromkeys((*MODELS, *VARIANTS)))
def test_a_model_is_asked_in_every_reading_at_every_damping_ratio(model):
    settings = FULL.model_conditions(model)
    assert {model_of(Place(tuple(each.conditions.items()))) for each in settings} == {model}
    asked = {(each.arm, each.zeta) for each in settings}
    assert asked == {*product(FULL.readings, FULL.zetas)}
    assert len(settings) == len(asked)


ODD = (math.nan, math.nan, math.inf, -math.inf, 0.0, -0.0)


class Drawn(Sample):
    """Made-up numbers of an experiment, one in four of them odd; asked: their names."""

    def __init__(self, source: PaperExperiment, seed: int = 1) -> None:
        super().__init__({}, np.zeros(DRAWS, dtype=bool))
        vars(self).update(source=source, seed=seed, asked=set())  # a sample is frozen

    def __getitem__(self, name: str) -> np.ndarray:
        assert name in MEASURED
        self.asked.add(name)
        own = np.random.default_rng([self.seed, *name.encode(), *str(self.source).encode()])
        found = own.choice([-1, 1], DRAWS) * 10 ** own.uniform(-6, 6, DRAWS)
        return np.where(own.random(DRAWS) < 0.25, own.choice(ODD, DRAWS), found)


def _drawn() -> ConditionResults:
    return ConditionResults({source: Drawn(source) for source in sources()})


def test_ids_are_sections_with_a_number_and_never_used_twice():
    assert len({*IDS, *TEXTS.retired}) == len(IDS) + len(TEXTS.retired)
    for name in (*IDS, *TEXTS.retired):
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


def test_every_named_quantity_and_limit_is_asked_of_a_statement():
    asked = str([*TEXTS.named.values(), *(said.quantity for said in TEXTS.said.values())])
    assert [name for name in (*NAMED, *TEXTS.named, *FUNCTIONS) if f"'{name}'" not in asked] == []
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


@pytest.mark.parametrize("equations", ["printed", "corrected"])
def test_experiments_are_where_claims_ask_for_them(equations):
    """Some in shaken settings alone, some in those with corrected equations."""
    for zeta in (FULL.shaken[0], next(z for z in FULL.zetas if z not in FULL.shaken)):
        planned = list(FULL.experiments(replace(CELL, zeta=zeta, equations=equations)))
        asked = {"every", "shaken", "corrected"} if zeta in FULL.shaken else {"every"}
        asked -= {"corrected"} if equations == "printed" else set()
        assert {each.where for each in planned} - {""} == asked
        assert len(set(planned)) == len(planned)


@pytest.mark.slow
def test_an_experiment_measures_what_the_catalogue_says(brief, kept):
    """Every number of every experiment has a meaning, and every meaning is measured."""
    (static,) = Study(kept).answer_questions([Statics(CELL.arm)], "test")
    measured = {name for sample in brief.values() for name in sample.numbers}
    assert {*measured, *static, "planted_shown"} == set(MEASURED)


# Counted in the paper, captions and the table among them.
OF_THE_PAPER = {
    "Abstract": 6, "1": 40,
    "2": 20, "2.1": 20, "2.2": 16, "2.3": 9, "2.4": 27,
    "3": 11, "3.1": 18, "3.2": 35,
    "4": 4, "4.1": 29, "4.2": 23, "5": 8,
}  # fmt: skip


@pytest.fixture(scope="module")
def table() -> tuple[Sentence, ...]:
    return load_sentences(SENTENCES)


def test_the_table_has_every_sentence_in_order_by_its_first_words(table):
    numbers = [(section, at + 1) for section, count in OF_THE_PAPER.items() for at in range(count)]
    assert [(one.section, one.number) for one in table] == numbers
    assert all(1 <= len(one.begins.split()) <= 4 for one in table)


def test_every_claim_is_named_by_a_sentence_and_every_name_is_a_claim(table):
    assert {name for one in table for name in one.claims} == set(BY_ID)


def test_every_item_of_the_errata_sheet_is_named_by_a_sentence_and_no_other(table):
    noted = load_notes()
    known = {erratum.id for erratum in find_errata(load_arm("paper-labelled"))}
    known |= {entry.id for entry in noted.entries}
    known |= {note["id"] for note in (*noted.contradictions, *noted.gaps)}
    assert {name for one in table for name in one.errata} == known


# Errors and statements of the sheet that deny no claim, each with the reason.
DENY_NONE = {
    "eq6-attracts": "grants claim 2.1-09 and adds what the text leaves out",
    "eq8-eq14-one-phase": "the text asserts nothing of gamma",
    "drive-root": "a guess at the torque that was meant",
    "table-ring": "which of two quantities a number is",
    "rod-or-bar": "which body is meant",
    "between-50-and-500": "not shown by the paper; claim 4.1-27 asks whether it is so",
    "below-1-um": "not shown by the paper; claim 4.2-06 asks whether it is so",
    "influence-avoided": "of models in general",
    "suitable-for-long-strokes": "of the model's use",
    "shorter-because": "the reason, and not the fact, which is claim 4.1-10",
    "error-for-precision": "of manufacture",
    "accumulates-or-erased": "a conclusion that does not follow",
}


def test_what_the_sheet_denies_is_a_claim_of_the_same_sentence(table):
    """So a claim that holds cannot stand beside an entry that says it is wrong unnoticed."""
    read = [entry for entry in load_notes().entries if entry.kind != "notation"]
    sheet = [*find_errata(load_arm("paper-labelled")), *read]
    assert {one.id for one in sheet if not one.denies} == set(DENY_NONE)
    for one in require_items(one for one in sheet if one.denies):
        named = [sentence for sentence in table if one.id in sentence.errata]
        assert any(set(one.denies) <= set(sentence.claims) for sentence in named), one.id


def _known(generator: np.random.Generator) -> ConditionResults:
    """An experiment in four is missing, and one in four diverged everywhere."""
    diverged = Sample({}, np.ones(DRAWS, dtype=bool))
    fates = {source: generator.integers(4) for source in sources()}
    return ConditionResults(
        {
            source: diverged if fate == 1 else Drawn(source, int(generator.integers(99)))
            for source, fate in fates.items()
            if fate
        }
    )


@settings(max_examples=2, print_blob=True, phases=(Phase.reuse, Phase.generate))
@given(seed=st.integers(0, 2**63))
@pytest.mark.slow
def test_every_claim_gets_a_verdict_whatever_is_missing(seed):
    generator = np.random.default_rng(seed)
    cells = [Condition(law, zeta) for law in LAWS[:1] for zeta in (0.006, 0.05)]
    asked = [(cell, _known(generator)) for cell in cells]
    found = [ModelJudgement(claim, tuple(evaluate_claim(claim, asked))) for claim in CLAIMS]
    for judged in found:
        for answer in judged.answers:
            assert all(map(math.isfinite, answer.values))
            assert answer.undefined + len(answer.values) == answer.starts
            assert (answer.state == State.UNDEFINED) == (answer.share is None)
    format_json({"claims": [build_claim_record(judged) for judged in found]})
    html = render_claims(found, FULL, Scale())
    assert html.count('<tr id="claim-') == len(CLAIMS)


@pytest.mark.parametrize("fate", ["diverged", "nothing"])
@pytest.mark.slow
def test_a_setting_without_any_number_supports_nothing(fate):
    """Every run diverged, or none has anything to tell: nothing but the arm's data is left."""
    nothing = {} if fate == "diverged" else {name: np.full(DRAWS, math.nan) for name in MEASURED}
    sample = Sample(nothing, np.full(DRAWS, fate == "diverged"))
    known = ConditionResults(dict.fromkeys(sources(), sample))
    for claim in require_items(CLAIMS):
        found = evaluate_claim(claim, [(Condition(law, 0.05), known) for law in LAWS])
        assert found
        if not claim.static and "diverge" not in next(iter(claim.choices.values())).id:
            assert {answer.state for answer in found} == {State.UNDEFINED}
            assert verdict(found).kind == VerdictKind.UNDEFINED


@pytest.mark.parametrize("fold", ["rank", "greatest"])
@pytest.mark.slow
def test_a_diverged_member_leaves_that_starts_sweep_undefined(fold):
    """Of two starts, the second at the widest backlash."""
    known = ConditionResults()
    for b in (5, 50, 500, 3000):
        fate = np.array([False, b == 3000])
        known[BACKLASH(b)] = Sample({"third": np.where(fate, math.nan, 1.0 / b)}, fate)
    assert list(np.isfinite(read_quantity([fold, "backlash: third"])(known))) == [True, False]


SETTINGS = [Condition(law, 0.02) for law in LAWS]
EXPERIMENTS = (PD, NO_ERROR, CONSTANT)
ALL_YES, ALL_NO = dict.fromkeys(LAWS, State.YES), dict.fromkeys(LAWS, State.NO)


@pytest.fixture(scope="module")
def long_results(kept: Path) -> list[tuple[Condition, ConditionResults]]:
    requests = [(setting, source) for setting in SETTINGS for source in EXPERIMENTS]
    found = collect_samples(Study(kept), Scale(most_starts=8), requests, "test")
    return [
        (each, ConditionResults({source: found[each, source] for source in EXPERIMENTS}))
        for each in SETTINGS
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("claim", "said"),
    [
        ("3.1-09", ALL_YES),  # x_sp converges to 52 um
        ("3.2-16", ALL_YES),  # the teeth change sides after 0.3 s
        ("3.2-01", ALL_NO),  # no considerable overshoot
        ("3.2-11", {PRINTED: State.NO, REPAIRED_RATE: State.YES, INTEGRAL: State.NO}),  # severe
        ("5-04", {PRINTED: State.YES, REPAIRED_RATE: State.YES, INTEGRAL: State.NO}),  # at all
    ],
)
def test_claims_have_the_answers_on_record(long_results, claim, said):
    found = evaluate_claim(BY_ID[claim], long_results)
    assert {law: answer.state for law, answer in zip(LAWS, found, strict=True)} == said
