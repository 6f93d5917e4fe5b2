"""H4: what the elbow planets' spin costs."""

import pytest

from crosscheck.audit.hypotheses.evidence.spin import CONSIDERABLE_M, SpinCost, is_considerable
from crosscheck.models.loading import load_arm


def test_threshold():
    assert is_considerable(1.01 * CONSIDERABLE_M)
    assert not is_considerable(0.99 * CONSIDERABLE_M)


def test_missing_inertia_is_that_of_the_planets():
    found = SpinCost("paper-labelled", "pd", 0.01).answer()
    joint = load_arm("paper-labelled").joints[1]
    # N M_p r_p^2 turn with link 1; r_p = 3 mm * 36 / 2 * cos(24.6 deg) = 49.09875 mm.
    inertia = joint.planet_count * joint.planet_equivalent_mass_kg * 49.09875e-3**2
    # The radius is given to seven digits.
    assert found.missing_kg_m2 == pytest.approx(inertia, rel=1e-6)
    assert found.tip_m > 0
