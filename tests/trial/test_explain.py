"""Each kind of error is called by its name; what fits nothing is said to fit nothing."""

from fractions import Fraction

import numpy as np
import pytest

from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import load_arm
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.diagnose.terms.candidates import find_reflecting_joint
from crosscheck.trial.diagnose.terms.explain import (
    compute_bias_differences,
    explain,
    group_by_errors,
    is_caused_by_mass,
)
from crosscheck.trial.diagnose.terms.harmonic_fit import HarmonicFit
from crosscheck.trial.diagnose.terms.messages import (
    describe_term_error,
    format_monomial,
    guess,
    make_difference_terms,
)
from crosscheck.trial.diagnose.terms.polynomial import TermKey
from crosscheck.trial.diagnose.terms.reference_terms import build_reference_terms
from crosscheck.trial.diagnose.terms.values import collect_arm_values
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge.entries import EntryMismatch, EntryPlace
from tests.trial import planted

PAPER, UNLIKE = load_arm("paper-labelled"), load_arm("three-unlike")
ARMS = pytest.mark.parametrize("arm", [PAPER, UNLIKE], ids=lambda arm: arm.name)
COUPLING = EntryPlace("mass_matrix", 0, 1)  # of phi_1, phi_2
COUPLING_KEY = TermKey((0, 1, 0))


def _term(known, place: EntryPlace, *symbols: str):
    """The one term with these symbols and a wave."""
    found = [p for p in known.entry(place) if set(symbols) <= set(p.symbols) and any(p.key.wave)]
    assert len(found) == 1
    return found[0]


def _with(known, place: EntryPlace, old, *new):
    return (*(p for p in known.entry(place) if p != old), *new)


@ARMS
def test_a_centre_of_mass_where_a_length_belongs(arm):
    """The words of the issue: missing term: m_payload (L_2 - d_2) L_1 cos(phi_1 - phi_2)."""
    known, last = planted.terms(arm, planted.ABSOLUTE), len(arm.joints)
    place = EntryPlace("mass_matrix", 0, last - 1)
    old = _term(known, place, "m_payload")
    found = planted.explained(
        known, place, _with(known, place, old, planted.swapped(old, f"L{last}", f"d{last}")), arm
    )
    assert [describe_term_error(error) for error in found.errors] == [
        f"missing term: m_payload L1 (L{last} - d{last})"
        f" cos(phi_1 - phi_{last}); d{last} where L{last} belongs"
    ]
    assert found.left_over < 1e-9


@ARMS
@pytest.mark.parametrize(
    ("by", "kind"), [(-1, "sign"), (2, "factor"), (0.5, "swapped"), (3, "factor"), (0, "dropped")]
)
def test_a_term_by_a_factor(arm, by, kind):
    known = planted.terms(arm, planted.ABSOLUTE)
    old = _term(known, COUPLING, "m2")
    found = planted.explained(
        known, COUPLING, _with(known, COUPLING, old, planted.times(old, by)), arm
    )
    # Where d is half of L on the paper's arm, half a term may be d for L.
    expected = kind if arm is PAPER or by != 0.5 else "factor"
    assert found.errors[0].kind == expected
    assert found.errors[0].term.coefficient == "m2 L1 d2"
    assert (found.errors[0].term.wave, found.errors[0].term.angle) == ("cos", "phi_1 - phi_2")


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
    found = planted.explained(
        known, place, tuple(planted.swapped(p, right, yours) for p in entry), arm
    )
    assert (found.errors[0].yours, found.errors[0].right) == (yours, right)


@ARMS
@pytest.mark.parametrize("wave", [(1, 0), (2, 1), (0, 0)])
def test_another_angle_in_a_cosine(arm, wave):
    known = planted.terms(arm, planted.RELATIVE)
    old = _term(known, COUPLING, "m2")
    turned = wave + (0,) * (len(arm.joints) - 2)
    assert turned != old.key.wave
    found = planted.explained(
        known, COUPLING, _with(known, COUPLING, old, old._replace(key=TermKey(turned))), arm
    )
    assert found.errors[0].kind == "angle"
    assert found.errors[0].right == "cos(theta_2)"
    assert (
        found.errors[0].yours
        == {(1, 0): "cos(theta_1)", (2, 1): "cos(2 theta_1 + theta_2)", (0, 0): "1"}[wave]
    )


@ARMS
def test_a_sine_for_a_cosine(arm):
    known = planted.terms(arm, planted.ABSOLUTE)
    old = _term(known, COUPLING, "m2")
    sine = old._replace(key=old.key._replace(function="sin"))
    found = planted.explained(known, COUPLING, _with(known, COUPLING, old, sine), arm)
    assert (found.errors[0].kind, found.errors[0].right) == ("angle", "cos(phi_1 - phi_2)")


