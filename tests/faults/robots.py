"""Robots on which faults are sought, and whether the engines agree on them."""

from collections.abc import Callable
from functools import lru_cache

import pytest

from crosscheck.cost import agreement
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot
from tests.faults.planting import Seen
from tests.robots.chains import (
    LIMIT,
    Solid,
    geared,
    joint,
    link,
    perform_here,
    planetary,
    robot,
    teeth,
    urdf,
)

TEETH = teeth(0.02, 1e6, 100.0, 2e-5)
TURNED = Solid(1.7, (0.11, -0.04, 0.07), (0.03, 0.004, -0.006, 0.05, 0.002, 0.06), (0.3, -0.2, 0.5))
# Read while the fault is there: Pinocchio alone reads the URDF itself.
READ, BARE = "read again", "without what may be left out"


@lru_cache
def unlike() -> Robot:
    """A revolute and a prismatic joint, a fixed link, a mimic, rotors on three links."""
    text = urdf(
        link("ground"),
        link("a", TURNED),
        link("b", TURNED._replace(mass=0.9)),
        link("c", TURNED._replace(com=(0.02, 0.09, -0.1))),
        link("plate", TURNED._replace(mass=0.4)),
        link("d", TURNED),
        link("tool"),
        joint("flange", "d", "tool", "fixed", at=(0.1, 0.0, 0.2), rpy=(0.0, 0.3, 0.0)),
        joint("one", "ground", "a", axis=(0.2, 0.3, 0.9), at=(0.1, 0.2, 0.3), rpy=(0.1, 0.2, 0.4)),
        joint("two", "a", "b", axis=(1, 0, 0), at=(0.3, 0.0, 0.1), rpy=(0.5, -0.4, 0.7)),
        joint("fixed", "b", "plate", "fixed", at=(0.1, 0.1, 0.0), rpy=(0.2, 0.6, -0.3)),
        joint("three", "plate", "c", "prismatic", (0.6, 0.0, 0.8), (0.2, 0.1, 0.2), (1, 0.3, 0.2)),
        joint(
            *("four", "c", "d", "revolute", (0, 1, 0), (0.1, 0.2, 0.1), (0.4, 0.2, 0.9)),
            more=LIMIT + '<mimic joint="two" multiplier="-0.5" offset="0.3"/>',
        ),
    )
    return robot(
        text,
        {
            "one": geared(9.0),
            "two": geared(-7.0, stator="plate", rotor_axis=[0.5, 0.5, 0.2], mesh=TEETH),
            "three": geared(30.0, mesh=TEETH),
        },
        tip="tool",
    )


@lru_cache
def all_sprung() -> Robot:
    """Two joints whose rotors all have meshes: every joint of the engines' trees moves freely."""
    text = urdf(
        link("ground"),
        link("a", TURNED),
        link("b", TURNED),
        joint("one", "ground", "a", axis=(0.2, 0.3, 0.9)),
        joint("two", "a", "b", axis=(1, 0, 0), at=(0.3, 0.0, 0.1)),
    )
    return robot(text, {"one": geared(5.0, mesh=TEETH), "two": geared(-4.0, mesh=TEETH)})


@lru_cache
def staged() -> Robot:
    """Two stages on joints that cross, a third on one that mimics, and a rotor on a mesh."""
    text = urdf(
        link("ground"),
        *(link(name, TURNED) for name in "abcd"),
        joint("one", "ground", "a", axis=(0.2, 0.3, 0.9), at=(0.1, 0.2, 0.3), rpy=(0.1, 0.2, 0.4)),
        joint("two", "a", "b", "continuous", (1, 0.2, 0), (0.3, 0, 0.1), (0.5, -0.4, 0.7)),
        joint(
            *("three", "b", "c", "revolute", (0, 1, 0), (0.1, 0.2, 0.1), (0.4, 0.2, 0.9)),
            more=LIMIT + '<mimic joint="two" multiplier="-0.5" offset="0.3"/>',
        ),
        joint("four", "c", "d", axis=(0.6, 0, 0.8), at=(0.3, 0.0, 0.1)),
    )
    slower = planetary(planet_teeth=30, ring_teeth=84, planet_count=4)
    given = {"one": planetary(), "two": slower, "three": planetary()}
    return robot(text, {**given, "four": geared(5.0, mesh=TEETH)})


def bare() -> Robot:
    """Joints without axis and place, and a mimic without multiplier and offset."""
    ends = '<parent link="{}"/><child link="{}"/>'
    following = ends.format("a", "b") + LIMIT + '<mimic joint="one"/>'
    return robot(
        urdf(
            link("ground"),
            link("a", TURNED),
            link("b", TURNED),
            f'<joint name="one" type="continuous">{ends.format("ground", "a")}</joint>',
            f'<joint name="two" type="revolute">{following}</joint>',
        )
    )


ROBOTS: dict[str, Callable[[], Robot]] = {
    "unlike": unlike,
    "all sprung": all_sprung,
    "staged": staged,
    READ: lambda: robot(unlike().urdf, tip="tool"),
    BARE: bare,
}
KEPT: dict[tuple[str, str, str], agreement.RobotAnswers] = {}


def robots_agree(seen: Seen) -> str:
    """Every quantity of the engines at every level; the engine is harmed, or what reads a robot."""
    return engines_agree(seen.arm, seen.model)


def engines_agree(name: str, harmed: str, given: Callable[[Robot], Robot] = lambda own: own) -> str:
    """The verdict, where the harmed engine is given another robot, or is another.

    Engines that are not harmed answer once. A run is one step: all that it takes is compared too.
    """
    own, answers, model_of = ROBOTS[name](), agreement._evaluate_model, agreement.build_model

    def kept(model: RobotModel, states: agreement.RandomStates) -> agreement.RobotAnswers:
        if model.name == harmed or name in (READ, BARE):
            return answers(model, states)
        key = name, model.name, model.level
        if key not in KEPT:
            KEPT[key] = answers(model, states)
        return KEPT[key]

    def made(engine: str, at: Robot, level: Level) -> RobotModel:
        return model_of(engine, given(at) if engine == harmed else at, level)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(agreement, "perform_all", perform_here)
        patch.setattr(agreement, "STEPS", 1)
        patch.setattr(agreement, "_evaluate_model", kept)
        patch.setattr(agreement, "build_model", made)
        found = agreement.compare_engines(own, agreement.sample_states(own, 3, 0))
    if any(each.failure for each in found):
        return "failed"
    return "agree" if all(each.agrees for each in found) else "differ"
