"""H4: what the elbow planets' spin costs."""

from __future__ import annotations

from pathlib import Path

import pytest

from crosscheck.paper.hypotheses.planet_spin import CONSIDERABLE_M, chapter, matters
from crosscheck.paper.scale import Scale
from crosscheck.studies.study import Study
from models.loading import load_arm


def test_threshold() -> None:
    assert matters(1.01 * CONSIDERABLE_M)
    assert not matters(0.99 * CONSIDERABLE_M)


def test_missing_inertia_is_that_of_the_planets(tmp_path: Path) -> None:
    verdict, *records = chapter(Study(tmp_path), Scale(longest_s=0.01)).records
    record = records[0]
    joint = load_arm("paper-labelled").joints[1]
    # N M_p r_p^2 turn with link 1; r_p = 3 mm * 36 / 2 * cos(24.6 deg) = 49.09875 mm.
    inertia = joint.planet_count * joint.planet_equivalent_mass_kg * 49.09875e-3**2
    # The radius is given to seven digits.
    assert record["share_of_M_33_kg_m2"] == pytest.approx(inertia, rel=1e-6)
    assert verdict["largest_tip_m"] == max(r["tip_m"] for r in records) > 0
