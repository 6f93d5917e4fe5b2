"""What a check says beside its verdict: every number in its words is one that it was given."""

import re
from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from itertools import islice
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from syrupy.assertion import SnapshotAssertion

from crosscheck.checks import (
    convergence,
    energy,
    inertia,
    invariants,
    levels,
    modes,
    motion,
    records,
    trajectories,
)
from crosscheck.checks.answers import BadAnswer, require_numbers
from crosscheck.checks.records import _find_faults
from crosscheck.checks.robot_states import RobotSizes
from crosscheck.checks.scales import ReasonedLimit, share_of
from crosscheck.checks.stability import relax_comparison
from crosscheck.findings import (
    ComparisonKey,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_measurement,
    make_share_check,
    make_unfinished_check,
)
from crosscheck.identification.engines import describe_disagreement, describe_engines
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import Case, load_arm, load_scenario
from crosscheck.models.trajectory import recorded_times
from crosscheck.planning.arms import plan_experiment_comparisons
from crosscheck.planning.comparison import Comparison, Results
from crosscheck.planning.plan import Experiment
from crosscheck.planning.preparation import _describe_sizes
from crosscheck.planning.sizing import GrowingMode, Sizes

SUBJECT = Subject(ComparisonKey("family", "case", "theta", "one", "other"), "rad", "largest")
WIDE = ReasonedLimit(0.0333333, "by the play")


def run(*last_rad: float, steps: int = 400) -> xr.Dataset:
    """A run of two joints in two records, the first at rest, that ends at these angles [rad]."""
    theta = np.array([[0.0, 0.0], last_rad])
    labels = {"time": [0.0, steps * 1e-3], "joint": [1, 2]}
    return xr.Dataset({"theta": (("time", "joint"), theta)}, labels, {"step_s": 1e-3})


def of_joint(number: int) -> Subject:
    """The subject of one joint alone."""
    return Subject(ComparisonKey("deviation", "case", "theta", "one", "other", number), "rad", "")


FINE, COARSE, OTHER = run(1.0, 4.0), run(1.0, 4.0 + 2.0**-20), run(1.0, 4.0 + 2.0**-24)
NUDGED = trajectories.Pair(FINE, run(1.0 + 2.0**-50, 4.0))
POLES = 1j * np.array([2.0, -2.0])
SLOPES = np.array([[[-4.0, 0.0]], [[-4.0 * (1 + 2e-7) ** 2, 0.0]]])

# By what is made, so that all of its words can be read beside each other in the snapshot.
SAID: dict[str, Callable[[], Finding]] = {
    "the same steps": lambda: trajectories.check_same_step(SUBJECT, FINE, OTHER, NUDGED, WIDE),
    "refined runs": lambda: trajectories.check_refined_runs(
        SUBJECT, (FINE, FINE, COARSE), (OTHER, OTHER, run(1.0, 4.0)), WIDE
    ),
    "an order": lambda: convergence.check_formal_order(
        SUBJECT, *[run(0.0, by).rename(theta="x_sp") for by in (9.0, 1.0, 0.5)], formal=4
    ),
    "an order through impacts": lambda: convergence.measure_impact_order(
        SUBJECT, *[run(0.0, by).rename(theta="x_sp") for by in (9.0, 1.0, -1.0)]
    ),
    "a stable step": lambda: records.check_stable_step(SUBJECT, np.array(1.23456e-5), 2.34567e-6),
    "any step": lambda: records.check_stable_step(SUBJECT, np.array(np.inf), 2.34567e-6),
    "a rounding": lambda: trajectories.measure_sensitivity(SUBJECT, run(1.0, 4.0), run(1.0, 5.0)),
    "a deviation": lambda: trajectories.measure_deviation(
        of_joint(1), run(1.5, 4.0), run(2.0, 9.0)
    ),
    "a deviation from rest": lambda: trajectories.measure_deviation(
        of_joint(2), run(1.5, 4.0), run(2.0, 0.0)
    ),
    "a balance": lambda: invariants.check_balance(
        SUBJECT, np.array([1e-12, -4e-12]), np.array([3.0, 5.0])
    ),
    "an M": lambda: inertia.check_inertia(
        SUBJECT, np.array([np.eye(2), [[4.0, 1.0], [1.0 + 6e-13, 9.0]]]), None
    ),
    "an M that is not definite": lambda: inertia.check_inertia(
        SUBJECT, np.array([np.eye(2), [[1.0, 1.0], [1.0, 1.0 - 1e-9]], np.eye(2)]), None
    ),
    "joints that stay closed": lambda: invariants.check_constraints(
        SUBJECT, np.array([1e-13, 2e-13]), None
    ),
    "no work": lambda: energy.check_energy_over_run(SUBJECT, run(0.0, 1.0)),
    "modes": lambda: modes.check_modes(
        SUBJECT, np.array([100.0, 250.125]), np.array([100.0, 250.125 * (1 + 1e-7)])
    ),
    "poles": lambda: modes.check_poles(SUBJECT, POLES * (1 + 3e-8), np.eye(1), SLOPES),
    "a step by poles": lambda: modes.check_step_limit(
        SUBJECT, np.array(1.23456), np.eye(1), SLOPES
    ),
    "a share": lambda: make_share_check(SUBJECT, 0.5, 0.25, 4.0, "the way", ", as measured"),
    "a share of nothing": lambda: make_share_check(SUBJECT, 0.0, 0.25, 0.0, "the way"),
    "no number": lambda: make_measurement(SUBJECT, measured=float("inf")),
    "no tolerance": lambda: make_share_check(SUBJECT, 1.0, 0.25, float("nan"), "the way"),
}


