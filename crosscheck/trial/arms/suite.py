"""What is asked of an arm's equations, their answers for the judge, runs and balances."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from crosscheck.checks.inertia import SYMMETRY
from crosscheck.checks.invariants import plan_balances
from crosscheck.checks.scales import LOOSEST, acceptance_limit
from crosscheck.checks.trajectories import UNITS, Pair, check_same_step, size
from crosscheck.findings import ComparisonKey, Finding, Subject, make_check
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.planning.arms import sample_model
from crosscheck.planning.comparison import Comparison, Results, make_comparison
from crosscheck.planning.plan import perturb_start_by_one_ulp
from crosscheck.registry import MODELS, find_same_integrator_models, group_equal_levels
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.tasks import Evaluation, RunKey, Simulation
from crosscheck.trial.arms.questions import AGAIN, PART_OF, VerificationProblem
from crosscheck.trial.input.calls import LOADS
from crosscheck.trial.judge import checks, entries
from crosscheck.trial.judge.entries import NaturalSizes

RUN = "trial-run"
RIGID = ("theta", "theta_dot", "kinetic_energy")
MESH = ("x_sp", "x_pr")
LOST = Failure("Lost", "no result came back")


def list_quantities(problem: VerificationProblem) -> list[str]:
    """What is asked of the equations."""
    has, equations = problem.has, problem.equations
    parts = [part for part in checks.COMPARED if part in has]
    supplied = [p for p in parts if p not in LOADS or getattr(equations, p) is not None]
    is_there = {
        "other_speeds": "bias" in has,
        "rate_terms": {"mass_matrix", "bias"} <= has,
        "christoffel": {"mass_matrix", "bias"} <= has,
        "gravity_slopes": "gravity" in has,
        "inverse_dynamics": equations.inverse_dynamics is not None,
        "by_torques": equations.force is not None and bool(problem.motors),
    }
    more = [quantity for quantity, there in is_there.items() if there]
    return [*parts, *(f"{part}{AGAIN}" for part in supplied), *more]


def collect_answers(problem: VerificationProblem, results: Results) -> checks.AnswerSet:
    """The answers of the equations, to be judged. Raises MissingResult without a reference's M."""
    values, failures = dict[str, np.ndarray](), dict[str, Failure]()
    for quantity in list_quantities(problem):
        outcome: Any = results.outcomes.get(problem.ask_equations(quantity), LOST)
        if isinstance(outcome, Failure):
            part = quantity.removesuffix(AGAIN)
            failures.setdefault(PART_OF.get(part, part), outcome)
        else:
            values[quantity] = outcome
    parts = {part: values[part] for part in checks.COMPARED if part in values}
    natural = {part: _sizes_in_user_unit(problem, results, part) for part in parts}
    sizes = {part: checks.make_part_size(each, part) for part, each in natural.items()}
    identities, symmetry, by_mass = list[checks.Identity](), None, natural.get("mass_matrix")
    if by_mass is not None:
        rounding = SYMMETRY + by_mass.file_rounding("mass_matrix")
        symmetry = checks.PartSize(by_mass.mass, rounding, "rounding of the entries' natural sizes")
        if {"rate_terms", "christoffel"} <= set(values):
            size, demanded = checks.make_part_size(by_mass, "rate_terms"), values["christoffel"]
            terms = values["rate_terms"][: len(demanded)]
            identities.append(checks.Identity(*checks.CHRISTOFFEL, size, terms, demanded, axes=3))
        if "inverse_dynamics" in values:
            given, expected, a = values["inverse_dynamics"].swapaxes(0, 1)
            whole = by_mass.bias + by_mass.mass @ np.abs(a).max(axis=0)
            size = checks.make_part_size(by_mass, "bias")._replace(entries=whole)
            identities.append(checks.Identity(*checks.INVERSE, size, given, expected))
    if "gravity" in parts and "gravity_slopes" in values:
        size = sizes["gravity"]._replace(entries=natural["gravity"].gravity_slopes)
        size, slopes = size.scale_to_slopes(), values["gravity_slopes"]
        gradient = checks.Identity(*checks.GRADIENT, size, slopes, slopes.swapaxes(1, 2), axes=2)
        identities.append(gradient)
    if problem.equations.acceleration is not None and set(parts) >= {*checks.WHOLE}:
        gravity = parts.get("gravity", 0.0)
        identities.append(checks.make_second_law(sizes["force"], parts, gravity, parts["force"]))
    return checks.AnswerSet(
        name=problem.name,
        mechanism=problem.case.arm.name,
        names=problem.frame.names,
        states=problem.states_in_words,
        values=parts,
        sizes=sizes,
        symmetry=symmetry,
        repeated={p: values[f"{p}{AGAIN}"] for p in parts if f"{p}{AGAIN}" in values},
        failures=failures,
        other_speeds=values.get("other_speeds"),
        by_torques={"force": values["by_torques"]} if "by_torques" in values else {},
        identities=identities,
    )


