"""Questions to the supplied equations: a part at random states, in the user's coordinates.

Each question is a task of its own, so that a part that raises, hangs or takes its process down
costs that part alone. What every function answers comes before all else. What can be no equation of
this arm (a wrong shape, a complex number) is bad input and ends the trial there. A function that
fails is asked no more.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from crosscheck import registry
from crosscheck.analytic.robot.model import multiply
from crosscheck.checks.answers import BadAnswer, ask
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError, Unfinished
from crosscheck.models.experiment.scenario import PdDrive, Scenario
from crosscheck.models.interface import Model
from crosscheck.models.loading import Case, make_rest_scenario
from crosscheck.planning.comparison import ModelTask, Results
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.report.formatting import format_count
from crosscheck.run import run_tasks
from crosscheck.runner.outcomes import Failure, SelfKeyedTask, failure_from_error
from crosscheck.runner.progress_update import ProgressCallback
from crosscheck.runner.tasks import Evaluation, Simulation, build_model
from crosscheck.runner.workers import Workers
from crosscheck.trial.arms.model import CALL_S, SuppliedModel
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.differences import (
    christoffel_terms,
    difference_steps,
    find_slopes,
    rate_terms,
)
from crosscheck.trial.coordinates.frame import Frame, describe_coordinate_count
from crosscheck.trial.coordinates.states import UserState, draw_states, stack_states
from crosscheck.trial.input.calls import LOADS, describe_failure
from crosscheck.trial.input.equations import Equations, Gearing
from crosscheck.trial.input.supplied import SuppliedEquations, bind_equations
from crosscheck.trial.judge.checks import COMPARED
from crosscheck.trial.judge.entries import LevelDistance, NaturalSizes, compute_sizes

SPEEDS = (-1.0, 2.0)
GAINS = ("proportional_N_m_per_rad", "derivative_N_m_s_per_rad")
AGAIN = "_again"
BY_RATES = ("rate_terms", "christoffel")
# What M, bias, gravity and force owe to themselves. They are compared with the engines at all
# states, so that a few are enough for what takes many calls at each.
SELF_CHECKS = ("christoffel", "gravity_slopes", "other_speeds", "by_torques")
SELF_CHECKED = 20  # random states
# Products of rates take many calls too, and no mesh law is in them: the first two corners of these,
# on either side of the edge of contact, show whether this is so.
FEW_CORNERS = 2
# Parts that questions with other names belong to.
PART_OF = {
    "coriolis": "bias",
    "other_speeds": "bias",
    "rate_terms": "bias",
    "christoffel": "mass_matrix",
    "gravity_slopes": "gravity",
    "by_torques": "force",
}


@dataclass(frozen=True)
class TransformedModel:
    """A model of the arm, its answers carried from the project's coordinates q into a user's x.

    With q = phi(x), J = dphi/dx and q' = J u (Siciliano et al., Robotics, ch. 7: the equations of
    motion are covariant). weightless: the same model without gravity, of equations that have the
    weights apart; the force is then its. Answers have the states along the first axis.
    """

    model: Model
    frame: Frame
    weightless: Model | None = None

    def answer(self, quantity: str, states: Sequence[UserState]) -> np.ndarray:
        """The answers to what models are asked, at states."""
        at, frame, model = stack_states(states), self.frame, self.model
        jacobians = np.array(list(map(frame.jacobian, at.x)))
        transposed, moving = jacobians.swapaxes(1, 2), (at.t, at.q, at.v)
        if quantity == "mass_matrix":  # J^T M J
            return transposed @ ask(model, "mass_matrix", jacobians.shape, at.q) @ jacobians
        if quantity == "force":  # J^T f
            force = ask(self.weightless or model, "generalized_force", at.q.shape, *moving)
            return multiply(transposed, force)
        if quantity == "gravity":  # J^T g: what the force lacks with weights, at rest
            assert self.weightless is not None  # else nobody asks
            still = 0 * at.t, at.q, 0 * at.v
            light, heavy = (
                ask(each, "generalized_force", at.q.shape, *still)
                for each in (self.weightless, model)
            )
            return multiply(transposed, light - heavy)
        if quantity == "acceleration":  # x'' of q'' = J x'' + J' u
            drift = np.array(list(map(frame.drift, at.x, at.u)))
            left = ask(model, "acceleration", at.q.shape, *moving) - drift
            return np.linalg.solve(jacobians, left[..., None])[..., 0]
        is_curved = frame.matrix is None  # else J' is 0
        mass = ask(model, "mass_matrix", jacobians.shape, at.q) if is_curved else None
        bias = partial(self._compute_bias, at, jacobians, mass)
        if quantity == "bias":
            return bias(at.u)
        steps = [difference_steps(each, frame.layout.angular) for each in jacobians]
        return rate_terms(bias, np.array(steps))

    def _compute_bias(
        self, at: UserState, jacobians: np.ndarray, mass: np.ndarray | None, u: np.ndarray
    ) -> np.ndarray:
        """J^T (h + M J' u) at states, by rates u there (states, n) or (n,)."""
        u = np.broadcast_to(u, at.x.shape)
        bias = ask(self.model, "bias", at.q.shape, at.q, multiply(jacobians, u))
        if mass is not None:
            bias = bias + multiply(mass, np.array(list(map(self.frame.drift, at.x, u))))
        return multiply(jacobians.swapaxes(1, 2), bias)


def transform_model(name: str, case: Case, frame: Frame, has_gravity: bool) -> TransformedModel:
    """A named model in a user's coordinates; has_gravity: the weights are a part by themselves."""
    weightless = None
    if has_gravity:
        arm = case.arm.model_copy(update={"gravity_m_per_s2": (0.0, 0.0)})
        weightless = build_model(name, case._replace(arm=arm))
    return TransformedModel(build_model(name, case), frame, weightless)


@dataclass(frozen=True)
class StateQuestion(SelfKeyedTask):
    """A part of supplied equations, asked at random states in their coordinates.

    model: the name of the equations; count, seed: of the random states, which corners of mesh laws
    follow; first: how many of all are asked.
    """

    model: str
    case: Case
    quantity: str
    count: int
    seed: int
    first: int | None = None

    @property
    def cost(self) -> float:
        """Estimated time that the answers take [s]."""
        calls = len(self.case.arm.joints) ** 2 if self.quantity in BY_RATES else 1
        return 0.5 + self.count * calls * CALL_S

    def perform(self) -> np.ndarray | Failure | BadAnswer:
        """The answers, state by state along the first axis, or why there are none.

        A BadAnswer if the first is no array of numbers of the right shape. Of what is asked again
        the last state comes first.
        """
        answers, again = list[np.ndarray](), self.quantity.endswith(AGAIN)
        try:
            model = build_model(self.model, self.case)
            assert isinstance(model, SuppliedModel)  # as it was registered
            drawn = draw_states(model.frame, self.case, self.count, self.seed)
            states = drawn[: self.first]
            source = model.repeated_equations if again else model.supplied
            pairs = list(zip(states, [*states[1:], states[0]], strict=True))
            for state, other in pairs[:: -1 if again else 1]:
                answers.append(QUESTIONS[self.quantity](source, state, other.u))
        except BadAnswer as error:
            return describe_failure(error) if answers else error
        except BaseException as error:  # also SystemExit and KeyboardInterrupt out of a model
            return describe_failure(error)
        return np.array(answers[:: -1 if again else 1])


# At a state, and with an acceleration (n,) where one is needed: the rates of another state.
Answer = Callable[[SuppliedEquations, UserState, np.ndarray], np.ndarray]


def _ask_part(part: str, source: SuppliedEquations, state: UserState, a: np.ndarray) -> np.ndarray:
    given = {"t": state.t, "x": state.x, "v": state.u, "torque": state.torque}
    return source.answer(part, given)


def _rate_terms(source: SuppliedEquations, state: UserState, a: np.ndarray) -> np.ndarray:
    steps = difference_steps(source.frame.jacobian(state.x), source.frame.layout.angular)
    return rate_terms(partial(source.bias, state.x), steps)


def _christoffel(source: SuppliedEquations, state: UserState, a: np.ndarray) -> np.ndarray:
    return christoffel_terms(_mass_slopes(source, state, a))


def _find_slopes(
    part: str, source: SuppliedEquations, state: UserState, a: np.ndarray
) -> np.ndarray:
    frame, values = source.frame, getattr(source, part)
    steps = difference_steps(frame.jacobian(state.x), frame.layout.angular)
    return find_slopes(values, state.x, steps, curved=frame.matrix is None)


_mass_slopes, _gravity_slopes = (partial(_find_slopes, p) for p in ("mass_matrix", "gravity"))


def _bias_at_other_speeds(source: SuppliedEquations, state: UserState, a: np.ndarray) -> np.ndarray:
    """The bias at other speeds, h(x, s u) / s^2, then h(x, 0): shape (speeds + 1, n)."""
    moving = [source.bias(state.x, speed * state.u) / speed**2 for speed in SPEEDS]
    return np.array([*moving, source.bias(state.x, 0 * state.u)])


def _forces_by_torque(source: SuppliedEquations, state: UserState, a: np.ndarray) -> np.ndarray:
    """Forces (2 m + 2, n) at no torque, at each alone, at twice each alone, and at all together."""
    alone = np.diag(state.torque)
    torques = [0 * state.torque, *alone, *(2 * alone), state.torque]
    pushed = (state._replace(torque=each) for each in torques)
    return np.array([_ask_part("force", source, each, a) for each in pushed])


def _inverse_dynamics(source: SuppliedEquations, state: UserState, a: np.ndarray) -> np.ndarray:
    """Inverse dynamics as supplied, then M a + h, then a: shape (3, n)."""
    user_torques = source.inverse_dynamics(state.x, state.u, a)
    return np.array(
        [user_torques, source.mass_matrix(state.x) @ a + source.bias(state.x, state.u), a]
    )


QUESTIONS: dict[str, Answer] = {
    **{f"{part}{again}": partial(_ask_part, part) for part in COMPARED for again in ("", AGAIN)},
    "rate_terms": _rate_terms,
    "christoffel": _christoffel,
    "gravity_slopes": _gravity_slopes,
    "other_speeds": _bias_at_other_speeds,
    "by_torques": _forces_by_torque,
    "inverse_dynamics": _inverse_dynamics,
}


def make_experiment(arm: Arm, motors: Sequence[int]) -> Scenario:
    """The scenario whose torques act at the states that are asked, by motors of these joints."""
    if not motors:
        return make_rest_scenario()
    scenario = make_unequal_gains_scenario(arm)
    assert isinstance(scenario.drive, PdDrive)  # as that scenario has it
    drive, has_motor = scenario.drive, np.isin(np.arange(len(arm.joints)), motors)
    gains = {name: tuple((getattr(drive, name) * has_motor).tolist()) for name in GAINS}
    return scenario.model_copy(update={"drive": drive.model_copy(update=gains)})


@dataclass(frozen=True)
class VerificationProblem:
    """Equations under a name, and the case and states at which they are asked.

    has: the parts that they have, or that follow from those; motors: the joints that have one, from
    0; few_corners: of mesh laws, at how many of which the bias by pairs of rates is asked.
    """

    name: str
    equations: Equations
    has: frozenset[str]
    case: Case
    count: int
    seed: int
    motors: tuple[int, ...]
    few_corners: int = FEW_CORNERS

    @property
    def mechanism(self) -> Arm:
        """The arm."""
        return self.case.arm

    @property
    def names(self) -> Sequence[str]:
        """Names of the coordinates."""
        return self.frame.names

    @property
    def description(self) -> tuple[str, ...]:
        """Lines that describe the arm."""
        return self.case.arm.described

    def name_level(self, level: str) -> str:
        """The level as reports call it."""
        return level

    def describe_level(self, level: str, distances: Sequence[LevelDistance]) -> tuple[str, str]:
        """The level with which equations are compared, and with which they agree, in words."""
        if not level:
            geared = f"geared equations, planets {self.gearing}"
            return geared, geared
        if registry.is_rigid_arm(self.case.arm):
            return f"the {registry.RIGID_ARM}", f"the {registry.RIGID_ARM}"
        return level, f"{level} ({registry.LEVELS[level]})"

    @property
    def has_gravity(self) -> bool:
        """Whether the weights are a part of their own, and not in the force."""
        return "gravity" in self.has

    @property
    def gearing(self) -> Gearing:
        """How the coordinates count the gears."""
        return self.equations.coordinates.gearing

    @cached_property
    def frame(self) -> Frame:
        """The frame of the equations' coordinates on the user's arm. Raises InputError."""
        return build_frame(self.equations.coordinates, self.case.arm)

    @cached_property
    def bound(self) -> SuppliedEquations:
        """The equations on the user's arm. Raises InputError."""
        return bind_equations(self.equations, self.case.arm, self.frame)

    @cached_property
    def states(self) -> tuple[UserState, ...]:
        """The states at which everything is asked: random ones, then corners of mesh laws."""
        return draw_states(self.frame, self.case, self.count, self.seed)

    @property
    def states_in_words(self) -> str:
        """The states in words."""
        corners = "" if self.gearing == "rigid" else " and corners of the mesh laws"
        return f"{self.count} random states{corners}"

    @property
    def levels(self) -> tuple[str, ...]:
        """The rigid levels that the model may be, the richest last; '' of a geared one."""
        if self.gearing != "rigid":
            return ("",)
        return (self.equations.level,) if self.equations.level else registry.RIGID_LEVELS

    def engines(self, level: str = "") -> tuple[str, ...]:
        """The models to compare with, the reference first: of a rigid level, or geared ones."""
        if level:
            return registry.find_level_models(level)
        geared = registry.select_with_method("mass_matrix", registry.model_names("geared"))
        return tuple(dict.fromkeys((registry.reference_model(), *geared)))

    def reference(self, level: str) -> str:
        """The model that entries are compared with one by one."""
        return self.engines(level)[0]

    def adapt_to_arm(self, arm: Arm) -> VerificationProblem:
        """The problem of the same equations with another arm's numbers. Raises InputError."""
        case = Case(arm, make_experiment(arm, self.motors), self.case.switches)
        return replace(self, equations=self.equations.adapt_to_arm(arm, case.scenario), case=case)

    def ask_equations(self, quantity: str) -> StateQuestion:
        """The question of a part of the supplied equations."""
        first = self._count_states(quantity)
        return StateQuestion(self.name, self.case, quantity, self.count, self.seed, first)

    def _count_states(self, quantity: str) -> int | None:
        """At how many of the states, from the first on, a part is asked; None for all."""
        if quantity in SELF_CHECKS:
            return min(self.count, SELF_CHECKED)
        return self.count + self.few_corners if quantity == "rate_terms" else None

    @cached_property
    def _kept(self) -> dict[Any, Any]:
        return {}

    def evaluate(self, model: str, quantity: str) -> np.ndarray | Failure:
        """What a model of the project answers at the states (count, ...), or why it does not."""
        key, made_of = (model, quantity), (self.case, self.frame, self.has_gravity)
        if key not in self._kept:
            try:
                if model not in self._kept:
                    self._kept[model] = transform_model(model, *made_of)
                states = self.states[: self._count_states(quantity)]
                self._kept[key] = self._kept[model].answer(quantity, states)
            except (Exception, SystemExit) as error:  # of an engine that may be another's
                self._kept[key] = failure_from_error(error)
        return self._kept[key]

    def find_right(self, level: str, quantity: str) -> np.ndarray | None:
        """The reference's answers (count, ...) at a level; None where it has none."""
        values = self.evaluate(self.reference(level), quantity)
        return None if isinstance(values, Failure) else values

    def compute_sizes(self, level: str) -> NaturalSizes:
        """Natural sizes by the reference's answers. Raises Unfinished without its M."""
        key, reference = (level, "sizes"), self.reference(level)
        if key not in self._kept:
            mass = self.evaluate(reference, "mass_matrix")
            if isinstance(mass, Failure):
                raise Unfinished(f"{self.name} cannot be judged: {reference}: {mass}")
            parts = (*LOADS, "gravity") if self.has_gravity else LOADS
            right: dict[str, Any] = {part: self.find_right(level, part) for part in parts}
            precision = self.equations.table.precision if self.equations.table else 0.0
            given = self.frame, self.states, mass
            self._kept[key] = compute_sizes(*given, **right, precision=precision)
        return self._kept[key]


def ask_functions(
    problem: VerificationProblem, workers: Workers, progress: ProgressCallback
) -> tuple[Results, dict[str, Failure]]:
    """What the user's own functions answer, and by part why they do not.

    Raises InputError for an answer that cannot be used, and where all parts raise the same.
    """
    parts = sorted(problem.bound.given)
    tasks = {part: problem.ask_equations(PART_OF.get(part, part)) for part in parts}
    results = run_tasks(workers, list(dict.fromkeys(tasks.values())), progress)
    failed_parts = dict[str, Failure]()
    for part, task in tasks.items():
        outcome: object = results.outcomes[task.key]
        if isinstance(outcome, BadAnswer):
            coordinates, arm = problem.equations.coordinates, problem.case.arm
            count = describe_coordinate_count(coordinates, len(problem.names), arm)
            raise InputError(problem.name, "", None, f"{outcome}; x are {count}")
        if isinstance(outcome, Failure):
            where = "" if outcome.trace else f"{part}: "
            failed_parts[part] = replace(outcome, message=f"{where}{outcome.message}")
    traces = [failure.trace for failure in failed_parts.values()]
    if len(traces) == len(tasks) and len({_find_error(each) for each in traces}) == 1 and traces[0]:
        frames = re.findall(r'File "(.+)", line (\d+)', traces[0])
        user_frames = [each for each in frames if "site-packages" not in each[0]]
        file, line = (user_frames or frames)[-1]
        reason = f"every part raises {_find_error(traces[0])} ({Path(file).name}, line {line})"
        count = format_count(len(problem.names), "coordinate")
        reason += f"; {problem.mechanism.name} has {count}"
        raise InputError(problem.name, "", None, reason)
    return results, failed_parts


def _find_error(trace: str) -> str:
    """The last line of a traceback: the error."""
    return trace.rstrip().rpartition("\n")[2]


def skip_dependent_tasks(
    problem: VerificationProblem, tasks: Iterable[ModelTask], failed_parts: dict[str, Failure]
) -> dict[ModelTask, Failure]:
    """The tasks that would call a function that does not come back, each with the reason."""
    given = problem.bound.given
    mass = tuple(part for part in ("mass_matrix", "inverse_dynamics") if part in given)[:1]
    bias = tuple(part for part in ("bias", "coriolis", "inverse_dynamics") if part in given)[:1]
    whole = ("acceleration",) if "acceleration" in given else (*mass, *bias, "gravity", "force")
    calls = {
        "mass_matrix": mass,
        "bias": bias,
        "gravity": ("gravity",),
        "acceleration": whole,
        "inverse_dynamics": ("inverse_dynamics", *mass, *bias),
    }
    skipped_tasks: dict[ModelTask, Failure] = {}
    for task in tasks:
        if task.model != problem.name:
            continue
        parts = (*whole, *mass)
        if not isinstance(task, Simulation):
            assert isinstance(task, StateQuestion | Evaluation)  # nothing else is asked of it
            part = task.quantity.removesuffix(AGAIN)
            parts = calls.get(PART_OF.get(part, part), ("force",))
        reasons = [failed_parts[part] for part in parts if part in failed_parts]
        if reasons:
            skipped_tasks[task] = reasons[0]
    return skipped_tasks