@pytest.mark.parametrize("name", SAID)
def test_a_check_says_what_it_was_given(name, snapshot: SnapshotAssertion):
    """The words and the note, and between them the part of the quantity's size, if it has one."""
    found = SAID[name]()
    assert found.about.unit == "rad"
    share = "" if found.relative is None else f"{found.relative:.3g} of its size"
    assert [found.basis, share, found.note] == snapshot


def test_of_an_unstable_loop_nothing_is_judged_but_what_agrees_or_failed():
    case = Case(load_arm("three-unlike"), load_scenario("pd"), switches())
    experiment = Experiment("pd", case, GrowingMode(2.0, 30.0))
    growth = "the loop is unstable while teeth touch: +2 1/s at 30 Hz"
    found = {
        "agree": make_check(SUBJECT, measured=1.0, tolerance=2.0, basis="so"),
        "differ": make_check(SUBJECT, measured=3.0, tolerance=2.0, basis="so", relative=0.5),
        "unresolved": make_check(SUBJECT, measured=1.0, tolerance=2.0, basis="so", resolved=False),
        "failed": make_failed_check(SUBJECT, "no run"),
        "unfinished": make_unfinished_check(SUBJECT, "no time"),
    }
    judged = {}
    for verdict, finding in found.items():
        assert finding.verdict == verdict
        planned = Comparison(SUBJECT, (), lambda about, results, made=finding: made)
        relaxed = relax_comparison(experiment, planned)
        judged[verdict] = relaxed.finding(Results({}))
    words = f"not judged, for {growth}; else so"
    measured = partial(make_measurement, SUBJECT, basis=words)
    assert judged == {
        "agree": found["agree"],
        "differ": measured(measured=3.0, relative=0.5),
        "unresolved": measured(measured=1.0),
        "failed": make_failed_check(SUBJECT, f"no run; {growth}"),
        "unfinished": make_unfinished_check(SUBJECT, f"no time; {growth}"),
    }
    *_, stability = (c for c in plan_experiment_comparisons(experiment) if not c.needs)
    said = stability.finding(Results({}))
    assert said == make_measurement(stability.about, measured=2.0, note=growth)
    assert stability.about.key.id == "stability/pd/growth-rate/analytic:physical"
    assert stability.about.unit == "1/s"


def test_experiment_sizes_have_units():
    sizes = Sizes(5.25, (1.0, 2.0), (31.25, 32.5), (41.5, 42.25), (11.5, -12.75), 321.25)
    head, step, motion = _describe_sizes(sizes, ())
    assert head.endswith("mesh mode 321.2 Hz, controller at 5.25 rad/s")
    assert step == "torque-step: 11.5, -12.75 N m"
    assert motion.endswith("0.5, -0.5 rad, P 31.25, 32.5 N m/rad, D 41.5, 42.25 N m s/rad")


def test_runs_in_the_same_steps_are_compared_whole_and_at_an_instant(monkeypatch):
    judged: list[tuple[str, float | None]] = []

    def note(about: Subject, left: Any, right: Any, pair: Any, widest: Any, *time: float) -> None:
        judged.append((about.key.family, *(time or (None,))))

    monkeypatch.setattr(trajectories, "check_same_step", note)
    monkeypatch.setattr(trajectories, "find_acceptance_limit", lambda *given: None)
    arm = load_arm("probe")
    experiment = Experiment("pd", Case(arm, load_scenario("pd"), usual_switches(arm)))
    answers = SimpleNamespace(need=lambda task: task)
    for comparison in trajectories.plan_fixed_steps(experiment):
        comparison.judge(comparison.about, answers)
    instant = f"at-{trajectories.MIDWAY_S:g}-s"
    assert set(judged) == {("same-step", None), (instant, trajectories.MIDWAY_S)}