@ARMS
def test_a_power_too_few(arm):
    known = planted.terms(arm, planted.GEARS)
    place = EntryPlace("mass_matrix", 0, 0)  # M_s1 r_s1^2
    (old,) = known.entry(place)
    found = planted.explained(
        known,
        place,
        (old._replace(monomial=old.monomial._replace(powers=(("M_s1", 1), ("r_s1", 1)))),),
        arm,
    )
    assert (
        describe_term_error(found.errors[0])
        == "missing term: M_s1 (r_s1^2 - r_s1); r_s1 where r_s1^2 belongs"
    )


@ARMS
def test_a_whole_entry_with_the_wrong_sign_is_one_error(arm):
    known = planted.terms(arm, planted.ABSOLUTE)
    found = planted.explained(
        known, COUPLING, tuple(planted.times(p, -1) for p in known.entry(COUPLING)), arm
    )
    assert [error.kind for error in found.errors] == ["sign"]


@ARMS
def test_a_factor_of_a_whole_entry_is_no_multiple_of_a_length(arm):
    known, place = planted.terms(arm, planted.RELATIVE), EntryPlace("bias", 0, rates=(0, 1))
    yours = tuple(planted.times(p, Fraction(3, 2)) for p in known.entry(place))
    found = planted.explained(known, place, yours, arm)
    assert [(error.kind, error.by) for error in found.errors] == [("factor", 1.5)]
    texts = [error.yours for errors in found.others for error in errors]
    assert not any(text.startswith("2 ") or text.endswith("/2") for text in texts)


def test_a_lever_of_a_term_that_two_reactions_leave_none_of():
    """The elbow's force acts on both links: with another lever on one of them, a term stays."""
    known, place = planted.terms(UNLIKE, planted.RELATIVE), EntryPlace("bias", 0, rates=(0, 0))
    pulled = [
        product
        for product in known.entry(EntryPlace("bias", 1, rates=(0, 0)))
        if product.key.wave == (0, 1, 0)
    ]
    assert not known.entry(place)
    yours = (
        *(planted.times(product, -1) for product in pulled),
        *(planted.swapped(product, "L1", "d1") for product in pulled),
    )
    found = planted.explained(known, place, yours, UNLIKE)
    assert [(e.kind, e.yours, e.right) for e in found.errors] == [("swapped", "d1", "L1")]


def test_reflected_inertia_of_a_joint_divided_by_its_ratio_twice():
    frame, place = build_frame(Coordinates(), UNLIKE), EntryPlace("mass_matrix", 2, 2)
    known = build_reference_terms(frame, UNLIKE, usual_switches(UNLIKE), "armature")
    ratio = collect_arm_values(UNLIKE)["n3"]
    yours = tuple(
        planted.times(p, ratio**-2) if find_reflecting_joint(p) else p for p in known.entry(place)
    )
    (error,) = planted.explained(known, place, yours, UNLIKE).errors
    assert (error.kind, error.yours) == ("factor", "1/n3^2")
    assert error.term.coefficient == "r_cp3^2 (4 M_s3 + N3 M_p3)"


@ARMS
def test_a_term_too_many(arm):
    known = planted.terms(arm, planted.ABSOLUTE)
    foreign = known.entry(EntryPlace("mass_matrix", 1, 1))[0]
    assert foreign.symbols == ("I_l2",)
    found = planted.explained(known, COUPLING, (*known.entry(COUPLING), foreign), arm)
    everything = [
        describe_term_error(error) for errors in (found.errors, *found.others) for error in errors
    ]
    assert "extra term: I_l2" in everything


@ARMS
def test_two_errors_are_told_apart(arm):
    """Before two waves, and before the same one."""
    known = planted.terms(arm, planted.ABSOLUTE)
    moving, still = _term(known, COUPLING, "m2"), known.entry(COUPLING)[0]
    assert not any(still.key.wave)
    yours = [
        planted.times(p, 2) if p == moving else planted.times(p, -1) if p == still else p
        for p in known.entry(COUPLING)
    ]
    found = planted.explained(known, COUPLING, tuple(yours), arm)
    assert {error.kind for error in found.errors} == {"factor", "sign"}
    load = _term(known, COUPLING, "m_payload")
    by = {moving: 2, load: -1}
    yours = [planted.times(p, by.get(p, 1)) for p in known.entry(COUPLING)]
    found = planted.explained(known, COUPLING, tuple(yours), arm)
    errors = [{(s.kind, s.term.coefficient) for s in e} for e in (found.errors, *found.others)]
    assert {("factor", "m2 L1 d2"), ("sign", format_monomial(load.monomial))} in errors


def test_equal_numbers_are_told_apart_by_a_second_arm():
    """m_payload = m_r2 = 10 kg on the paper's arm: either may be missing."""
    known, place = planted.terms(PAPER, planted.ABSOLUTE), EntryPlace("mass_matrix", 0, 0)
    old = next(p for p in known.entry(place) if p.symbols == ("L1", "m_payload"))
    yours = _with(known, place, old)
    alone = planted.explained(known, place, yours, PAPER)
    told_of = {describe_term_error(errors[0]) for errors in (alone.errors, *alone.others)}
    assert {"missing term: m_payload L1^2", "missing term: m_r2 L1^2"} <= told_of
    heavier = PAPER.model_copy(update={"payload_mass_kg": 7.3})
    both = planted.explained(known, place, yours, PAPER, heavier)
    assert [describe_term_error(error) for error in both.errors] == ["missing term: m_payload L1^2"]
    assert not both.others


