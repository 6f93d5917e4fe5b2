"""MuJoCo as an engine of cost: it reads the URDF by a parser of its own, and agrees."""

from collections.abc import Iterator
from importlib.metadata import EntryPoint

import pytest

from crosscheck import registry
from crosscheck.checks.robot_states import sample_states
from crosscheck.cli.listing import list_command
from crosscheck.cost.output import describe_answers
from crosscheck.cost.shortcuts import QUICK, compute_costs
from crosscheck.findings import Finding
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.planning import robots
from crosscheck.provenance import ROOT
from tests.faults.planting import plant
from tests.robots.chains import random_chain


@pytest.fixture
def offered(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What installed packages offer: the example's engine."""
    monkeypatch.syspath_prepend(ROOT / "examples" / "mujoco_engine")
    offer = EntryPoint("mujoco", "mujoco_robot:ENTRY", registry.ENTRY_POINTS)
    monkeypatch.setattr(registry, "entry_points", lambda group: [offer])
    with registry.register("mujoco", registry.add_installed_models({})["mujoco"]):
        yield


@pytest.fixture
def two_alone(monkeypatch: pytest.MonkeyPatch, offered: None) -> None:
    """No engine but the project's own derivation and MuJoCo."""
    monkeypatch.setattr(
        robots,
        "find_level_engines",
        lambda level: (
            ("analytic", "mujoco") if registry.MODELS["mujoco"].has_level(level) else ("analytic",)
        ),
    )


def of_mujoco(robot: Robot) -> list[Finding]:
    findings = robots.compare_engines(robot, sample_states(robot, 4, 0))
    return [each for each in findings if registry.engine_of(each.right) == "mujoco"]


@pytest.mark.parametrize("name", ["six-joint", "sliding", "puma560"])
def test_it_agrees_on_the_robots_that_come_along(offered, name):
    found = of_mujoco(load_robot(name))
    assert {each.right for each in found} == {"mujoco:links", "mujoco:armature"}
    assert [each for each in found if each.verdict != "agree"] == []


def test_it_agrees_on_random_chains(two_alone):
    wrong = [each for seed in range(6) for each in of_mujoco(random_chain(seed))]
    assert [each for each in wrong if each.verdict != "agree"] == []


FAULTS = [
    ("_compiled", "turn @ np.array", "np.array"),
    ("_compiled", "body_sameframe[number] = 0", "body_sameframe[number] = 2"),
    ("_compiled", "axes[:, 2] *= np.linalg.det(axes)", "axes = axes.T"),
    ("_turn", '"XYZ"', '"xyz"'),
    ("MujocoRobot.__init__", "rotor.ratio**2", "rotor.ratio"),
    ("_reflected", "* (2, 1)", "* (1, 1)"),
    ("_reflected", "gears.planet_count *", ""),
    ("_reflected", "np.cos(", "np.sin("),
    ("MujocoRobot._stand", "+ self._offset", ""),
    ("MujocoRobot.energy", "= self.robot.gravity", "= -self.robot.gravity"),
    ("MujocoRobot.momentum", "self._data.subtree_angmom[0] + about", "about"),
    ("_compiled", '("inertial",) if frame', "() if frame"),
    ("MujocoRobot._held", "self._model.opt.gravity = gravity", ""),
]


@pytest.mark.parametrize(("place", "old", "new"), FAULTS)
def test_a_wrong_line_of_it_is_seen(monkeypatch, two_alone, place, old, new):
    plant(monkeypatch, f"mujoco_robot:{place}", old, new)
    found = (each for seed in (0, 10) for each in of_mujoco(random_chain(seed)))  # 10 has stages
    assert any(each.verdict != "agree" for each in found)


def test_cost_names_the_levels_that_it_has(offered):
    few = QUICK.__class__(states=3, instants=50, runs=1, steps=20, most_steps=0)
    found = compute_costs(load_robot("sliding"), 0, few, lambda *doing: None)
    (line,) = (line for line in describe_answers(found) if line.startswith("Four programs agree"))
    assert "exudyn and mujoco (links, armature), on 9" in line


def test_list_shows_it_with_its_levels(offered, capsys):
    list_command()
    shown = " ".join(capsys.readouterr().out.split())
    assert "mujoco links and armature only, MuJoCo's joints and armature" in shown