def test_an_incomplete_run_is_refused_with_what_it_has_and_what_it_must_have():
    case = Case(load_arm("probe"), load_scenario("constant-torque"), switches())
    times = recorded_times(case.scenario)
    theta = (("joint", "time"), np.zeros((2, 3)))
    run = xr.Dataset({"theta": theta}, {"time": times[:3], "joint": [1, 3]})
    assert list(islice(_find_faults(run, case, ("theta",)), 3)) == [
        f"the run has 3 times, the scenario asks for {len(times)}",
        "the run has joint [1, 3], must be [1, 2]; missing [2]",
        "theta is over ('joint', 'time'), must be over ('time', 'joint')",
    ]
    with pytest.raises(BadAnswer, match=r"^M is a list, must be an array$"):
        require_numbers([1.0], "M", None)


def test_tips_are_apart_by_what_the_joints_have_turned():
    """The first joint turns a stretched arm by a right angle; the elbow folds it."""
    arm = load_arm("probe")
    first, second = (link.length_m for link in arm.links)
    straight, folded = run(0.0, 0.0), run(0.0, np.pi)
    turned = levels.measure_tip_deviation(SUBJECT_OF_TIP, straight, run(np.pi / 2, 0.0), arm)
    assert turned.measured == pytest.approx(np.sqrt(2) * (first + second))
    assert turned.relative == pytest.approx(np.sqrt(2))
    found = levels.measure_tip_deviation(SUBJECT_OF_TIP, folded, straight, arm)
    assert found.measured == pytest.approx(2 * second)
    assert found.relative == pytest.approx(2 * second / (first + second))
    place = levels.tip_position(run(0.3, -0.5), arm).values[-1]
    expected = first * np.exp(0.3j) + second * np.exp(-0.2j)
    assert complex(*place) == pytest.approx(expected)


SUBJECT_OF_TIP = replace(SUBJECT, key=replace(SUBJECT.key, quantity="tip"), unit="m")


def beside(other: str, measured: float, note: str = "") -> Finding:
    """Of an engine beside another on a recording."""
    about = Subject(ComparisonKey("recording", "arm/links", "torque", "one", other), "1", "")
    return make_check(about, measured=measured, tolerance=1e-12, basis="", note=note)


GOOD, NEAR, FAR = beside("a", 2e-13), beside("b", 3e-12, "b."), beside("c", 4.44e-9, "c.")
LOST = make_failed_check(replace(GOOD.about, key=replace(GOOD.about.key, right="d")), "d died")
ENGINES = {
    "all agree": (GOOD, GOOD),
    "two differ": (GOOD, NEAR, FAR),
    "one stands alone": (GOOD, FAR),
    "the first stands alone": (FAR, LOST),
    "one has no answer": (GOOD, FAR, LOST),
    "there is but one": (LOST,),
}


@pytest.mark.parametrize("name", ENGINES)
def test_of_engines_on_a_recording_the_worst_is_reported(name, snapshot: SnapshotAssertion):
    findings = ENGINES[name]
    lines = list(describe_engines(findings))
    if any(each.verdict != "agree" for each in findings):
        lines += ["", *describe_disagreement(findings, "arm")]
    assert "\n".join(lines) == snapshot


def ends(*last: float, energies: tuple[float, ...] = ()) -> np.ndarray:
    """A robot's start at 0, and where runs in finer and finer steps end; their energies."""
    rows = [[0.0, 0.5], *([0.5 * each, each] for each in last)]
    rows[0] = [0.0, 0.0]
    return np.column_stack([rows, energies or np.zeros(len(rows))])


CASE: Any = SimpleNamespace(sizes=SimpleNamespace(energy=np.array([4.0])))


