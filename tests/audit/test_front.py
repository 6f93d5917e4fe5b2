"""The page's beginning: its sentences follow its numbers."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from audit.experiments.cells import INTEGRAL, LABELLED, LAWS, PRINTED, REPAIRED_RATE, Cell, Law
from audit.experiments.scale import Scale
from audit.experiments.study import Study
from audit.front.findings import PLANETS, Ladder, Step, Strip, Thirds
from audit.front.terms import teeth_passed
from audit.front.views import stage_svg, third_svg
from audit.measures.stage import paper_stage
from audit.measures.third import Third
from audit.measures.thresholds import SEVERE
from audit.page.material import Material
from models.loading import load_arm

NONE = np.full(10, np.nan)


def thirds(severe: dict[Law, int]) -> Thirds:
    """Ten starts of every law; so many are severe with free planets, none with planets alike."""
    return Thirds(0.005, tuple(_strip(cell, severe) for cell in _cells()))


def _cells() -> list[Cell]:
    return [Cell(law, 0.005, planets=planets) for law, planets in product(LAWS, PLANETS)]


def _strip(cell: Cell, severe: dict[Law, int]) -> Strip:
    count = severe.get(cell.law, 0) if cell.planets == "free" else 0
    sizes = np.where(np.arange(10) < count, 2 * SEVERE, 1.0)
    return Strip(cell, Third(sizes, NONE, NONE, NONE, 0))


@pytest.mark.parametrize(
    ("severe", "needs"),
    [
        ({}, False),  # nowhere: nothing to explain
        ({PRINTED: 10}, True),
        ({REPAIRED_RATE: 5}, True),
        ({PRINTED: 1}, False),  # one of ten may be none
        ({PRINTED: 10, INTEGRAL: 1}, True),
        ({PRINTED: 10, INTEGRAL: 4}, False),
        ({INTEGRAL: 10}, False),
    ],
)
def test_the_third_fluctuation_needs_the_clock_only_if_it_is_nowhere_without(
    severe: dict[Law, int], needs: bool
) -> None:
    found = thirds(severe)
    assert found.needs_clock is needs
    share = found.share(PRINTED, "free")
    assert share is not None
    assert share.yes == severe.get(PRINTED, 0)
    assert len(found.said()) == len(LAWS)  # of free planets, which the claims have


def test_every_start_is_drawn() -> None:
    one, more = (thirds({PRINTED: count}) for count in (0, 10))
    assert third_svg(one) != third_svg(more)
    assert third_svg(one) == third_svg(one)


def test_the_papers_baseline_is_the_one_nearest_to_its_theta_2() -> None:
    links, last = Step("links", (0.1, 0.4)), Step("coupled", (2e-7, 1.3e-6))
    carriers = Step("carriers", (2e-3, 0.013))
    ladder = Ladder(0.02, (links, carriers, last))
    assert ladder.papers == carriers
    assert ladder.left_to_meshes == pytest.approx((1e-4, 1e-4))


def test_teeth_pass_as_the_motion_says(tmp_path: Path) -> None:
    """Both rates are those of the two counts; at the start neither has counted."""
    passed = teeth_passed(Material(Study(tmp_path), Scale(longest_s=0.2)))
    inner = slice(5, -5)
    for count, rate in ((passed.angle, passed.rate), (passed.clock, passed.clock_rate)):
        assert count[0] == 0
        found = np.gradient(count, passed.time)
        assert found[inner] == pytest.approx(rate[inner], abs=2e-3 * np.abs(rate).max())


def test_a_stage_has_all_its_teeth() -> None:
    joint = paper_stage(load_arm(LABELLED)).joint
    outlines = joint.sun_teeth + joint.planet_count * joint.planet_teeth + joint.ring_teeth
    circles = 2 + joint.planet_count
    assert stage_svg(joint).count('id="patch_') >= outlines + circles
