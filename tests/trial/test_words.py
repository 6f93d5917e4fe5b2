"""How a trial writes what it found: terms, entries, errors and limits, each as one writes it."""

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.robot.file import load_robot
from crosscheck.trial.arms import answer_keys
from crosscheck.trial.changes.arms import term_words as messages
from crosscheck.trial.changes.arms.letters import format_power
from crosscheck.trial.changes.arms.polynomial import Monomial
from crosscheck.trial.changes.arms.segments import Product, TermKey
from crosscheck.trial.changes.arms.term_changes import TermChange
from crosscheck.trial.changes.arms.term_words import describe_entries
from crosscheck.trial.input.arrays import format_vector
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.judge.entries import (
    EntryMismatch,
    EntryPlace,
    Explanation,
    LevelDistance,
    NaturalSizes,
    Term,
    TermError,
    entry_place,
    find_wrong_entries,
    format_entry,
    list_entries,
    sort_distances,
)
from crosscheck.trial.result import describe_wrong
from crosscheck.trial.robots.forms import describe_angle_sum

# Coordinates of which the second is the sum of both joints' angles, and one that is half of them.
ABSOLUTE: Any = SimpleNamespace(
    names=("phi_1", "phi_2"), turns=np.array([[1, 0], [-1, 1]]), entries={}
)
HALVED: Any = SimpleNamespace(names=("u", "v"), turns=np.array([[0.5, 0], [0, 1]]), entries={})
ONE, PAYLOAD = Monomial(1, ()), Monomial(2, (("L1", 1), ("d2", 1), ("m_payload", 1)))
BELOW = Monomial(Fraction(-1, 2), (("I_l2", 1), ("L1", 2), ("r_c1", -2), ("r_s1", -1)))
COS = TermKey((0, 1))


def product(monomial: Monomial, key: TermKey = COS) -> Product:
    return Product(key, monomial)


def several(count: int, number: int = 1) -> tuple[Product, ...]:
    """As many terms with a mass each, that share the square of a length."""
    return tuple(
        product(Monomial(number * (n + 1), (("L1", 2), (f"m_l{n + 1}", 1)))) for n in range(count)
    )


MONOMIALS = (
    *(ONE, PAYLOAD, BELOW, Monomial(-1, (("L1", 1),)), Monomial(-1, ())),
    *(Monomial(1, (("L1", -1),)), Monomial(0.123456789, (("L2", 1),))),
)
KEYS = (
    *(TermKey((0, 0)), COS, TermKey((1, 0), "sin"), TermKey((0, 1), "sin")),
    *(TermKey((1, 1), "sin"), TermKey((2, 3))),
)
APART = product(Monomial(-1, (("L1", 1),))), product(Monomial(-2, (("L2", 1),)))
SUMS = several(2), several(2, -1), several(6), APART, (product(ONE), product(ONE, TermKey((1, 0))))
TERM = Term("m_payload L1 d2", "cos", "theta_2")
ERRORS = (
    TermError("dropped", TERM),
    TermError("sign", TERM),
    TermError("factor", TERM, by=0.5),
    TermError("factor", TERM, "n1"),
    TermError("angle", TERM, "a", "b"),
    TermError("extra", TERM),
    TermError("extra", TERM, right="bias[a]"),
    TermError("swapped", TERM, "L2", "d2"),
    TermError("swapped", TERM, "L1 d1", "d2"),
    TermError("swapped", Term("d2^2"), "L2", "d2"),
)


def test_terms_and_their_errors_are_written_as_people_write_them(snapshot: SnapshotAssertion):
    """Masses before lengths, waves of the user's coordinates, what a sum shares before it."""
    made = messages.make_term((product(PAYLOAD, TermKey((0, 1), "sin", "T_1")),), ABSOLUTE)
    bare = (
        Term("1", "cos", "q"),
        Term("-1", signal="T_1"),
        Term("1"),
        Term("3", "sin", "q", "F_sp1"),
    )
    assert {
        "monomials": list(map(messages.format_monomial, MONOMIALS)),
        "waves": [messages.format_wave(each, ABSOLUTE) for each in KEYS],
        # Half an angle is written in the joints' angles.
        "halves": [messages.format_angle_sum(TermKey((n, -2)), HALVED) for n in (1, 2)],
        "terms": list(map(messages.format_term, (made, *bare))),
        "sums": [messages.make_term(each, ABSOLUTE).coefficient for each in SUMS],
        "powers": [format_power("L1", power) for power in (1, 2, -1)],
        "vector": format_vector(np.array([1.0, 0.123456789])),
        "errors": list(map(messages.describe_term_error, ERRORS)),
    } == snapshot


