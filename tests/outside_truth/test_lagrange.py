"""The paper's arm: M of the derivation in closed form, and both readings of Table I."""

import numpy as np
import pytest

from crosscheck.analytic.model import RigidCoupled
from crosscheck.models.loading import load_arm, load_scenario
from tests.loops import require_items


def test_two_link_mass_matrix_in_closed_form(labelled):
    """M11 = a11 + a2 + a3 + 2 a4 c + M_s r_s^2 + 3 M_p r_p^2 and so on, by hand for two joints."""
    M_s, M_p, M_c, m_p, m_j, payload = 0.5, 0.66, 5.8, 0.61, 0.39 + 3 * 0.61 + 6.29 + 10, 10
    r_s, r_p, r_cp, r_c = 0.0368240624, 0.0490987499, 0.0859228123, 0.0945
    carrier = M_c * r_cp**2 + 3 * m_p * r_c**2
    a1 = (4 * M_s + 3 * M_p) * r_cp**2
    a2 = carrier + 27 / 12 + 27 * 0.25 + 18.9 + m_j + payload
    a3 = carrier + 18.9 * 0.49 / 12 + 18.9 * 0.35**2 + payload * 0.49
    a4 = 18.9 * 0.35 + payload * 0.7
    cosine = np.cos(0.7)
    m12 = a3 + a4 * cosine + 2 * M_s * r_s * r_cp - 3 * M_p * r_p * r_cp
    m11 = a1 + a2 + a3 + 2 * a4 * cosine + M_s * r_s**2 + 3 * M_p * r_p**2
    model = RigidCoupled(labelled, load_scenario("pd"))
    # Radii above are rounded to 1e-10 m.
    expected = np.array([[m11, m12], [m12, a1 + a3]])
    assert model.mass_matrix(np.array([0.3, 0.7])) == pytest.approx(expected, abs=1e-8)


def test_both_readings_load_and_differ():
    labelled, swapped = load_arm("paper-labelled"), load_arm("paper-swapped")
    pairs = ("sun", "planet", "carrier")
    for part in require_items(pairs):
        assert getattr(labelled.joints[0], f"{part}_mass_kg") == getattr(
            swapped.joints[0], f"{part}_equivalent_mass_kg"
        )
