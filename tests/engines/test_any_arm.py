"""Arms that nobody chose: what every model owes to itself and to the others, state by state."""

from collections.abc import Callable, Iterable, Iterator

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.arms import switch_combinations
from crosscheck.planning.comparison import Comparison, Results, collect_tasks, judge_comparisons
from crosscheck.registry import MODELS, build, find_covering_models, select_with_method
from tests.any_arms import any_arms
from tests.arms import PAPER, arm_of
from tests.judged import compare_states, plan_states

PROBE = load_arm("probe")  # everything unequal
JOINTS = range(1, 8)
# exudyn:bodies solves for joint forces: with as many it would take as long as all the others.
STATES, STATES_OF_BODIES, SEED = 6, 3, 5
# An arm takes a second: no time to look for simpler ones.
DRAWN = {"database": None, "phases": [Phase.generate]}


def disagreements(arm: Arm) -> list[str]:
    """The checks of an arm that are not green, each at the state suite's tolerance."""
    return [
        *failures(arm, STATES, lambda comparison: not closed_by_constraints(comparison)),
        *failures(arm, STATES_OF_BODIES, closed_by_constraints),
    ]


def closed_by_constraints(comparison: Comparison) -> bool:
    """Whether it needs a model that closes its joints by constraint equations."""
    able = select_with_method("constraint_residual", tuple(MODELS))
    return any(task.model in able for task in comparison.needs)


def failures(arm: Arm, count: int, wanted: Callable[[Comparison], bool]) -> Iterator[str]:
    """Of the wanted comparisons of the geared and the rigid models, at so many states."""
    planned = plan_states(arm, count, SEED, groups=("geared", "form", "rigid"))
    return disagreeing(comparison for comparison in planned if wanted(comparison))


def disagreeing(comparisons: Iterable[Comparison]) -> Iterator[str]:
    """Those of the comparisons that are not green."""
    chosen = list(comparisons)
    tasks = sorted(collect_tasks(chosen), key=lambda task: task.model)  # each model is built once
    results = Results({task.key: task.perform() for task in tasks})
    for finding in judge_comparisons(chosen, results):
        if finding.kind == "check" and finding.verdict != "agree":
            yield f"{finding.id}: {finding.measured} of {finding.tolerance} {finding.note}"


@pytest.mark.slow
@pytest.mark.parametrize("joints", JOINTS)
@settings(max_examples=1, **DRAWN)
@given(data=st.data())
def test_models_agree_on_arms_that_nobody_chose(joints, data):
    assert disagreements(data.draw(any_arms(joints, unlike=True))) == []


@pytest.mark.parametrize("joints", JOINTS[:5:2])
@settings(max_examples=2, **DRAWN)
@given(data=st.data())
def test_models_agree_on_arms_whose_planets_count_as_one(joints, data):
    assert disagreements(data.draw(any_arms(joints))) == []


@pytest.mark.parametrize("joints", JOINTS[1::2])
@settings(max_examples=1, **DRAWN)
@given(data=st.data())
def test_models_agree_on_springs_that_are_a_potential(joints, data):
    arm = data.draw(any_arms(joints, unlike=True))
    planned = plan_states(arm, STATES_OF_BODIES, SEED, groups=("conservative",))
    assert list(disagreeing(planned)) == []


def far_elbow() -> Arm:
    """A first link of a kilometre: moments and places of its size cancel before an elbow's."""
    first, second = PAPER.links
    far = first.model_copy(update={"length_m": 1000.0, "com_m": 500.0})
    return PAPER.model_copy(update={"links": (far, second)})


def unlike_planets() -> Arm:
    """The paper's forms are left out of these."""
    joint, elbow = PAPER.joints
    mesh = joint.sun_mesh.model_copy(update={"backlash_m": (5e-5, 4e-5, 6e-5)})
    arm = PAPER.model_copy(update={"joints": (joint.model_copy(update={"sun_mesh": mesh}), elbow)})
    assert find_covering_models("form", arm, switches()) == ()
    return arm


EDGES = {
    "direct joints alone": lambda: arm_of(3, direct=[0, 1, 2]),
    "a far elbow": far_elbow,
    "unlike planets": unlike_planets,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", EDGES)
def test_models_agree_on_arms_at_the_edge(name):
    assert disagreements(EDGES[name]()) == []


@pytest.mark.parametrize(
    "chosen", switch_combinations(), ids=lambda laws: "-".join(dict(laws).values())
)
def test_models_agree_under_all_switches_whichever_comes_first(chosen):
    """At six states: every planted fault of a model is seen at five (tests/faults)."""
    names = find_covering_models("geared", PROBE, chosen)
    models = [build(name, PROBE, load_scenario("pd"), chosen) for name in names]
    for ordered in (models, models[::-1]):
        findings = list(compare_states("test", ordered, STATE_ABILITIES, STATES, SEED))
        assert len(findings) == len(names) * (len(names) - 1) // 2 * len(STATE_ABILITIES)
        assert [f.id for f in findings if f.verdict != "agree"] == []