def judge_engines(
    problem: VerificationProblem, answers: checks.AnswerSet, level: str
) -> Iterator[Finding]:
    """Compare every part with every engine: they must agree at this level.

    Of levels that are equal on the arm one is enough.
    """
    groups = group_equal_levels(problem.case.arm)
    distinct = {level, *(group[0] for group in groups if level not in group)}
    for each in (each for each in problem.levels if each in distinct):
        natural, engines = problem.compute_sizes(each), problem.engines(each)
        sizes = {part: checks.make_part_size(natural, part) for part in answers.values}
        by_engine = {
            engine: {part: problem.evaluate(engine, part) for part in answers.values}
            for engine in engines
        }
        for engine, values in by_engine.items():
            right = by_engine[engines[0]]
            yield from checks.judge_engine(
                answers, engine, values, sizes, right, is_binding=each == level
            )


def _sizes_in_user_unit(
    problem: VerificationProblem, results: Results, unit_part: str
) -> NaturalSizes:
    """Natural sizes by the level that is nearest, in the unit of the equations' own numbers.

    They size the self-consistency checks: only the power of ten of the user's unit enters them.
    Raises MissingResult.
    """
    user_values, ratios = results.need(problem.ask_equations(unit_part)), dict[str, float]()
    for level in problem.levels:
        right = problem.find_right(level, unit_part)
        ratios[level] = 1.0 if right is None else entries.unit_ratio(user_values, right)
    nearest = min(problem.levels, key=lambda level: abs(math.log(ratios[level])))
    sizes = problem.compute_sizes(nearest)
    return sizes.scale_by(entries.power_of_ten(ratios[nearest]))


def plan_balance_checks(problem: VerificationProblem) -> Iterator[Comparison]:
    """Checks of power and momentum, for geared equations that have everything.

    There are none if the map is a function: it need not reach every pose that these checks draw.
    """
    rigid = problem.gearing == "rigid"
    if rigid or problem.frame.matrix is None or not problem.has >= {*checks.WHOLE}:
        return
    name, case = problem.name, problem.case
    reference = sample_model(
        case.arm.name, problem.reference(""), case, problem.count, problem.seed
    )
    sampled = replace(reference, model=name, evaluate=partial(Evaluation, name))
    for balance in plan_balances(sampled):
        judge = partial(_judge_balance, problem, balance)
        yield Comparison(balance.about, balance.needs, judge)


def _judge_balance(
    problem: VerificationProblem, balance: Comparison, about: Subject, results: Results
) -> Finding:
    """The finding of a balance, its tolerance widened by the rounding of the coordinates' map."""
    finding, sizes = balance.judge(about, results), problem.compute_sizes("")
    if finding.measured is None or finding.tolerance is None:
        return finding
    looser = sizes.tolerance("acceleration") / LOOSEST
    return make_check(
        about,
        measured=finding.measured,
        tolerance=finding.tolerance * looser,
        basis=f"{finding.basis}; times {looser:.3g}: {sizes.basis('acceleration')}",
        relative=finding.relative,
    )


def plan_run_comparisons(
    problem: VerificationProblem, scenario: Scenario, level: str
) -> Iterator[Comparison]:
    """Compare a scenario's run by the equations with each engine that takes the same steps."""
    engines = find_same_integrator_models()
    if level:
        engines = tuple(name for name in problem.engines(level) if MODELS[name].order == 4)
    meshes = () if level or not problem.frame.layout.mesh_joints else MESH
    for engine in engines:
        for quantity in (*RIGID, *meshes):
            yield _compare_same_steps(problem, scenario, engine, quantity)


def _compare_same_steps(
    problem: VerificationProblem, scenario: Scenario, engine: str, quantity: str
) -> Comparison:
    case, name = problem.case._replace(scenario=scenario), scenario.name
    user_run = Simulation(RunKey(name, problem.name), case)
    engine_run = Simulation(RunKey(name, engine), case)
    repeated = Simulation(RunKey(name, engine, "nudged"), perturb_start_by_one_ulp(case))

    def judge(about: Subject, yours: Any, theirs: Any, nudged: Any) -> Finding:
        widest = acceptance_limit(quantity, case.arm, scenario, size(theirs, quantity))
        return check_same_step(about, yours, theirs, Pair(theirs, nudged), widest)

    key = ComparisonKey(RUN, name, quantity, problem.name, engine)
    about = Subject(key, UNITS[quantity], "largest absolute difference")
    return make_comparison(about, (user_run, engine_run, repeated), judge)
