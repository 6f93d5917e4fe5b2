"""A trial of a user's equations of a robot: ask, compare with every level, explain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from crosscheck.findings import Agreement
from crosscheck.models.robot.robot import Robot
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.progress_update import ProgressCallback, ignore_progress
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.loading import require_robot_equations
from crosscheck.trial.robots.answers import ask, call_functions, draw_states, register_functions
from crosscheck.trial.robots.explain import RobotDiagnosis, diagnose
from crosscheck.trial.robots.judge import (
    SINGLE,
    LevelDistance,
    RobotProblem,
    collect_findings,
)
from crosscheck.trial.robots.rates import BiasTerms, compute_bias_terms, make_rate_states
from crosscheck.trial.robots.sizes import compute_sizes_by_level


@dataclass(frozen=True)
class RobotTrial:
    """A user's equations of a robot, judged.

    stated: the level that they are to be of, '' for any; parts: that were judged; not_judged: what
    was not, with the reason, in words; distances: of each level, the nearest first; failures: by
    part that did not answer; agreement: all checks; relative_errors: by part, how far each entry is
    from the diagnosis' level at most, of its size; allowed: how far it may be; seed: of the states.
    """

    name: str
    robot: Robot
    stated: str
    parts: tuple[str, ...]
    not_judged: tuple[str, ...]
    distances: tuple[LevelDistance, ...]
    diagnosis: RobotDiagnosis
    failures: Mapping[str, Failure]
    agreement: Agreement
    relative_errors: Mapping[str, np.ndarray]
    allowed: Mapping[str, float]
    seed: int

    @property
    def exit_code(self) -> int:
        """The exit code of the agreement."""
        return self.agreement.exit_code

    @property
    def agrees(self) -> bool:
        """Whether all that was judged agrees with the level and every engine."""
        return self.exit_code == 0

    @property
    def largest(self) -> float:
        """The largest difference from the level, as a part of the entry's size; 0 of no part."""
        level = self.diagnosis.level
        return next((each.largest for each in self.distances if each.level == level), 0.0)


def run_robot_trial(
    equations: Equations,
    robot: Robot,
    *,
    name: str = "yours",
    seed: int = 0,
    jobs: int = 1,
    progress: ProgressCallback = ignore_progress,
) -> RobotTrial:
    """Judge a user's equations of a robot.

    Raises InputError for equations that cannot be judged, and for answers of another shape.
    """
    require_robot_equations(equations, name)
    states = draw_states(robot, seed)
    sizes = compute_sizes_by_level(robot, equations.level, states)
    level = next((each for each in sizes if each == equations.level), next(iter(sizes)))
    with register_functions(name, equations):
        answers = ask(name, robot, states, sizes[level], jobs, progress)
        problem = RobotProblem(name, robot, states, sizes, answers, equations.level)

        def rates() -> BiasTerms | None:
            source, sampled_states = answers.sources["bias"], make_rate_states(states)
            (answer,) = call_functions({source: sampled_states}, name, jobs, progress).values()
            if isinstance(answer, Failure):
                return None
            parts = np.split(answer, len(sampled_states))
            if source == "coriolis":
                pairs = zip(parts, sampled_states, strict=True)
                parts = [np.einsum("sij,sj->si", c, each.v) for c, each in pairs]
            if source == "inverse_dynamics":
                parts = [each - parts[0] for each in parts]
            return compute_bias_terms(parts)

        distances = tuple(problem.distances()) if problem.parts else ()
        diagnosis = RobotDiagnosis(level)
        if distances:
            diagnosis = diagnose(problem, distances, rates)
    relative_errors = problem.relative_errors(
        diagnosis.level, problem.reference_values[diagnosis.level]
    )
    return RobotTrial(
        name=name,
        robot=robot,
        stated=equations.level,
        parts=problem.parts,
        not_judged=tuple(_list_unjudged(problem, equations)),
        distances=distances,
        diagnosis=diagnosis,
        failures=answers.failures,
        agreement=Agreement(collect_findings(problem, diagnosis.level)),
        relative_errors={part: np.abs(off).max(axis=0) for part, off in relative_errors.items()},
        allowed={part: sizes[diagnosis.level].tolerance(part) for part in problem.parts},
        seed=seed,
    )


def _list_unjudged(problem: RobotProblem, equations: Equations) -> Iterator[str]:
    """What of equations is not judged, each with the reason."""
    failures = problem.answers.failures
    yield from (f"{part} ({why.kind})" for part, why in failures.items())
    for part in SINGLE:
        by = "coriolis" if part == "bias" else ""
        if part not in problem.parts and not {part, by, "inverse_dynamics"} & set(failures):
            weightless = part == "gravity" and problem.answers.weightless
            yield f"{part} ({'inverse_dynamics leaves it out' if weightless else 'not supplied'})"
    yield from (f"{name} (no part of equations)" for name in equations.unused)
