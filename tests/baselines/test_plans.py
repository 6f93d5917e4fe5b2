"""What a cross-check plans, as on record: what is compared, by which runs, in which words."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.checks.answers import Setting
from crosscheck.checks.sampled import Subjects
from crosscheck.cli.files.template import make_plain_arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.loading import Case, load_arm, load_scenario
from crosscheck.models.robot.file import load_robot
from crosscheck.planning import arms, plan, preparation
from crosscheck.planning.checks import plan_checks
from crosscheck.planning.comparison import Comparison, collect_tasks
from crosscheck.planning.preparation import Preparation
from crosscheck.planning.robots import plan_robot
from crosscheck.runner.tasks import Evaluation, Simulation
from tests.judged import plan_states

LIMIT_S = 1e-5  # of the stable steps


def arm_plan() -> Iterator[str]:
    """Of an arm of unequal numbers under the paper's controller, of the built-in probe, of forms.

    The paper's own forms are of its arm alone.
    """
    arm = load_arm("three-unlike")
    first = plan.Experiment("pd", Case(arm, load_scenario("pd"), usual_switches(arm)))
    first = plan.set_stable_step(first, LIMIT_S)
    planned = [
        *plan_states(arm, arms.QUICK_COUNT, 0),
        *plan_checks(Subjects(arms=list(arms.sample_switches(arm, 0))))[0],
    ]
    for experiment in (
        first,
        plan.make_probe_experiment(),
        *plan.make_energy_experiments(arm, first, LIMIT_S),
        *plan.make_short_experiments(arm, first, LIMIT_S),
        *plan.make_order_experiments(arm, first, LIMIT_S),
    ):
        planned += arms.plan_experiment_comparisons(experiment)
    papers = plan.Experiment("papers", Case(load_arm("paper-labelled"), *first.case[1:]))
    beside = [
        *plan_states(papers.case.arm, arms.QUICK_COUNT, 0),
        *arms.plan_experiment_comparisons(papers),
    ]
    planned += [each for each in beside if each.about.key.family.startswith("form")]
    yield from describe_comparisons(planned)
    recorded = {each.needs for each in planned if each.about.key.family == "record"}
    for task in collect_tasks(planned):
        if isinstance(task, Simulation):
            yield f"{describe_run(task)}; {'recorded' if (task,) in recorded else 'not recorded'}"


def robot_plan() -> Iterator[str]:
    """Of a robot with gears and teeth, at all its levels."""
    planned = plan_robot(plan.CrossCheckRequest(load_robot("sliding"), quick=True))
    yield from describe_comparisons(planned.comparisons)
    yield from planned.remarks


def describe_comparisons(planned: Iterable[Comparison]) -> Iterator[str]:
    """Comparisons alike in all but their quantities, models and cases have one line."""
    quantities = dict[tuple[str, ...], dict[str, None]]()
    for each in planned:
        about, key = each.about, each.about.key
        if key.family == "record":  # one of every run, see below
            continue
        models = {name: f"<{n}>" for n, name in enumerate((key.left, key.right), 1) if name}
        needs = ", ".join(dict.fromkeys(describe_task(task, models) for task in each.needs))
        pair = "~".join(filter(None, (key.left, key.right)))
        words = key.family, about.metric, about.against, needs.replace(key.quantity, "<it>")
        joint = "" if key.joint is None else f"joint {key.joint} "
        said = f"{joint}{key.quantity} [{about.unit}]"
        quantities.setdefault((*words, key.case, pair), {})[said] = None
    pairs, cases = dict[tuple[str, ...], list[str]](), dict[tuple[str, ...], list[str]]()
    for (*words, case, pair), of in quantities.items():
        pairs.setdefault((*words, ", ".join(of), case), []).append(pair)
    for (*words, case), names in pairs.items():
        cases.setdefault((*words, ", ".join(names)), []).append(case)
    for words, of in cases.items():
        yield " | ".join((*words, ", ".join(of)))


def describe_task(task: Any, models: dict[str, str]) -> str:
    """A run, or a question and at how many states."""
    model = models.get(task.model, task.model)
    if isinstance(task, Simulation):
        return f"{task.key.variant or 'run'} of {model}"
    is_of_arm = isinstance(task, Evaluation) and isinstance(task.setting, Setting)
    count = f" x {task.setting.count}" if is_of_arm and task.setting.count > 1 else ""
    return f"{task.key.quantity}{count} of {model}"


def describe_run(task: Simulation) -> str:
    """The numbers of a run."""
    _, scenario, laws = task.case
    numbers = {
        "step": scenario.step_s,
        "steps": scenario.steps,
        "every": scenario.stride,
        "rtol": task.rtol or 0.0,
    }
    said = ", ".join(f"{name} {number:.6g}" for name, number in numbers.items())
    rows = drive_data(scenario, len(task.case.arm.joints)).gains.tolist()
    start = ", ".join(f"{angle:.6g}" for angle in np.atleast_1d(scenario.start.theta_rad))
    drive = "; ".join(" ".join(f"{number:.5g}" for number in row) for row in rows)
    ahead = np.atleast_1d(scenario.start.sun_planet_offset_m)
    teeth = ", ".join(f"{offset:.5g}" for offset in ahead) if ahead.any() else ""
    stretched = f"; start of teeth {teeth} m" if teeth else ""
    return f"{task.key}: {said}, planets {laws.planets}; start {start}{stretched}; drive {drive}"


@pytest.mark.parametrize("plan_of", [arm_plan, robot_plan])
def test_a_plan_is_as_on_record(plan_of: Callable[[], Iterator[str]], snapshot: SnapshotAssertion):
    lines = list(plan_of())
    assert len(lines) > 20
    assert "\n".join(lines) == snapshot


def test_entries_are_compared_at_the_states_of_the_seed(monkeypatch):
    request = plan.CrossCheckRequest(load_arm("paper-labelled"), quick=True, seed=7)
    monkeypatch.setattr(arms, "prepare_experiments", lambda *given: Preparation((), 1.0, ()))
    monkeypatch.setattr(arms, "plan_comparisons", lambda *given: [])
    entries: Any = arms.plan_arm(request, None).compute_entries  # type: ignore[arg-type]
    settings = [model.setting for model in entries.args[1]]
    assert {(each.seed, each.count) for each in settings} == {(7, arms.QUICK_COUNT)}


def test_arms_that_are_not_the_papers_are_planned_as_what_they_are():
    """A user's own probe beside the built-in one; one without gears by no printed equations."""
    own = load_arm("probe").model_copy(update={"payload_mass_kg": 1.5})
    sampled = arms.sample_request(plan.CrossCheckRequest(own, quick=True))
    places = [(each.where, each.model) for each in sampled]
    assert len(set(places)) == len(places)
    assert preparation._describe_forms(make_plain_arm("plain", 2)) == []
    short = load_scenario("pd").model_copy(update={"duration_s": 0.02})
    rigid = plan.Experiment("short", Case(own, short, usual_switches(own))).run("analytic:coupled")
    assert rigid.case.scenario.step_s == pytest.approx(1e-5)  # 2000 steps of 0.02 s
    papers = plan.CrossCheckRequest(load_arm("paper-labelled"), chosen=usual_switches(own))
    assert len(plan.draft_experiments(papers, None)) == 2  # none by other laws