def test_a_wave_with_the_other_sign_has_one_minus_at_most():
    for by, yours in ((1.0, "-sin(phi_1 - phi_2)"), (-1.0, "sin(phi_1 - phi_2)")):
        key = TermKey((0, 1), "sin")
        change = TermChange("angle", (product(ONE),), np.zeros(1), 1.0, by=by, key=key)
        assert messages.make_term_error(change, ABSOLUTE).yours == yours


def test_a_guess_is_the_likeliest_error_and_one_more_at_most():
    errors = [(TermError("swapped", Term(""), str(n)),) for n in range(5)]
    place = EntryPlace("bias", 0)

    def guess(*others: Any) -> str:
        explanation = Explanation(errors[0] + errors[1], 0.0, others)
        return messages.guess(EntryMismatch(place, 1.0, explanation))

    assert guess() == "0; and 1?"
    assert guess(*errors[2:4]) == "0; and 1; or 2; 1 more fit as well?"
    assert guess(*errors[2:]).endswith("; or 2; 2 more fit as well?")
    bare = EntryMismatch(place, 1.0, difference=(Term("2", "cos", "q"), *[Term("3")] * 4))
    assert "is 2 cos(q) + 3 + 3 + 3 + 1 more;" in messages.guess(bare)


def test_a_difference_has_its_largest_term_first():
    numbers = {COS: 1.23456, TermKey((0, 0)): -20.0, TermKey((0, 0), "cos", "T_1"): 3.0}
    found = messages.make_difference_terms(numbers, ABSOLUTE)
    assert list(map(messages.format_term, found)) == ["-20", "3 T_1", "1.235 cos(phi_1 - phi_2)"]


def test_entries_are_named_by_their_coordinates(snapshot: SnapshotAssertion):
    names, places = (
        ("a", "b"),
        {
            "mass_matrix": [(0, 1)],
            "rate_terms": [(1, 0, 1), (0, 1, 1)],
            **{part: [(0,), (1,)] for part in ("bias", "force", "acceleration")},
        },
    )
    each_of = [entry_place(part, at) for part, among in places.items() for at in among]
    eight = [EntryPlace("force", 0)] * 7 + [EntryPlace("force", 1)]
    lists = [list_entries(some, names) for some in ([], eight, [*eight, *eight[:2]])]
    assert [[format_entry(each, names) for each in each_of], lists] == snapshot


SIZES = NaturalSizes(
    mass=np.array([[4.0, 2.0], [2.0, 1.0]]),
    rate_terms=np.full((2, 2, 2), 5.0),
    bias=np.array([2.0, 8.0]),
    force=np.array([3.0, 6.0]),
    acceleration=np.array([7.0, 9.0]),
    gravity=np.array([1.0, 2.0]),
    gravity_slopes=np.ones((2, 2)),
    roundings=40.0,
    solving=1e3,
)
EPS = 2.0**-52
SLOPES = 2 / 0.03  # of differences of M, in which a joint turns by 0.03 rad


def test_a_tolerance_is_of_rounding_the_map_and_the_files_digits():
    written = NaturalSizes(**{**vars(SIZES), "precision": 1e-9})
    map_alone = 1e-10 + 1000 * EPS * 40
    tolerances = {"bias": map_alone, "acceleration": map_alone + 10 * EPS * 1e3}
    of_file = {"bias": 4e-7, "acceleration": 4e-4, "rate_terms": 4e-7 * SLOPES}
    for part, right in tolerances.items():
        assert SIZES.tolerance(part) == pytest.approx(right, rel=1e-12)
    for part, more in of_file.items():
        assert written.file_rounding(part) == pytest.approx(more, rel=1e-12)
        right = tolerances.get(part, map_alone) + more
        assert written.tolerance(part) == pytest.approx(right, rel=1e-12)
    said = "1e-10 + 1000 eps x 40, the conditioning of the coordinates' map"
    of_each = ", of each entry's natural size"
    assert SIZES.basis("bias") == said + of_each
    assert SIZES.basis("acceleration") == f"{said} + 10 eps x 1e+03, that of M{of_each}"
    assert written.basis("bias") == f"{said} + 4e-07, by the digits of the answers' file{of_each}"


