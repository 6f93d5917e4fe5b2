"""Three engines with no formula in common agree on robots of every kind."""

import numpy as np
import pytest

from crosscheck.checks.robot_states import sample_states
from crosscheck.findings import Finding
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import LEVELS, Robot
from crosscheck.planning.robots import compare_engines
from crosscheck.provenance import ROOT
from crosscheck.registry import build_robot_model
from tests.draws import DRAWS, SAMPLE, fresh_seed
from tests.robots.chains import random_chain

PAPERS_ARM = str(ROOT / "examples" / "robots" / "planetary-arm.toml")
CHAINS, MOST_JOINTS = (8, 7) if DRAWS == SAMPLE else (DRAWS, 12)


def differing(robot: Robot, states: int = 4) -> list[Finding]:
    findings = compare_engines(robot, sample_states(robot, states, 0))
    return [each for each in findings if each.verdict != "agree"]


@pytest.mark.parametrize("name", ["six-joint", "sliding", "puma560", PAPERS_ARM])
def test_engines_agree_on_the_robots_that_come_along(name):
    assert differing(load_robot(name)) == []


@pytest.mark.campaign
def test_engines_agree_on_random_chains_in_space():
    first = fresh_seed()
    seeds = range(first, first + CHAINS)
    wrong = {seed: differing(random_chain(seed, MOST_JOINTS)) for seed in seeds}
    assert {seed: found for seed, found in wrong.items() if found} == {}


def test_an_engine_that_raises_fails_its_own_comparisons_and_no_other(monkeypatch):
    robot = load_robot("sliding")
    broken = type(build_robot_model("exudyn", robot, "links"))

    def bias(*_: object) -> None:
        raise ZeroDivisionError("no such luck")

    monkeypatch.setattr(broken, "bias", bias)
    found = differing(robot)
    assert {each.left for each in found} == {
        f"{engine}:{level}" for engine in ("analytic", "pinocchio") for level in robot.levels
    }
    assert {each.quantity for each in found} == {"bias"}
    assert {each.note for each in found} == {
        f"exudyn:{level}: ZeroDivisionError: no such luck" for level in robot.levels
    }


@pytest.mark.parametrize("answer", [np.full((4, 3), np.nan), np.zeros(3)], ids=["NaN", "shape"])
def test_an_answer_that_is_none_fails(monkeypatch, answer):
    robot = load_robot("sliding")
    broken = type(build_robot_model("pinocchio", robot, "links"))
    monkeypatch.setattr(broken, "gravity", lambda self, q: answer)
    found = differing(robot)
    assert {each.about.key.case for each in found} == {f"sliding/{level}" for level in LEVELS}
    assert {each.verdict for each in found} == {"failed"}


def test_at_no_states_the_reference_has_no_answers():
    """`cost` asks so where a run has no rows."""
    own = load_robot("puma560")
    none = np.empty((0, len(own.coordinate_names)))
    model = build_robot_model("analytic", own, "coupled")
    assert model.mass_matrix(none).shape == (0, 6, 6)
    assert model.inverse_dynamics(none, none, none).shape == (0, 6)
