"""The case study of measured robots, where its recordings are at hand; else skipped.

CROSSCHECK_RECORDINGS names the folder that docs/case-study/measured.md describes.
"""

import os
from pathlib import Path

import pytest

from crosscheck.identification.compare import SideResult
from tools.measured import PAGE, Study, build_page

VARIABLE = "CROSSCHECK_RECORDINGS"
FOLDER = os.environ.get(VARIABLE, "")
pytestmark = pytest.mark.skipif(not FOLDER, reason=f"{VARIABLE} names no folder of recordings")


@pytest.fixture(scope="module")
def made() -> tuple[str, dict[str, Study]]:
    page, studies = build_page(Path(FOLDER))
    return page, {study.title: study for study in studies}


def by_name(side: SideResult) -> dict[str, tuple[float, float]]:
    """Values and standard errors of a side's estimates."""
    return {each.term.name: (each.value, each.error) for each in side.estimates}


def test_the_page_is_what_the_script_makes(made):
    """Words and names of tables; digits may differ by the rounding of another machine."""
    page, _ = made
    assert page.split("\n## ")[0] == PAGE.read_text(encoding="utf-8").split("\n## ")[0]
    for ours, there in zip(page.splitlines(), PAGE.read_text().splitlines(), strict=True):
        assert ours.split("|")[:2] == there.split("|")[:2] or ours.startswith(("- ", "Published"))


def test_tx40_has_its_published_rotors(made):
    """Within two standard errors; the wrist's coupling inside its interval and not zero."""
    study = made[1]["Stäubli TX40"]
    side = study.comparison.sides[0]
    values = by_name(side)
    for number in (3, 4, 5, 6):
        name = f"armature of joint_{number}"
        value, error = values[name]
        assert abs(value - study.published[name]) < 2 * error
    (shared,) = (each for each in side.rotors if each.term.kind == "shared armature")
    assert abs(shared.value - 0.00964) < shared.half_width
    assert shared.value > shared.half_width
    assert side.steps[0].weighted / side.steps[-1].weighted > 3.1


@pytest.mark.parametrize(("design", "first"), [("A.0", 0.00342), ("C.1", 0.00233)])
def test_the_pendulums_rotors_are_those_of_another_program(made, design, first):
    """Inside the interval; links alone are rejected, Coulomb friction is near the published."""
    study = made[1][f"Double pendulum, design {design}"]
    side = study.comparison.sides[0]
    (rotor,) = side.seen
    assert abs(rotor.value - first) < rotor.half_width
    assert study.comparison.ranks.are_equal
    for name, (value, _) in by_name(side).items():
        if name.startswith("coulomb"):
            assert 0.7 < value / study.published[name] < 1.1


def test_kinova_has_rotors_before_its_gears_alone(made):
    """Within two standard errors of another program's; behind the gears nothing is called one.

    The third joint's depends on the band, so it has no interval.
    """
    between, *others = made[1]["Kinova Gen3"].comparison.sides
    values = by_name(between)
    (third,) = (each for each in between.estimates if each.term.name == "armature of joint_3")
    assert third.doubled is not None
    for joint, first, error in ((4, 0.336, 0.029), (5, 0.079, 0.014)):
        assert abs(values[f"armature of joint_{joint}"][0] - first) < 2 * error
    value, error = values["armature of joint_7"]
    assert abs(value - 0.090) < 2 * error
    behind = [side for side in others if side.side == "joint"]
    assert [side.links for side in behind] == ["identified", "scaled"]
    assert not behind[0].is_excited
    assert all(side.seen == () for side in behind)
    scaled = by_name(behind[1])
    for joint in (3, 7):
        value, error = scaled[f"armature of joint_{joint}"]
        assert abs(value) < 2 * error
