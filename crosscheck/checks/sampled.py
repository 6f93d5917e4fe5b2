"""What checks are made for: models at random states, experiments, and how to ask both.

No check knows which models there are: planning chooses them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, groupby
from typing import Any, Literal, NamedTuple, Protocol, TypeVar

import numpy as np

from crosscheck.checks.answers import EQUATIONS, ROBOT_QUESTIONS, SWITCHED, Setting
from crosscheck.checks.first_principles.composite import Content
from crosscheck.checks.first_principles.slopes import SlopeRule, make_smooth_rule
from crosscheck.checks.robot_states import RandomStates, RobotSizes
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.loading import Case
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.planning.comparison import Comparison, ModelTask, make_comparison

FIRST_PRINCIPLES = "first principles"
DIFFERENCE = "largest difference, over its natural size,"
RESIDUAL = "largest residual, over its terms' size,"
# Steps of slopes of order 8, in which a joint turns by so much [rad] or slides [m]: of second
# harmonics, the highest of M in a rotation, they leave 3e-12; M and energy are of a slide's square
# at most.
TURN_RAD, SLIDE_M = 0.04, 0.1
SLOPE_STATES = 4  # number of a robot's states at which slopes are taken, the first ones
LEAST_RUN_S = 1e-8  # shortest run [s]: in less, joints move by little more than rounding
# Which checks a model of an arm is for: all of those of gears, of rigid levels, of single planets;
# of forces under other switches; of springs that are a potential; of the paper's own forms.
Group = Literal["geared", "rigid", "free", "switches", "conservative", "form"]


class ModelQuestion(Protocol):
    """A function of a model and a setting, whose name is that of the quantity."""

    @property
    def __name__(self) -> str: ...

    def __call__(self, model: Any, setting: Any, /) -> np.ndarray: ...


@dataclass(frozen=True)
class SampledModel:
    """A model at the random states of a setting, which is called ``where`` in ids.

    ``evaluate`` makes a task of a setting and a question.
    """

    where: str
    model: str
    setting: Setting | RobotLevel
    evaluate: Callable[[Any, ModelQuestion], ModelTask]

    @property
    def questions(self) -> Sequence[ModelQuestion]:
        """What models are compared in."""
        raise NotImplementedError

    def ask(self, question: ModelQuestion) -> ModelTask:
        """The task of a question at these states."""
        return self.evaluate(self.setting, question)

    def over(self, size: str) -> str:
        """The words of a metric: a size over these random states."""
        return f"{size} over {self.setting.count} random states"

    def plan_law(
        self,
        quantity: str,
        questions: Sequence[ModelQuestion],
        judge: Callable[..., Finding],
        metric: str = "",
        against: str = FIRST_PRINCIPLES,
        *,
        family: str = "invariants",
        unit: str = "1",
    ) -> Comparison:
        """The comparison of this model alone; judge takes the subject, the answers, the setting."""
        key = ComparisonKey(family, self.where, quantity, self.model)

        def judge_answers(about: Subject, *answers: Any) -> Finding:
            return judge(about, *answers, self.setting)

        about = Subject(key, unit, metric or self.over(RESIDUAL), against)
        return make_comparison(about, list(map(self.ask, questions)), judge_answers)


@dataclass(frozen=True)
class SampledArm(SampledModel):
    """A model of an arm at random states.

    ``covers`` says whether it is about an arm under switches. promises: methods that it must have;
    order: of its fixed steps; free_planets: whether every planet moves by itself inside;
    content: what the arm's file holds; symbols: of a form, the tasks of what it
    answers in symbols too.
    """

    setting: Setting
    promises: frozenset[str]
    order: int | None
    free_planets: bool
    covers: Callable[[Arm, Switches], bool]
    group: Group = "geared"
    content: Content = field(default_factory=dict)
    symbols: Sequence[Any] = ()

    @property
    def owes_laws(self) -> bool:
        """Whether laws of a model by itself are checked here: under the usual switches, once."""
        return self.group not in ("switches", "conservative")

    @property
    def questions(self) -> Sequence[ModelQuestion]:
        """What models are compared in: M and bias know no switch, so not under others again."""
        return EQUATIONS if self.owes_laws else SWITCHED

    def ask_once(self, question: ModelQuestion, case: Case | None = None) -> ModelTask:
        """The task of a question that knows no state, in another case if one is given."""
        setting = replace(self.setting, case=case or self.setting.case, count=1, seed=0)
        return self.evaluate(setting, question)


@dataclass(frozen=True, eq=False)
class RobotLevel:
    """A robot at a level, the states at which its models answer, and what these states are worth.

    drive (free, n): generalized forces of each motor's torque; runs take run_s [s], so short that
    few steps resolve the meshes; free motions of all levels take motion_s [s] in motion_steps.
    scenarios: beginnings of those that a user chose, in as few steps.
    """

    robot: Robot
    level: Level
    states: RandomStates
    sizes: RobotSizes
    drive: np.ndarray
    run_s: float
    motion_s: float
    motion_steps: int
    scenarios: tuple[Scenario, ...] = ()

    @property
    def count(self) -> int:
        """How many states there are."""
        return len(self.states.q)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints' coordinates."""
        return tuple(self.robot.coordinate_names)

    @property
    def has_runs(self) -> bool:
        """Whether joints move by more than rounding in steps that resolve meshes and friction."""
        return self.run_s >= LEAST_RUN_S

    @property
    def free(self) -> int:
        """How many coordinates are joints'; meshes' come behind them."""
        return len(self.robot.coordinates)

    @property
    def first(self) -> RandomStates:
        """The states at which slopes are taken."""
        return self.states.first(SLOPE_STATES)

    @property
    def turns(self) -> np.ndarray:
        """By coordinate (n,) how far all joints that it moves turn, per rad or m."""
        turns = np.zeros(self.states.q.shape[1])
        for number, joint in enumerate(self.robot.joints):
            if joint.kind == "revolute":
                by = 1.0 if joint.mimic is None else abs(joint.mimic.multiplier)
                turns[self.leader(number)] += by
        return turns

    def leader(self, number: int) -> int:
        """Number of the coordinate that moves a joint: its own, or that of the joint it mimics."""
        mimic = self.robot.joints[number].mimic
        return self.robot.coordinates.index(number if mimic is None else mimic.joint)

    @property
    def steps(self) -> np.ndarray:
        """By which each coordinate changes for slopes (n,)."""
        return np.where(self.turns > 0, TURN_RAD / np.maximum(self.turns, 1e-300), SLIDE_M)

    @property
    def slope_rule(self) -> SlopeRule:
        """How slopes of M and of the energy are taken."""
        return make_smooth_rule(self.steps)


