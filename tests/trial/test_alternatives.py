"""What may stand where a symbol belongs: words that, read as a formula, have the given value.

The readers here know symbols and Python's arithmetic alone.
"""

import re

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.loading import load_arm
from crosscheck.trial.changes.arms import arm_numbers, letters
from crosscheck.trial.changes.arms.letters import (
    collect_arm_values,
    draw_unrelated_values,
    generate_alternatives,
)
from crosscheck.trial.changes.arms.term_changes import TermChange
from crosscheck.trial.changes.arms.term_search import select_likely
from tests.loops import require_items

ARM = load_arm("three-unlike")
VALUES = collect_arm_values(ARM)


def read(text: str, joint: int) -> float:
    """The value of a formula as people write it."""
    text = re.sub(r"^the pitch radius ", "", text)
    if "alpha" in text:
        cosine = np.cos(np.radians(ARM.joints[joint - 1].pressure_angle_deg))
        text = text.replace("cos(alpha)", repr(float(cosine)))
    text = text.replace("#", str(joint)).replace("^", "**")
    text = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", text)
    return float(eval(text, {"sqrt": np.sqrt, "__builtins__": {}}, VALUES))


@pytest.mark.parametrize("symbol", VALUES)
def test_an_alternative_is_worth_what_it_says(symbol):
    found = list(generate_alternatives(symbol, VALUES))
    joint = letters.parse_letter(symbol).joint
    for each in found:
        assert each.value == pytest.approx(read(each.text, joint), rel=1e-12), each.text
        assert 0 < each.cost < 1.2
    texts = [each.text for each in found]
    assert len(set(texts)) == len(texts)
    assert symbol not in texts
    assert bool(texts) == (letters.parse_letter(symbol).stem in letters.QUANTITY_OF_STEM)


def test_each_kind_of_symbol_has_its_alternatives(snapshot: SnapshotAssertion):
    """Those that are no other symbol."""
    symbols = "d2", "I_l2", "N1", "n1", "r_s1", "r_c1", "g_x"
    made = {each: [e.text for e in generate_alternatives(each, VALUES)] for each in symbols}
    assert {each: [t for t in made[each] if t not in VALUES] for each in symbols} == snapshot


def test_a_symbol_is_confused_with_its_nearest_likes():
    """Of its own joint before others', of its own kind of number before other kinds."""
    costs = {each.text: each.cost for each in generate_alternatives("L2", VALUES)}
    assert costs["d2"] < costs["L1"] < costs["d1"]
    assert costs["L1"] == costs["L3"]
    assert costs["d1"] < costs["r_s1"]
    of_radius = {each.text: each.cost for each in generate_alternatives("r_s1", VALUES)}
    assert of_radius["r_p1"] < of_radius["r_s2"] < of_radius["r_p2"] < of_radius["L2"]
    of_mass = {each.text: each.cost for each in generate_alternatives("m2", VALUES)}
    assert of_mass["m1"] < of_mass["m_payload"] < of_mass["M_s1"]


def test_of_equal_factors_a_letter_is_named_then_a_number_and_a_root_at_last():
    """Equal on the arm at hand alone; others by what they cost, so many at most."""
    texts = "z_s1", "", "sqrt(N1)"
    unlike = [
        TermChange("factor", (), np.array([[2.0], [float(n)]]), 1.0, text)
        for n, text in enumerate(texts)
    ]
    for least in range(3):
        for some in (unlike[least:], unlike[least:][::-1]):
            ((only,),) = select_likely([(each,) for each in some])
            assert only.yours == texts[least]
    several = [
        (TermChange("swapped", (), np.array([[2.0], [float(n)]]), 1.0 + 0.07 * n, str(n)),)
        for n in range(9)
    ]
    assert [only.yours for (only,) in select_likely(several)] == list("0123456")
    far = [
        several[0],
        *((several[n][0]._replace(cost=cost),) for n, cost in ((1, 1.49), (2, 1.51))),
    ]
    assert select_likely(far) == far[:2]


def test_unrelated_numbers_are_each_of_their_own():
    drawn = draw_unrelated_values(VALUES)
    assert len(set(drawn.values())) == len(VALUES)
    assert all(0.5 <= value <= 2.0 for value in drawn.values())
    assert drawn == draw_unrelated_values(reversed(list(VALUES)))


ARM_NUMBERS = list(arm_numbers.list_number_names(ARM))


def test_a_number_of_an_arm_is_replaced_alone():
    before = {name: arm_numbers.get_number(ARM, name) for name in ARM_NUMBERS}
    assert {"payload_mass_kg", "links[1].com_m", "gravity_m_per_s2[0]"} <= set(before)
    for name in require_items(before):
        by = 1.001 if before[name] else 0.0
        other = arm_numbers.replace_numbers(ARM, {name: before[name] * by})
        after = {each: arm_numbers.get_number(other, each) for each in ARM_NUMBERS}
        assert after == before | {name: before[name] * by}


def test_what_is_absent_from_an_arm_is_no_number_of_it():
    plain = load_arm("paper-labelled")
    names = set(arm_numbers.list_number_names(plain))
    friction = {f"joints[{place}].friction_N_m_s_per_rad" for place in (0, 1)}
    assert not names & {"gravity_m_per_s2[0]", "gravity_m_per_s2[1]", *friction}
    assert "joints[2].friction_N_m_s_per_rad" in ARM_NUMBERS
    assert "payload_mass_kg" in names


def test_a_number_that_is_zero_may_be_another():
    """A link's, in proportion to its length and mass."""
    link = ARM.links[1]
    substitutes = {
        "links[1].com_m": 0.3 * link.length_m,
        "links[1].inertia_kg_m2": 0.1 * link.mass_kg * link.length_m**2,
        "payload_mass_kg": 3.0,
        "joints[0].motor_mass_kg": 2.0,
        "joints[0].rotor_inertia_kg_m2": 0.3,
        "joints[0].sun_mass_kg": 1.0,
        "joints[0].friction_N_m_s_per_rad": 0.0,
    }
    for name, right in require_items(substitutes.items()):
        assert arm_numbers.nonzero_substitute(ARM, name) == pytest.approx(right, rel=1e-12)


@pytest.mark.parametrize(("part", "negligible"), [(0.98, True), (1.02, False), (0.0, False)])
def test_an_inertia_is_next_to_nothing_below_a_millionth_of_its_levers(part, negligible):
    link = ARM.links[1]
    inertia = {"links[1].inertia_kg_m2": part * 1e-6 * link.mass_kg * link.com_m**2}
    found = arm_numbers.find_negligible_inertias(
        arm_numbers.replace_numbers(ARM, inertia), ARM_NUMBERS
    )
    assert found == tuple(inertia) * negligible


def test_numbers_go_with_those_that_they_are_written_in(snapshot: SnapshotAssertion):
    equal = arm_numbers.replace_numbers(ARM, {"links[2].length_m": ARM.links[1].length_m})
    found = arm_numbers.find_natural_powers
    names = "links[1].mass_kg", "payload_mass_kg"
    assert [found(equal, "links[1].length_m"), *(found(ARM, each) for each in names)] == snapshot
