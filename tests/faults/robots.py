"""Robots on which faults are sought, and whether the engines agree on them."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from types import ModuleType

import numpy as np
import pytest

from crosscheck.analytic.kernel import program
from crosscheck.analytic.robot import structure
from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks import engines
from crosscheck.checks.robot_states import sample_states
from crosscheck.checks.sampled import SampledRobot, Subjects
from crosscheck.models.robot import file
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.planning.checks import plan_checks
from crosscheck.planning.comparison import Comparison, Results
from crosscheck.planning.robots import make_cases, sample_models
from crosscheck.registry import engine_of
from crosscheck.runner import tasks
from crosscheck.runner.outcomes import Outcome
from crosscheck.runner.tasks import Evaluation
from tests.faults.planting import Seen
from tests.robots.chains import (
    LIMIT,
    Solid,
    contact,
    geared,
    joint,
    link,
    planetary,
    robot,
    teeth,
    urdf,
)
from tests.robots.test_floating import free_robot
from tests.robots.traced import equations, interpreted_accelerations, random_state

TEETH = teeth(0.02, 1e6, 100.0, 2e-5)
TURNED = Solid(1.7, (0.11, -0.04, 0.07), (0.03, 0.004, -0.006, 0.05, 0.002, 0.06), (0.3, -0.2, 0.5))
# Read while the fault is there: Pinocchio alone reads the URDF itself.
READ, BARE = "read again", "without what may be left out"
PLANNED = "planned again"


@lru_cache
def unlike() -> Robot:
    """A revolute and a prismatic joint, a fixed link, a mimic, rotors on three links, friction."""
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
            "one": geared(9.0, friction_N_m_s_per_rad=0.4),
            "two": geared(-7.0, stator="plate", rotor_axis=[0.5, 0.5, 0.2], mesh=TEETH),
            "three": geared(30.0, mesh=TEETH, friction_N_m_s_per_rad=4.0),
            "four": {"kind": "direct", "friction_N_m_s_per_rad": 0.3},
        },
        tip="tool",
    )


@lru_cache
def all_sprung() -> Robot:
    """Two joints whose rotors all have meshes: every joint of the engines' trees moves freely.

    Friction is the damping of the URDF.
    """
    text = urdf(
        link("ground"),
        link("a", TURNED),
        link("b", TURNED),
        joint("one", "ground", "a", axis=(0.2, 0.3, 0.9), more=LIMIT + '<dynamics damping="3"/>'),
        joint("two", "a", "b", axis=(1, 0, 0), at=(0.3, 0.0, 0.1)),
    )
    given = {"one": geared(5.0, mesh=TEETH), "two": geared(-4.0, mesh=TEETH)}
    return robot(text, given, friction="from-urdf")


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


@lru_cache
def parted() -> Robot:
    """Planets that move by themselves: unlike ones of an oblique joint, and those of a mimic."""
    damping = [300.0, 100.0, 500.0]
    sun = contact(
        tooth_error_m=[3e-6, 1e-6, 5e-6], damping_N_s_per_m=damping, phase_rad="from-teeth"
    )
    waves = [{"law": "sine", "mean_N_per_m": k, "amplitude_N_per_m": 2e6} for k in (1e7, 2e7, 8e6)]
    errors = {"static_error_m": [0.0, 1e-6, -2e-6], "backlash_m": [2e-5, 1e-5, 3e-5]}
    ring = contact(stiffness=waves, phase_rad="from-teeth", **errors)
    teeth_of = {"sun_teeth": 22, "planet_teeth": 26, "ring_teeth": 74}  # out of phase
    unlike_planets = planetary(**teeth_of, sun_mesh=sun, ring_mesh=ring)
    return robot(staged().urdf, {"one": unlike_planets, "three": planetary(planets="free")})


def bare() -> Robot:
    """Joints without axis and place, and a mimic without multiplier and offset."""
    file._read_mechanism.cache_clear()
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


def read_again() -> Robot:
    """The unlike robot, from its URDF."""
    file._read_mechanism.cache_clear()
    return robot(unlike().urdf, tip="tool")


ROBOTS: dict[str, Callable[[], Robot]] = {
    "unlike": unlike,
    "all sprung": all_sprung,
    "staged": staged,
    "parted": parted,
    "free": lru_cache(free_robot),
    PLANNED: parted,
    READ: read_again,
    BARE: bare,
}
KEPT: dict[tuple[str, Evaluation], Outcome] = {}


def robots_agree(seen: Seen) -> str:
    """A named check of all that `validate` makes, the engine harmed, or what reads a robot."""
    if seen.quantity:
        return named_verdict(seen.arm, seen.model, seen.quantity)
    return engines_agree(seen.arm, seen.model)


def plan_models(name: str) -> list[SampledRobot]:
    """The models of a robot with the states at which they are asked.

    They are planned once, unless the reader or the plan itself is harmed.
    """
    return (_plan_models.__wrapped__ if name in (READ, BARE, PLANNED) else _plan_models)(name)


@lru_cache
def _plan_models(name: str) -> list[SampledRobot]:
    own = ROBOTS[name]()
    return sample_models(make_cases(own, sample_states(own, 3, 0), 10))


def engines_agree(name: str, harmed: str) -> str:
    """The verdict between engines, of which one is harmed, or what reads the robot."""
    return judge(name, list(engines.plan(Subjects(robots=plan_models(name)))), harmed)


def named_verdict(name: str, harmed: str, quantity: str) -> str:
    """The verdict of the checks of a quantity by the harmed engine itself, or with others."""
    models = plan_models(name)
    own_models = [each for each in models if engine_of(each.model) == harmed]

    def select(among: Sequence[SampledRobot]) -> list[Comparison]:
        planned, _ = plan_checks(Subjects(robots=among))
        return [each for each in planned if each.about.key.quantity == quantity]

    forget_texts()
    verdict = judge(name, select(own_models) or select(models), harmed)
    forget_texts()
    return verdict


def forget_texts(modules: Sequence[ModuleType] = (program, structure)) -> None:
    """Kernels are traced and translated anew, since another fault is another text."""
    for module in modules:
        for function in vars(module).values():
            if hasattr(function, "cache_clear"):
                function.cache_clear()


def judge(name: str, comparisons: Sequence[Comparison], harmed: str) -> str:
    """The first verdict that is not agree; a task runs when a comparison first needs it.

    Engines that are not harmed answer once, a harmed one is built once. A run is one step between
    engines: all that it takes is compared too.
    """
    outcomes, right = dict[Evaluation, Outcome](), tasks.build_robot_model
    built: dict[tuple[str, int, Level], RobotModel] = {}

    def build(engine: str, at: Robot, level: Level) -> RobotModel:
        key = engine, id(at), level  # of a robot that the comparisons keep
        if key not in built:
            built[key] = right(engine, at, level)
        return built[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engines, "STEPS", 1)
        patch.setattr(tasks, "build_robot_model", build)
        for comparison in comparisons:
            for task in comparison.needs:
                if task.key in outcomes:
                    continue
                if engine_of(task.model) == harmed or name in (READ, BARE):
                    outcomes[task.key] = task.perform()
                    continue
                if (name, task.key) not in KEPT:
                    KEPT[name, task.key] = task.perform()
                outcomes[task.key] = KEPT[name, task.key]
            verdict = comparison.finding(Results(outcomes)).verdict
            if verdict != "agree":
                return verdict
    return "agree"


def traced_is_kanes(seen: Seen) -> str:
    """Accelerations of a robot's kernel, its text run by Python, against Kane's method."""
    own = ROBOTS[seen.arm]()
    for level in reversed(own.levels[2:]):  # the others are parts of these
        forget_texts([structure])
        q, v, torques = random_state(own, level, 4)
        found = interpreted_accelerations(equations(own, level), q[0], v[0], torques[0])
        forget_texts([structure])
        expected, mass = _kanes(seen.arm, level)
        size = (np.abs(mass) @ np.abs(expected)).max()
        if not (np.abs(mass @ (found - expected)) < 1e-11 * size).all():
            return "differ"
    return "agree"


@lru_cache
def _kanes(name: str, level: Level) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations and M of the same state by Kane's method, which these faults do not reach."""
    own = ROBOTS[name]()
    q, v, torques = random_state(own, level, 4)
    kane = AnalyticRobot(own, level)
    return kane.forward_dynamics(q, v, torques)[0], kane.mass_matrix(q)[0]