@dataclass(frozen=True)
class SampledRobot(SampledModel):
    """A model of a robot, ``engine:level``, at random states."""

    setting: RobotLevel

    @property
    def questions(self) -> Sequence[ModelQuestion]:
        """What models are compared in."""
        return ROBOT_QUESTIONS


class RunModels(NamedTuple):
    """Models that run an experiment of an arm, by their part in its comparisons.

    same: those of the reference model's integrator, it first, of an order; other: of integrators of
    their own; constrained: with constraint equations; levels: of each rigid level that differs,
    those that choose their own steps first; exact: the levels that rigid gears amount to;
    free_planets: those inside which every planet moves by itself.
    """

    same: tuple[str, ...]
    other: tuple[str, ...]
    constrained: tuple[str, ...]
    forms: tuple[str, ...]
    levels: Mapping[str, tuple[str, ...]]
    exact: tuple[str, ...]
    order: int
    is_precise: bool
    free_planets: frozenset[str]


@dataclass(frozen=True)
class ExperimentPlan:
    """One scenario with a short name for ids, and what its runs are compared for.

    growth: of an unstable loop.
    """

    name: str
    case: Case
    growth: Any = None
    purpose: Literal["motion", "short", "order", "energy"] = "motion"

    @property
    def models(self) -> RunModels:
        """The models that are about its arm under its switches."""
        raise NotImplementedError

    def run(self, model: str, variant: str = "", rtol: float | None = None) -> Any:
        """The task of one of a model's runs."""
        raise NotImplementedError


class Subjects(NamedTuple):
    """What a plan of checks is made for: the models of arms or of a robot, and experiments."""

    arms: Sequence[SampledArm] = ()
    robots: Sequence[SampledRobot] = ()
    experiments: Sequence[ExperimentPlan] = ()


def find_experiments(subjects: Subjects, purpose: str) -> Iterator[ExperimentPlan]:
    """The experiments of a purpose."""
    return (each for each in subjects.experiments if each.purpose == purpose)


def find_usual(subjects: Subjects) -> Iterator[ExperimentPlan]:
    """The motions under the usual switches, in which most comparisons are made."""
    for each in find_experiments(subjects, "motion"):
        arm, _, laws = each.case
        if laws in (usual_switches(arm), usual_switches(arm, planets="free")):
            yield each


Sampled = TypeVar("Sampled", bound=SampledModel)


def group_models(models: Sequence[Sampled]) -> list[list[Sampled]]:
    """The models of each case, in their order."""
    return [list(group) for _, group in groupby(models, lambda sampled: sampled.where)]


def pair_models(models: Sequence[Sampled]) -> Iterator[tuple[Sampled, Sampled]]:
    """Every two models of a case."""
    for group in group_models(models):
        yield from combinations(group, 2)