def test_edited_equations_have_the_tolerances_of_the_trial():
    """Also where the right answer is zero."""
    problem = SimpleNamespace(
        equations=Equations(bias=len),
        has={"bias"},
        compute_sizes=lambda level: SIZES,
        find_right=lambda level, part: np.zeros((3, 2)),
    )
    allowed = answer_keys._ask_reference(problem, "links").allowed["bias"]
    assert allowed == pytest.approx((1e-10 + 1000 * EPS * 40) * SIZES.bias, rel=1e-12)


@pytest.mark.parametrize(("part", "nearest"), [("gravity", "carriers"), ("mass_matrix", "links")])
def test_a_part_that_has_a_motors_mass_shows_that_the_other_lacks_it(part, nearest):
    """M is wrong beside links; beside carriers it is part."""
    links, carriers = LevelDistance("links", 1, 0.5, 0.1), LevelDistance("carriers", 1, 0.9, 0.2)
    distances = {links: {"mass_matrix"}, carriers: {part}}
    assert sort_distances(distances)[0].level == nearest


def test_entries_beyond_their_tolerance_come_largest_first():
    right = np.zeros((3, 2))
    user = right.copy()
    user[1] = [2e-6, 3e-6]
    found = list(find_wrong_entries("bias", user, right, SIZES))
    assert [each.place.row for each in found] == [0, 1]
    assert [each.share for each in found] == pytest.approx([1e-6, 3.75e-7])
    by_ten = SIZES.scale_by(10.0)
    for part in ("mass_matrix", "rate_terms", "bias", "force", "acceleration"):
        assert (by_ten.entry_sizes(part) == 10 * SIZES.entry_sizes(part)).all()
        assert len(set(SIZES.entry_sizes(part).shape)) == 1
    assert SIZES.entry_sizes("force").tolist() == [3.0, 6.0]
    assert SIZES.entry_sizes("acceleration").tolist() == [7.0, 9.0]


def test_explained_errors_come_first_then_notes_then_all_others():
    why = Explanation((TermError("dropped", Term("2"), None),), 0.0)
    entries = [
        EntryMismatch(EntryPlace("bias", 0), 3.0, name="a", guess="unknown"),
        EntryMismatch(EntryPlace("bias", 1), 2.0, notes=("a note",), name="b"),
        EntryMismatch(EntryPlace("bias", 2), 1.0, why, name="c", guess="known"),
    ]
    assert describe_entries(entries) == (["c: known", "b: a note"], ["a: unknown"])


def test_each_part_has_a_line_before_a_second_one_of_another_and_signs_are_told_apart():
    extra = [Explanation((TermError("extra", Term(n)),), 0.0) for n in ("-I2", "I2", "m1", "g")]
    places = EntryPlace("bias", 0), EntryPlace("bias", 1), EntryPlace("bias", 2)
    entries = [
        EntryMismatch(place, 1.0, why, name=name, guess="wrong")
        for name, place, why in zip("abcd", (*places, EntryPlace("force", 0)), extra, strict=True)
    ]
    lines, _ = describe_entries(entries)
    assert lines == ["a: wrong; of the other sign in b", "d: wrong", "c: wrong"]


def test_a_wave_of_a_robot_is_of_its_angles_and_one_displacement(
    monkeypatch, snapshot: SnapshotAssertion
):
    robot = load_robot("sliding")
    q = np.random.default_rng(1).uniform(-2, 2, (40, 3))
    turn, slide, tilt = q.T
    waves = (
        *(np.exp(turn), -20.6 * np.cos(turn), 3 * slide, 2.5 * slide * np.sin(tilt)),
        *(1.5 * np.cos(tilt) - 0.25 * np.sin(tilt), np.full(40, 1.234567)),
        *(4 * np.sin(turn - tilt), np.zeros(40), -1700 - 850 * slide, slide**2),
        (2 - slide) * np.sin(tilt) + 0.5 * np.cos(tilt),
    )
    most = "crosscheck.trial.robots.forms.MOST_ANGLES"
    monkeypatch.setattr(most, 2)
    assert [describe_angle_sum(each, q, robot) for each in waves] == snapshot
    monkeypatch.setattr(most, 1)
    assert describe_angle_sum(3 * slide, q, robot) == ""


@pytest.mark.parametrize(
    ("share", "said"), [(0.095, "9.5 % of"), (64.0, "64 times"), (9.4, "940 % of")]
)
def test_a_wrong_entry_is_compared_with_its_size(share, said):
    wrong = EntryMismatch(EntryPlace("gravity", 0), share, name="gravity[q]")
    assert describe_wrong([wrong]) == f"gravity[q] is wrong, by up to {said} its natural size"
