"""MuJoCo's gear tree is found where it is installed, and agrees with the program's own models."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest

from crosscheck.checks.engines import plan_pairs
from crosscheck.checks.invariants import plan_balances
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import Case, load_arm
from crosscheck.planning.arms import sample_model
from crosscheck.planning.comparison import Results, collect_tasks, judge_comparisons
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.registry import MODELS, reference_model

ARMS = ("paper-labelled", "probe", "planets-apart", "three-unlike", "direct-between")
LAWS = [
    {"phase": phase, "ring_rate": rate, "damping": damping, "planets": planets, **work}
    for phase, rate, damping, planets, work in product(
        ("angle", "omega_t"),
        ("eq13", "corrected"),
        ("always", "contact"),
        ("lumped", "free"),
        ({"dead_zone": "tanh"}, {"mesh_work": "conservative"}, {}),
    )
    if (phase, work.get("mesh_work")) != ("omega_t", "conservative")
]


def red(arm_name: str, **chosen: str) -> list[str]:
    """The checks of states that are not green, and of power and momentum, at five states."""
    arm = load_arm(arm_name)
    case = Case(arm, make_unequal_gains_scenario(arm), usual_switches(arm, **chosen))
    sampled_models = [
        sample_model("example", name, case, 5, 0) for name in (reference_model(), "mujoco:gears")
    ]
    comparisons = list(plan_pairs(sampled_models))
    if case.switches.mesh_work == "paper":
        comparisons += plan_balances(sampled_models[1])
    results = Results({task.key: task.perform() for task in collect_tasks(comparisons)})
    return [str(f) for f in judge_comparisons(comparisons, results) if f.verdict != "agree"]


def test_it_is_found_by_its_entry_point():
    assert {"mujoco", "mujoco-gears"} <= set(MODELS["mujoco:gears"].packages)


@pytest.mark.parametrize("arm_name", ARMS)
def test_states_of_any_arm(arm_name):
    assert red(arm_name) == []


@pytest.mark.parametrize("laws", LAWS, ids=lambda laws: "-".join(laws.values()))
def test_states_under_every_law(laws):
    assert red("probe", **laws) == []


def test_it_is_one_small_file():
    lines = Path(__file__).with_name("mujoco_gears.py").read_text("utf-8").splitlines()
    assert len(lines) <= 150
