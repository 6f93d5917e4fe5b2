"""Claims: every predicate can say yes and no, and the verdict follows the rule."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from crosscheck.paper import events
from crosscheck.paper.claims import chapter as claims
from crosscheck.paper.claims import measures as claims_measures
from crosscheck.paper.claims import pd as claims_pd
from crosscheck.paper.claims.cells import FULL, experiments
from crosscheck.paper.claims.quantities import (
    BACK,
    BACKLASH,
    ERROR,
    PD,
    STATIC,
    Family,
    Known,
    NotSimulatedError,
    Quantity,
)
from crosscheck.paper.claims.rule import (
    DAMPING,
    READING,
    Answer,
    Cell,
    Claim,
    Limits,
    answers,
    rank,
    spread,
    verdict,
    where,
)
from crosscheck.paper.scale import QUICK
from crosscheck.studies.study import Study

IDS = [f"{claim.section}: {claim.statement}" for claim in claims.CLAIMS]
EXPERIMENTS = {e.source for e in experiments(FULL, Cell("angle", "paper-labelled", 0.006))}
SIZES_UM = {
    BACKLASH: (5.0, 10.0, 25.0, 50.0, 500.0, 1000.0, 3000.0),
    ERROR: (0.8, 1.6, 3.2, 5.0, 6.3),
    BACK: (0.0, 50.0, 100.0, 500.0),
}
SWEPT = {
    BACKLASH: (
        *("first", "second", "third", "second_force_N", "third_force_N", "third_force_fast_N"),
        *("side_change_s", "second_decay_s", "flight_s", "frequency_Hz"),
    ),
    ERROR: ("third", "third_force_fast_N"),
    BACK: ("error_early", "error_1_s", "error_2_s"),
}
DRAWS = 20000


class Synthetic(Known):
    """Made-up numbers of every experiment of the full chapter, near the thresholds of a claim."""

    def __init__(self, claim: Claim, generator: np.random.Generator) -> None:
        super().__init__()
        ends = [end for end in (claim.decide.low, claim.decide.high) if math.isfinite(end)]
        self.scales = [*ends, *(-end for end in ends), 1.0, 10.0, 100.0, 1000.0]
        self.generator = generator
        for family in SIZES_UM:
            for name in SWEPT[family]:
                self._trend(family, name)

    def __missing__(self, quantity: Quantity) -> float:
        if quantity.source not in EXPERIMENTS | {STATIC, BACKLASH(50), ERROR(5)}:
            raise NotSimulatedError(quantity)
        self[quantity] = self._number()
        return self[quantity]

    def _number(self) -> float:
        width = self.generator.choice([0.003, 0.1, 2.0])
        return float(self.generator.choice(self.scales) * np.exp(width * self.generator.normal()))

    def _trend(self, family: Family, name: str) -> None:
        """Proportional to a power of the size, apart from one member."""
        slope, base = self.generator.choice([-1.0, -0.3, 0.0, 0.3, 1.0]), abs(self._number())
        for size in SIZES_UM[family]:
            self[family(size)(name)] = base * (max(size, 0.1) / 50) ** slope
        odd = self.generator.choice(SIZES_UM[family])
        self[family(odd)(name)] *= self.generator.choice([1.0, 1e-3])


@pytest.mark.parametrize("claim", claims.CLAIMS, ids=IDS)
def test_threshold_has_two_sides(claim):
    for end, inward in ((claim.decide.low, 1), (claim.decide.high, -1)):
        if math.isfinite(end):
            step = 1e-6 * max(abs(end), 1e-12)
            assert claim.decide(end + inward * step)
            assert not claim.decide(end - inward * step)
    assert claim.decide(math.nan) is None


@pytest.mark.parametrize("claim", claims.CLAIMS, ids=IDS)
def test_claim_can_be_answered_both_ways(claim):
    if not _is_measured(claim):
        return
    generator = np.random.default_rng(1)
    seen = set()
    for _ in range(DRAWS):
        numbers = Synthetic(claim, generator)
        seen |= {a.yes for a in answers(claim, [Cell("angle", "x", 0.006, numbers)])}
        if seen >= {True, False}:
            return
    pytest.fail(f"only {seen}")


def _is_measured(claim: Claim) -> bool:
    """Not a question of whether the program stopped, which numbers cannot answer."""
    return "diverge" not in claim.statement


def test_divergence_is_answered_both_ways():
    claim = next(claim for claim in claims.CLAIMS if not _is_measured(claim))
    formula = claim.formulas[""]
    assert claim.decide(formula(Known({PD("diverged_s"): 0.1})))
    assert not claim.decide(formula(Known({PD("first"): 20.0})))


def test_number_of_claims_and_their_figures():
    assert len(claims.CLAIMS) >= 80
    assert len(set(IDS)) == len(IDS)
    assert all(claim.figure is None or 4 <= claim.figure <= 20 for claim in claims.CLAIMS)


def _answer(phase="angle", reading="a", zeta=0.05, choice="", yes=True):
    return Answer(phase, reading, zeta, choice, 0.0, yes)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ([_answer(), _answer("omega_t", yes=False)], "holds"),
        ([_answer(yes=False), _answer("omega_t")], "only with omega_t"),
        ([_answer(yes=False), _answer("omega_t", yes=False)], "does not hold"),
        ([_answer(), _answer(zeta=0.01, yes=False)], "depends"),
        ([_answer("omega_t")], "not simulated"),
        ([], "not simulated"),
    ],
)
def test_verdict_rule(given, expected):
    assert verdict(given).verdict == expected


@pytest.mark.parametrize(
    ("others", "expected"),
    [
        ([_answer(zeta=0.01, yes=False)], (DAMPING,)),
        ([_answer(reading="b", yes=False)], (READING,)),
        ([_answer(choice="x", yes=False)], ("sigma",)),
        ([_answer(reading="b", zeta=0.01, yes=False)], (READING, DAMPING)),
        (
            [
                _answer(reading="b"),
                _answer(zeta=0.01, yes=False),
                _answer("a", "b", 0.01, "", False),
            ],
            (DAMPING,),
        ),
    ],
)
def test_dependence_names_what_decides(others, expected):
    assert verdict([_answer(), *others], "sigma").depends_on == expected


def test_unknown_quantity_of_a_simulated_experiment_is_an_error():
    numbers = Known({PD("first"): 1.0})
    with pytest.raises(KeyError):
        numbers[PD("frist")]
    with pytest.raises(NotSimulatedError):
        numbers[BACKLASH(5)("third")]
    assert math.isnan(Known({PD("diverged_s"): 0.3})[PD("first")])


def test_sweeps_need_three_members():
    numbers = Known({BACKLASH(5)("third"): 3.0, BACKLASH(50)("third"): 2.0})
    with pytest.raises(NotSimulatedError):
        rank(BACKLASH, "third")(numbers)
    numbers[BACKLASH(500)("third")] = 1.0
    assert rank(BACKLASH, "third")(numbers) == pytest.approx(-1.0)
    assert spread(BACKLASH, "third")(numbers) == pytest.approx(3.0)
    numbers[BACKLASH(500)("third")] = 2.5
    assert abs(rank(BACKLASH, "third")(numbers)) < 0.9


def test_condition_hides_a_number():
    formula = where(PD("third"), Limits(low=10.0), lambda n: n[PD("frequency_Hz")])
    assert formula(Known({PD("third"): 11.0, PD("frequency_Hz"): 900.0})) == 900.0
    assert math.isnan(formula(Known({PD("third"): 9.0, PD("frequency_Hz"): 900.0})))


TIME = np.arange(0, 1.2, 4e-5)


def test_side_change_is_the_first_negative_force_after_the_start():
    force = np.where(TIME < 0.35, 100.0, np.where(TIME < 0.36, 0.0, -100.0))
    force[TIME < 0.01] = -1.0  # the starting vibration
    change = events.side_change(TIME, force)
    assert change is not None
    assert change.met_s == pytest.approx(0.36, abs=1e-4)
    assert change.left_s == pytest.approx(0.35, abs=1e-4)
    assert events.side_change(TIME, np.abs(force)) is None


def test_return_follows_the_last_contact_on_the_other_side():
    time = np.arange(0, 3.0, 1e-3)
    force = np.where(time < 1.6, -1.0, np.where(time < 1.62, 0.0, 1.0))
    force[(time > 1.3) & (time < 1.35)] = 1.0  # the third fluctuation's own side changes
    assert events.teeth_return(time, force) == pytest.approx(1.62, abs=2e-3)
    assert events.teeth_return(time, -np.ones_like(time)) is None
    assert events.teeth_return(time, np.ones_like(time)) is None


def test_third_window_leaves_out_a_late_impact():
    begins = [TIME[events.third_window(TIME, side).start] for side in (0.35, 0.55, None)]
    assert begins == pytest.approx([0.5, 0.65, 0.5], abs=1e-4)


def test_decay_is_the_time_to_a_tenth():
    values = np.exp(-TIME / 0.1) * np.cos(2 * np.pi * 1000 * TIME)
    assert claims_measures.decay(TIME, values) == pytest.approx(0.1 * math.log(10), abs=2e-3)


@pytest.mark.parametrize(("frequency", "share"), [(1000.0, 1.0), (2.0, 0.0)])
def test_fast_part_keeps_vibration_and_drops_motion(frequency, share):
    values = np.sin(2 * np.pi * frequency * TIME)
    inner = slice(2000, -2000)
    left = np.abs(claims_measures.fast(TIME, values)[inner]).max()
    assert left == pytest.approx(share, abs=0.05)


def test_turning_points_count_ripple_and_not_noise():
    slow = 5e-6 * np.sin(2 * np.pi * 20 * TIME) + 1e-7 * np.sin(2 * np.pi * 2000 * TIME)
    assert claims_measures._turns(TIME, slow, 0.2, 0.7) == pytest.approx(20, abs=1)
    assert claims_measures._turns(TIME, 0.01 * slow, 0.2, 0.7) == 0


def test_spectrum_tells_a_line_from_a_continuum():
    frequency = np.linspace(0, 5000, 5001)
    line = (frequency == 1500.0).astype(float)
    assert claims_pd._share(frequency, line, 1450, 1550) == pytest.approx(1.0)
    assert claims_pd._share(frequency, np.ones(5001), 1450, 1550) < 0.05
    assert claims_pd._line(frequency, line, 1490.0) == 1.0
    assert claims_pd._line(frequency, line, 3000.0) < 1e-200


def test_side_changes_ignore_free_flight():
    assert events.count_side_changes(np.array([1.0, 0.0, 0.0, -1.0, 0.0, -2.0, 3.0])) == 2
    assert events.count_side_changes(np.array([1.0, 0.0, 2.0, 0.0])) == 0


@pytest.mark.slow
def test_quick_chapter(tmp_path: Path):
    chapter = claims.chapter(Study(tmp_path), QUICK)
    assert len(chapter.records) == len(claims.CLAIMS)
    assert len({record["id"] for record in chapter.records}) == len(chapter.records)
    json.dumps(chapter.records, allow_nan=False)
    by_statement = {record["statement"]: record["verdict"] for record in chapter.records}
    assert by_statement["Eq. 13 gives the ring mesh's frequency, similarly."] == "does not hold"
    assert by_statement["x_sp converges to 52 um."] == "holds"
    assert 'href="#figure-14"' in chapter.html
