"""Each kind of error is called by its name; what fits nothing is said to fit nothing."""

from fractions import Fraction

import numpy as np
import pytest

from crosscheck.models.loading import load_arm
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.changes.arms.segments import TermKey, derive_bias
from crosscheck.trial.changes.arms.term_changes import find_reflecting_joint
from crosscheck.trial.changes.arms.term_words import describe_term_error
from crosscheck.trial.judge.entries import EntryPlace
from tests.trial import planted

PAPER, UNLIKE = load_arm("paper-labelled"), load_arm("three-unlike")
ARMS = pytest.mark.parametrize("arm", [PAPER, UNLIKE], ids=lambda arm: arm.name)
COUPLING = EntryPlace("mass_matrix", 0, 1)  # of phi_1, phi_2


def _term(known, place: EntryPlace, *letters: str):
    """The one term with these letters and a wave."""
    found = [p for p in known.entry(place) if set(letters) <= set(p.letters) and any(p.key.wave)]
    assert len(found) == 1
    return found[0]


def _with(known, place: EntryPlace, old, *new):
    return (*(p for p in known.entry(place) if p != old), *new)


@ARMS
def test_a_centre_of_mass_where_a_length_belongs(arm):
    known, last = planted.terms(arm, planted.ABSOLUTE), len(arm.joints)
    place = EntryPlace("mass_matrix", 0, last - 1)
    old = _term(known, place, "m_payload")
    yours = _with(known, place, old, planted.swapped(old, f"L{last}", f"d{last}"))
    assert [describe_term_error(e) for e in planted.explained(known, place, yours, arm)[0]] == [
        f"missing term: m_payload L1 (L{last} - d{last})"
        f" cos(phi_1 - phi_{last}); d{last} where L{last} belongs"
    ]


@ARMS
@pytest.mark.parametrize(
    ("by", "kind"), [(-1, "sign"), (2, "factor"), (0.5, "swapped"), (3, "factor"), (0, "dropped")]
)
def test_a_term_by_a_factor(arm, by, kind):
    known = planted.terms(arm, planted.ABSOLUTE)
    old = _term(known, COUPLING, "m2")
    yours = _with(known, COUPLING, old, planted.times(old, by))
    error = planted.explained(known, COUPLING, yours, arm)[0][0]
    # Where d is half of L on the paper's arm, half a term may be d for L.
    assert error.kind == (kind if arm is PAPER or by != 0.5 else "factor")
    said = error.term.coefficient, error.term.wave, error.term.angle
    assert said == ("m2 L1 d2", "cos", "phi_1 - phi_2")


@ARMS
@pytest.mark.parametrize(
    ("swap", "row", "column"),
    [(("r_s1", "r_p1"), 0, 0), (("r_p1", "r_r1"), 1, 2), (("r_cp1", "r_c1"), 2, 2)],
)
def test_a_radius_by_another_throughout_an_entry(arm, swap, row, column):
    known = planted.terms(arm, planted.GEARS if row < 2 else planted.LUMPED)
    place = EntryPlace("mass_matrix", row, column)
    right, yours = swap
    entry = known.entry(place) or known.entry(place := EntryPlace("mass_matrix", row, row))
    mine = tuple(planted.swapped(p, right, yours) for p in entry)
    error = planted.explained(known, place, mine, arm)[0][0]
    assert (error.yours, error.right) == (yours, right)


WAVES = {
    "cos(theta_1)": TermKey((1, 0)),
    "cos(2 theta_1 + theta_2)": TermKey((2, 1)),
    "1": TermKey((0, 0)),
    "sin(theta_2)": TermKey((0, 1), "sin"),
}


@ARMS
@pytest.mark.parametrize("wave", WAVES)
def test_another_angle_or_function(arm, wave):
    known, key = planted.terms(arm, planted.RELATIVE), WAVES[wave]
    old = _term(known, COUPLING, "m2")
    key = key._replace(wave=key.wave + (0,) * (len(arm.joints) - 2))
    yours = _with(known, COUPLING, old, old._replace(key=key))
    error = planted.explained(known, COUPLING, yours, arm)[0][0]
    assert (error.kind, error.yours, error.right) == ("angle", wave, "cos(theta_2)")


@ARMS
def test_a_power_too_few(arm):
    known = planted.terms(arm, planted.GEARS)
    place = EntryPlace("mass_matrix", 0, 0)  # M_s1 r_s1^2
    (old,) = known.entry(place)
    fewer = old._replace(monomial=old.monomial._replace(powers=(("M_s1", 1), ("r_s1", 1))))
    error = planted.explained(known, place, (fewer,), arm)[0][0]
    said = "missing term: M_s1 (r_s1^2 - r_s1); r_s1 where r_s1^2 belongs"
    assert describe_term_error(error) == said


@ARMS
@pytest.mark.parametrize(("by", "kind"), [(-1, "sign"), (Fraction(3, 2), "factor")])
def test_a_whole_entry_by_a_factor_is_one_error(arm, by, kind):
    known = planted.terms(arm, planted.ABSOLUTE)
    yours = tuple(planted.times(p, by) for p in known.entry(COUPLING))
    found = planted.explained(known, COUPLING, yours, arm)
    assert [(error.kind, error.by) for error in found[0]] == [(kind, by)]