def test_a_difference_that_fits_nothing_is_said_to():
    known = planted.terms(UNLIKE, planted.ABSOLUTE)
    seen = planted.observed(UNLIKE, known, COUPLING, known.entry(COUPLING))
    odd = {key: 0.01234567 * np.pi * (1 + number) for number, key in enumerate(seen.coefficients)}
    found = explain(COUPLING, [HarmonicFit(seen.values, odd, seen.noise)], known)
    assert found is None
    off = EntryMismatch(
        COUPLING, 0.1, difference=make_difference_terms({COUPLING_KEY: -0.25}, known)
    )
    assert guess(off).startswith("yours minus right is -0.25 cos(phi_1 - phi_2); no error")
    left = HarmonicFit(seen.values, {COUPLING_KEY: 0.1}, {COUPLING_KEY: 1e-15}, left_over=0.5)
    assert explain(COUPLING, [left], known) is None


@ARMS
def test_a_bias_that_follows_from_a_wrong_mass_matrix(arm):
    """The user derived the bias from an M with an error: it is told once, of M."""
    known = planted.terms(arm, planted.ABSOLUTE)
    old = _term(known, COUPLING, "m_payload")
    wrong = planted.times(old, 2)
    extra = {old.key: float(old.monomial.value(planted.observed(arm, known, COUPLING, ()).values))}
    expected = compute_bias_differences({(0, 1): extra, (1, 0): extra}, known.angles)
    place = EntryPlace("bias", 0, rates=(1, 1))
    own = next(p for p in known.entry(place) if "m_payload" in p.symbols)
    yours = _with(known, place, own, planted.times(own, 2))
    assert is_caused_by_mass(planted.observed(arm, known, place, yours), expected[place])
    assert not is_caused_by_mass(
        planted.observed(arm, known, place, known.entry(place)), expected[place]
    )
    assert wrong.symbols == old.symbols


def test_symmetric_entries_are_told_once():
    known = planted.terms(UNLIKE, planted.ABSOLUTE)
    wrong = []
    for place in (COUPLING, EntryPlace("mass_matrix", 1, 0), EntryPlace("mass_matrix", 2, 2)):
        old = next(p for p in known.entry(place) if "m_payload" in p.symbols)
        yours = _with(known, place, old)
        wrong.append(EntryMismatch(place, 0.1, planted.explained(known, place, yours, UNLIKE)))
    assert [len(each) for each in group_by_errors(wrong)] == [2, 1]


@pytest.mark.parametrize(
    ("mass", "right", "wrong", "told"),
    [
        ("M_s1", lambda s, p, r: 1 + r / s, lambda s, p, r: r / s, "the sun's ratio z_r1/z_s1"),
        ("M_p1", lambda s, p, r: r / p - 1, lambda s, p, r: r / p, "the planets' ratio z_r1/z_p1"),
    ],
)
def test_a_gear_that_spins_by_another_ratio(mass, right, wrong, told):
    """Its inertia has the ratio squared about the joint, as r_cp^2 of the equivalent mass."""
    known, place = planted.terms(UNLIKE, planted.RELATIVE), EntryPlace("mass_matrix", 0, 0)
    teeth = [getattr(UNLIKE.joints[0], f"{gear}_teeth") for gear in ("sun", "planet", "ring")]
    old = next(p for p in known.entry(place) if {mass, "r_cp1"} <= set(p.symbols))
    by = (wrong(*teeth) / right(*teeth)) ** 2
    yours = _with(known, place, old, planted.times(old, by))
    (error,) = planted.explained(known, place, yours, UNLIKE).errors
    assert error.yours == told


@pytest.mark.parametrize(("by", "of"), [(1, "theta_1'^2"), (2, "theta_1' theta_2'"), (-0.5, "")])
def test_a_product_of_rates_that_belongs_to_none_has_a_sum_of_terms(by, of):
    """Its right coefficient is 0; what stands there is that of another product, or a multiple."""
    known = planted.terms(UNLIKE, planted.RELATIVE)
    square = known.entry(EntryPlace("bias", 2, rates=(0, 0)))
    extra = [planted.times(p, by) for p in square if p.key.wave == (0, 0, 1)]
    assert len(extra) > 1
    place = EntryPlace("bias", 2, rates=(1, 2))
    (error,) = planted.explained(known, place, (*known.entry(place), *extra), UNLIKE).errors
    assert (error.kind, error.term.angle) == ("extra", "theta_3")
    assert error.right == (f"bias[theta_3] of {of}" if of else "")
