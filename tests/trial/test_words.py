"""How a trial writes what it found: terms, entries, errors and limits, each as one writes it."""

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from crosscheck.models.robot.file import load_robot
from crosscheck.trial.arms.entry_notes import describe_entries
from crosscheck.trial.changes.arms import term_words as messages
from crosscheck.trial.changes.arms.letters import format_power
from crosscheck.trial.changes.arms.polynomial import Monomial
from crosscheck.trial.changes.arms.segments import Product, TermKey
from crosscheck.trial.changes.waves import describe_angle_sum
from crosscheck.trial.input.arrays import format_vector
from crosscheck.trial.judge.entries import (
    EntryMismatch,
    EntryPlace,
    Explanation,
    NaturalSizes,
    Term,
    TermError,
    entry_place,
    find_wrong_entries,
    format_entry,
    list_entries,
)
from crosscheck.trial.result import describe_wrong

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


MONOMIALS = {
    "1": ONE,
    "2 m_payload L1 d2": PAYLOAD,
    "-1/2 I_l2 L1^2/(r_s1 r_c1^2)": BELOW,
    "-L1": Monomial(-1, (("L1", 1),)),
    "-1": Monomial(-1, ()),
    "1/L1": Monomial(1, (("L1", -1),)),
    "0.123457 L2": Monomial(0.123456789, (("L2", 1),)),
}


def test_a_monomial_has_its_masses_before_its_lengths():
    assert [messages.format_monomial(each) for each in MONOMIALS.values()] == [*MONOMIALS]


def test_a_wave_is_of_the_users_coordinates():
    waves = {
        TermKey((0, 0)): "1",
        COS: "cos(phi_1 - phi_2)",
        TermKey((1, 0), "sin"): "sin(phi_1)",
        TermKey((0, 1), "sin"): "-sin(phi_1 - phi_2)",
        TermKey((1, 1), "sin"): "sin(phi_2)",
        TermKey((2, 3)): "cos(phi_1 - 3 phi_2)",
    }
    assert {key: messages.format_wave(key, ABSOLUTE) for key in waves} == waves
    # half an angle is written in the joints' angles
    assert messages.format_angle_sum(TermKey((1, -2)), HALVED) == (1, "theta_1 - 2 theta_2")
    assert messages.format_angle_sum(TermKey((2, -2)), HALVED) == (1, "u - 2 v")


def test_a_term_has_its_coefficient_wave_and_signal():
    sine = TermKey((0, 1), "sin", "T_1")
    term = messages.make_term((product(PAYLOAD, sine),), ABSOLUTE)
    assert (term.coefficient, term.wave, term.angle, term.signal) == (
        "-2 m_payload L1 d2",
        "sin",
        "phi_1 - phi_2",
        "T_1",
    )
    assert messages.format_term(term) == "-2 m_payload L1 d2 sin(phi_1 - phi_2) T_1"
    terms = {
        "cos(q)": Term("1", "cos", "q"),
        "-T_1": Term("-1", signal="T_1"),
        "1": Term("1"),
        "3 sin(q) F_sp1": Term("3", "sin", "q", "F_sp1"),
    }
    for text, each in terms.items():
        assert messages.format_term(each) == text


def test_a_sum_says_what_its_terms_share_and_how_many_more_there_are():
    def several(count: int, number: int = 1) -> tuple[Product, ...]:
        return tuple(
            product(Monomial(number * (n + 1), (("L1", 2), (f"m_l{n + 1}", 1))))
            for n in range(count)
        )

    assert messages.format_coefficient(several(2)) == "L1^2 (m_l1 + 2 m_l2)"
    assert messages.format_coefficient(several(2, -1)) == "-L1^2 (m_l1 + 2 m_l2)"
    six = messages.format_coefficient(several(6))
    assert six == "L1^2 (m_l1 + 2 m_l2 + 3 m_l3 + 4 m_l4 + 2 more)"
    apart = product(Monomial(-1, (("L1", 1),))), product(Monomial(-2, (("L2", 1),)))
    assert messages.format_coefficient(apart) == "- (L1 + 2 L2)"
    two = messages.make_term((product(ONE), product(ONE, TermKey((1, 0)))), ABSOLUTE)
    assert two.coefficient == "cos(phi_1 - phi_2) + cos(phi_1)"


def test_small_texts():
    assert [format_power("L1", power) for power in (1, 2, -1)] == ["L1", "L1^2", "L1^-1"]
    assert format_vector(np.array([1.0, 0.123456789])) == "[1, 0.123457]"