def test_a_lever_of_a_term_that_two_reactions_leave_none_of():
    """The elbow's force acts on both links: with another lever on one of them, a term stays."""
    known, place = planted.terms(UNLIKE, planted.RELATIVE), EntryPlace("bias", 0, rates=(0, 0))
    square = known.entry(EntryPlace("bias", 1, rates=(0, 0)))
    pulled = [product for product in square if product.key.wave == (0, 1, 0)]
    assert not known.entry(place)
    yours = (
        *(planted.times(product, -1) for product in pulled),
        *(planted.swapped(product, "L1", "d1") for product in pulled),
    )
    found = planted.explained(known, place, yours, UNLIKE)
    assert [(e.kind, e.yours, e.right) for e in found[0]] == [("swapped", "d1", "L1")]


def test_reflected_inertia_of_a_joint_divided_by_its_ratio_twice():
    known = planted.terms(UNLIKE, planted.RELATIVE, "armature")
    place, ratio = EntryPlace("mass_matrix", 2, 2), collect_arm_values(UNLIKE)["n3"]
    yours = tuple(
        planted.times(p, ratio**-2) if find_reflecting_joint(p) else p for p in known.entry(place)
    )
    error = planted.explained(known, place, yours, UNLIKE)[0][0]
    assert (error.kind, error.yours) == ("factor", "1/n3^2")
    assert error.term.coefficient == "r_cp3^2 (4 M_s3 + N3 M_p3)"


@ARMS
def test_a_term_too_many(arm):
    known = planted.terms(arm, planted.ABSOLUTE)
    foreign = known.entry(EntryPlace("mass_matrix", 1, 1))[0]
    assert foreign.letters == ("I_l2",)
    found = planted.explained(known, COUPLING, (*known.entry(COUPLING), foreign), arm)
    assert "extra term: I_l2" in [describe_term_error(e) for errors in found for e in errors]


@ARMS
def test_two_errors_before_two_waves_or_one_are_two(arm):
    known = planted.terms(arm, planted.ABSOLUTE)
    moving, still = _term(known, COUPLING, "m2"), known.entry(COUPLING)[0]
    load = _term(known, COUPLING, "m_payload")
    for other in (still, load):
        by = {moving: 2, other: -1}
        yours = tuple(planted.times(p, by.get(p, 1)) for p in known.entry(COUPLING))
        found = planted.explained(known, COUPLING, yours, arm)
        assert {"factor", "sign"} in [{error.kind for error in errors} for errors in found]


def test_equal_numbers_are_distinguished_by_a_second_arm():
    """m_payload = m_r2 = 10 kg on the paper's arm: either may be missing."""
    known, place = planted.terms(PAPER, planted.ABSOLUTE), EntryPlace("mass_matrix", 0, 0)
    old = next(p for p in known.entry(place) if p.letters == ("L1", "m_payload"))
    yours = _with(known, place, old)
    alone = {describe_term_error(e[0]) for e in planted.explained(known, place, yours, PAPER)}
    assert {"missing term: m_payload L1^2", "missing term: m_r2 L1^2"} <= alone
    heavier = PAPER.model_copy(update={"payload_mass_kg": 7.3})
    ((error,),) = planted.explained(known, place, yours, PAPER, heavier)
    assert describe_term_error(error) == "missing term: m_payload L1^2"


def test_a_bias_follows_from_a_wrong_mass_matrix():
    """Of M = a cos(x_2), by hand: bias_1 = -a sin(x_2) v_2^2, and nothing of v_1 v_2."""
    key, places = TermKey((0, 1)), (EntryPlace("mass_matrix", *at) for at in ((0, 1), (1, 0)))
    made = derive_bias([(place, key, 3.0) for place in places], np.eye(2))
    of_row = {place.rates: value for (place, _), value in made.items() if place.row == 0}
    assert {rates: value for rates, value in of_row.items() if value} == {(1, 1): -3.0}


@pytest.mark.parametrize(("by", "of"), [(1, "theta_1'^2"), (2, "theta_1' theta_2'"), (-0.5, "")])
def test_a_product_of_rates_that_belongs_to_none_has_a_sum_of_terms(by, of):
    """Its right coefficient is 0; what stands there is that of another product, or a multiple."""
    known = planted.terms(UNLIKE, planted.RELATIVE)
    square = known.entry(EntryPlace("bias", 2, rates=(0, 0)))
    extra = [planted.times(p, by) for p in square if p.key.wave == (0, 0, 1)]
    assert len(extra) > 1
    place = EntryPlace("bias", 2, rates=(1, 2))
    error = planted.explained(known, place, (*known.entry(place), *extra), UNLIKE)[0][0]
    assert (error.kind, error.term.angle) == ("extra", "theta_3")
    assert error.right == (f"bias[theta_3] of {of}" if of else "")