def test_orders_of_a_robots_runs_are_reported_with_two_digits_more_than_their_tolerance():
    """Differences of 16 and 16, then of 2^4.2 and 2^4.1, whose limit is 4.0; and of 2^3 alone."""
    found = convergence._check_order(SUBJECT, ends(*(1 + 16.0**-n for n in range(4))), CASE)
    assert re.findall(r"\d\.\d+", found.note) == ["4.000", "4.000"]
    assert (found.measured, found.tolerance) == (pytest.approx(0.0), 0.2)
    steps = np.cumsum([0.0, 1.0, 2**-4.2, 2**-8.3])
    found = convergence._check_order(SUBJECT, ends(*(10 + steps)), CASE)
    assert re.findall(r"\d\.\d+", found.note) == ["4.100", "4.200"]
    assert (found.verdict, found.measured) == ("agree", pytest.approx(0.0, abs=1e-9))
    found = convergence._check_order(SUBJECT, ends(*(1 + 8.0**-n for n in range(4))), CASE)
    assert (found.verdict, found.measured) == ("differ", pytest.approx(1.0))
    unsettled = convergence._check_order(SUBJECT, ends(1.0, 2.0, 2.5, 2.505), CASE)
    assert (unsettled.verdict, unsettled.note[-10:]) == ("measured", "1.00, 6.64")
    still = convergence._check_order(SUBJECT, ends(1.0, 1.0, 1.0, 1.0), CASE)
    assert still.note.endswith("orders none")
    for least, count in ((1.02e-11, 1), (0.98e-11, 0)):  # of a motion of 1, next to its rounding
        assert (
            len(convergence.observe_order(ends(1.0, 1 + 16 * least, 1 + 17 * least)).orders)
            == count
        )


@pytest.mark.parametrize(("part", "verdict"), [(1.02, "differ"), (0.98, "agree")])
def test_slopes_of_an_energy_have_the_rounding_of_its_terms(part, verdict):
    sizes = SimpleNamespace(energy=np.array([7.0]), motion=np.array([2.0]), gravity=np.zeros(1))
    case: Any = SimpleNamespace(sizes=sizes, steps=np.array([0.04]))
    slopes = np.array([[3.0 + part * 100 * 2.0**-52 * 5.0 / 0.04]])
    assert motion._check_slopes(SUBJECT, np.array([[3.0]]), slopes, case).verdict == verdict


def test_energy_of_a_robots_runs_may_change_by_what_their_last_halving_changes():
    energies = (8.0, 0.0, 0.0, 8.0 + 2e-9, 8.0 + 4e-10)
    found = convergence._check_energy(SUBJECT, ends(1.0, 1.0, 1.0, 1.0, energies=energies), CASE)
    assert found.measured == pytest.approx(1e-10, rel=1e-4)
    assert found.tolerance == pytest.approx(1e-10 + 4e-10, rel=1e-4)
    assert found.relative == found.measured
    assert (found.verdict, found.basis[:26]) == ("agree", "1e-10 of the energy's size")
    energies = (8.0, 0.0, 0.0, 8.0, 8.0 + 4.1e-3)
    found = convergence._check_energy(SUBJECT, ends(1.0, 1.0, 1.0, 1.0, energies=energies), CASE)
    note = "not asked: halving the step changes 0.001 of the energy"
    assert (found.verdict, found.note) == ("measured", note)
    assert found.measured == pytest.approx(4.1e-3 / 4)


def test_share_of_zero_is_infinite_or_undefined():
    share = share_of
    assert share(np.array([1.0, -6.0]), np.array([2.0, 3.0])) == 2.0
    assert share(np.zeros(2), np.zeros(2)) == 0.0
    assert share(np.array([1e-3]), np.zeros(1)) == 1e297
    assert share(np.array([np.inf]), np.ones(1)) == 1e300
    assert np.isnan(share(np.array([np.nan, 1.0]), np.ones(2)))
    assert share(np.zeros(0), np.zeros(0)) == 0.0


def test_what_solving_with_m_loses_counts_where_m_is_solved_with():
    """1000 roundings times the condition number; else a part of the size that is far above them."""
    arrays = {each.name: np.zeros(1) for each in fields(RobotSizes) if each.name != "condition"}
    sizes = RobotSizes(**arrays, condition=1.23456e6)
    far = 1000 * 2.0**-52 * 1.23456e6
    assert sizes.tolerance("bias") == 1e-10
    plain = sizes.basis("bias")
    assert plain.startswith("1e-10 of the entry's natural size")
    for quantity in ("forward_dynamics", "run", "acceleration"):
        assert sizes.tolerance(quantity) == pytest.approx(far, rel=1e-12)
        assert sizes.basis(quantity) == "2.2e-13 times the condition number of M, 1.2e+06"
        small = replace(sizes, condition=3.0)
        assert (small.tolerance(quantity), small.basis(quantity)) == (1e-10, plain)
