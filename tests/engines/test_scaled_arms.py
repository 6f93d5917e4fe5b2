"""Checks of poles on arms of any size: what their gains and tolerances follow."""

import pytest

from crosscheck.checks import modes
from crosscheck.findings import Finding
from crosscheck.models.arm.arm import Arm
from crosscheck.planning.arms import sample_arm
from crosscheck.planning.comparison import Results, collect_tasks, judge_comparisons
from tests.arms import PAPER

HALF, GEARS = 0.05, 2e-4  # metres


def shrunk(arm: Arm, length_m: float, module_m: float) -> Arm:
    """The arm with its first link so long, all its lengths and masses to scale."""
    scale = length_m / arm.links[0].length_m
    content = arm.model_dump()
    content["payload_mass_kg"] *= scale**3
    for joint in content["joints"]:
        joint["module_m"] = module_m
        for name in (n for n in joint if n.endswith("mass_kg") and joint[n]):
            joint[name] *= scale**3
    for link in content["links"]:
        for name, power in (("length_m", 1), ("com_m", 1), ("cross_section_m2", 2)):
            link[name] *= scale**power
    return Arm.model_validate(content | {"name": "shrunk"})


def found(arm: Arm, planets: str) -> list[Finding]:
    group = "geared" if planets == "lumped" else planets
    models = [each for each in sample_arm(arm, 1, 0) if each.group == group]
    comparisons = list(modes.plan_poles(arm.name, models))
    outcomes = {task.key: task.perform() for task in collect_tasks(comparisons)}
    return list(judge_comparisons(comparisons, Results(outcomes)))


@pytest.mark.parametrize("planets", ["lumped", "free"])
def test_poles_of_a_small_arm_are_known_as_well_as_of_a_large_one(planets):
    """Gains of an arm of a metre would put a pole of one of 5 cm where no difference has digits."""
    findings = found(shrunk(PAPER, HALF, GEARS), planets)
    assert [f.verdict for f in findings] == ["agree"] * 3
    assert max(f.measured for f in findings) < 1e-9