TERM = Term("m_payload L1 d2", "cos", "theta_2")
ERRORS = {
    "missing term: m_payload L1 d2 cos(theta_2)": TermError("dropped", TERM),
    "yours has m_payload L1 d2 cos(theta_2) with the opposite sign": TermError("sign", TERM),
    "yours has m_payload L1 d2 cos(theta_2) times 0.5": TermError("factor", TERM, by=0.5),
    "yours has m_payload L1 d2 cos(theta_2) times n1": TermError("factor", TERM, "n1"),
    "yours has a where b belongs, in m_payload L1 d2 cos(theta_2)": TermError(
        "angle", TERM, "a", "b"
    ),
    "extra term: m_payload L1 d2 cos(theta_2)": TermError("extra", TERM),
    "extra term: m_payload L1 d2 cos(theta_2), which stands in bias[a]": TermError(
        "extra", TERM, right="bias[a]"
    ),
    "missing term: m_payload L1 (d2 - L2) cos(theta_2); L2 where d2 belongs": TermError(
        "swapped", TERM, "L2", "d2"
    ),
    "L1 d1 where d2 belongs, in m_payload L1 d2 cos(theta_2)": TermError(
        "swapped", TERM, "L1 d1", "d2"
    ),
    "missing term: (d2^2 - L2^2); L2 where d2 belongs": TermError(
        "swapped", Term("d2^2"), "L2", "d2"
    ),
}


@pytest.mark.parametrize("text", ERRORS)
def test_an_error_says_what_is_yours_and_what_is_right(text):
    assert messages.describe_term_error(ERRORS[text]) == text


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


def test_an_entry_is_named_by_its_coordinates():
    names = ("a", "b")
    entries = {
        "M[a, b]": entry_place("mass_matrix", (0, 1)),
        "bias[b] of a' b'": entry_place("rate_terms", (1, 0, 1)),
        "bias[a] of b'^2": entry_place("rate_terms", (0, 1, 1)),
        "bias[b]": entry_place("bias", (1,)),
        "force[a]": entry_place("force", (0,)),
        "acceleration[b]": entry_place("acceleration", (1,)),
    }
    for text, place in entries.items():
        assert format_entry(place, names) == text
    assert list_entries([], names) == ""
    eight = [EntryPlace("force", 0)] * 7 + [EntryPlace("force", 1)]
    shown = "force[a], " * 7 + "force[b]"
    assert list_entries(eight, names) == shown
    assert list_entries([*eight, *eight[:2]], names) == f"{shown} and 2 more"


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
    assert [*describe_entries(entries)] == ["c: known", "b: a note", "a: unknown"]


def test_a_wave_of_a_robot_is_of_its_angles_and_one_displacement(monkeypatch):
    robot = load_robot("sliding")
    joints = [robot.joints[number] for number in robot.coordinates]
    turning = [n for n, joint in enumerate(joints) if joint.kind == "revolute"]
    (slide, *_) = (n for n, joint in enumerate(joints) if joint.kind == "prismatic")
    q = np.random.default_rng(1).uniform(-2, 2, (40, len(joints)))
    first, last = turning[0], turning[-1]
    names = [joint.name for joint in joints]
    waves = {
        "": np.exp(q[:, first]),
        f"-20.6 cos({names[first]})": -20.6 * np.cos(q[:, first]),
        f"3 {names[slide]}": 3 * q[:, slide],
        f"2.5 {names[slide]} sin({names[last]})": 2.5 * q[:, slide] * np.sin(q[:, last]),
        f"1.5 cos({names[last]}) - 0.25 sin({names[last]})": 1.5 * np.cos(q[:, last])
        - 0.25 * np.sin(q[:, last]),
        "1.23457": np.full(40, 1.234567),
    }
    if first != last:
        both = f"{names[first]} - {names[last]}"
        waves[f"4 sin({both})"] = 4 * np.sin(q[:, first] - q[:, last])
    most = "crosscheck.trial.changes.waves.MOST_ANGLES"
    monkeypatch.setattr(most, len(turning))
    for text, values in waves.items():
        assert describe_angle_sum(values, q, robot) == text
    assert describe_angle_sum(np.zeros(40), q, robot) == ""
    monkeypatch.setattr(most, len(turning) - 1)
    assert describe_angle_sum(3 * q[:, slide], q, robot) == ""


@pytest.mark.parametrize(
    ("share", "said"), [(0.095, "9.5 % of"), (64.0, "64 times"), (9.4, "940 % of")]
)
def test_a_wrong_entry_is_compared_with_its_size(share, said):
    wrong = EntryMismatch(EntryPlace("gravity", 0), share, name="gravity[q]")
    assert describe_wrong([wrong]) == f"gravity[q] is wrong, by up to {said} its natural size"
