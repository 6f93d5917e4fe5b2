"""A robot is cross-checked as an arm is: verdict, files, page, records, one line for bad input."""

import json
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import crosscheck as package
from crosscheck.checks import convergence, engines, simulations
from crosscheck.checks.answers import ROBOT_QUESTIONS, mass_matrix
from crosscheck.checks.robot_states import SIZE_WORDS, sample_states
from crosscheck.checks.sampled import Subjects
from crosscheck.cli.commands import make_request
from crosscheck.findings import Finding
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.scenario import Start
from crosscheck.models.loading import make_rest_scenario
from crosscheck.models.mechanism import adopt_mechanism
from crosscheck.models.pinocchio.robot import PinocchioRobot
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Robot
from crosscheck.planning import robots
from crosscheck.planning.checks import plan_checks
from crosscheck.planning.comparison import Results, collect_tasks, judge_comparisons
from crosscheck.planning.plan import CrossCheckRequest, request_cross_check
from crosscheck.planning.robots import compute_robot_entries, make_cases, sample_models
from crosscheck.registry import build_robot_model
from crosscheck.runner import tasks
from tests.draws import DRAWS, SAMPLE, fresh_seed
from tests.loops import require_items
from tests.robots import chains, two_link
from tests.robots.chains import BOB, LIMIT, Solid, joint, link, random_chain, robot, urdf
from tests.schemas import assert_follows

CHAINS, MOST_JOINTS = (3, 5) if DRAWS == SAMPLE else (DRAWS, 12)
FAMILIES = {"states", "same-step", "invariants", "order"}


@pytest.fixture(autouse=True)
def few(monkeypatch):
    """Fewer random states and steps than users have."""
    monkeypatch.setattr(robots, "QUICK_COUNT", 4)
    monkeypatch.setattr(robots, "QUICK_STEPS", 20)
    monkeypatch.setattr(robots, "LEAST_STEPS", 10)


@pytest.fixture
def bob(tmp_path):
    """A pendulum's URDF alone."""
    file = tmp_path / "bob.urdf"
    file.write_text(BOB)
    return file


def test_a_urdf_alone_is_validated_with_all_its_files(crosscheck, tmp_path, bob):
    files = "--json", tmp_path / "a.json", "--junit", tmp_path / "a.xml"
    answer = crosscheck("validate", bob, "--quick", *files)
    data = json.loads((tmp_path / "a.json").read_text())
    assert_follows(data, "agreement")
    checks = [each for each in data["findings"] if each["kind"] == "check"]
    assert {each["family"] for each in data["findings"]} == FAMILIES
    assert {each["verdict"] for each in checks} == {"agree"}
    assert answer.code == 0
    engines = "The engines analytic, pinocchio and exudyn"
    verdict = f"{engines} agree with each other ({len(checks)} of {len(checks)} checks)."
    assert answer.out.splitlines()[0] == answer.out.splitlines()[-1] == verdict
    assert "level" not in answer.out
    suite = ElementTree.parse(tmp_path / "a.xml").getroot()
    assert suite.get("tests") == str(len(checks))
    assert (data["provenance"]["arm"], data["provenance"]["robot"]["name"]) == (None, "bob")


def test_an_engine_that_is_wrong_is_named_and_fails_the_command(crosscheck, monkeypatch, bob):
    monkeypatch.setattr(tasks, "build_robot_model", chains.build_wrong_exudyn)
    answer = crosscheck("validate", bob, "--quick")
    assert answer.code == 1
    assert "differ states/bob/links/gravity/analytic:links~exudyn:links" in answer.out
    alone = "differ invariants/bob/links/linear-momentum/{}:links"  # by the file's gravity
    assert alone.format("exudyn") in answer.out
    assert alone.format("pinocchio") not in answer.out


def free_tip(model: RobotModel, q: np.ndarray, v: np.ndarray, seconds: float) -> np.ndarray:
    """Place of the tip after a free motion, by another integrator."""

    def slope(time: float, state: np.ndarray) -> np.ndarray:
        q, v = state.reshape(2, 1, -1)
        return np.concatenate([v[0], model.forward_dynamics(q, v, 0 * q)[0]])

    run = solve_ivp(slope, (0, seconds), np.concatenate([q, v]), "DOP853", rtol=1e-10, atol=1e-12)
    return model.tip(run.y[None, : len(q), -1])[0]


def test_a_level_is_as_far_from_the_finest_as_its_torques_and_tips_are():
    """Torques and motions of another engine, and another integrator's steps."""
    own = load_robot("six-joint")
    planned = robots.plan_robot(CrossCheckRequest(own, quick=True))
    asked = [each for each in planned.comparisons if each.about.key.family == "deviation"]
    outcomes = {task.key: task.perform() for task in collect_tasks(asked)}
    findings = list(judge_comparisons(asked, Results(outcomes)))
    q, v, a, _ = sample_states(own, robots.QUICK_COUNT, 0)
    models = {
        level: tasks.build_robot_model("pinocchio", own, level)
        for level in ("links", "armature", "coupled")
    }
    exact = models["coupled"].inverse_dynamics(q, v, a)
    seconds = make_cases(own, sample_states(own, 3, 0), robots.QUICK_STEPS)[0].motion_s
    tips = {
        level: np.array(
            [free_tip(model, *start, seconds) for start in zip(q[:3], v[:3], strict=True)]
        )
        for level, model in models.items()
    }
    for level in ("links", "armature"):
        right = np.abs(models[level].inverse_dynamics(q, v, a) - exact).max(axis=0)
        of_level = [each for each in findings if each.left == f"analytic:{level}"]
        torques = [each for each in of_level if each.quantity == "torque"]
        assert [each.measured for each in torques] == pytest.approx(right, rel=1e-9)
        shares = right / np.abs(exact).max(axis=0)
        assert [each.relative for each in torques] == pytest.approx(shares, rel=1e-9)
        (tip,) = [each for each in of_level if each.quantity == "tip"]
        distance = np.linalg.norm(tips[level] - tips["coupled"], axis=1).max()
        assert tip.measured == pytest.approx(distance, rel=1e-3)


def test_a_joint_turns_by_all_that_follow_it():
    """The fingers of a gripper that mimic one joint turn with it."""
    fingers = [link(name, Solid()) + joint(name, "ground", name) for name in ("one", "slow")]
    follower = joint("two", "ground", "two", more=f'{LIMIT}<mimic joint="one" multiplier="-3"/>')
    own = robot(urdf(link("ground"), *fingers, link("two", Solid()), follower))
    cases = make_cases(own, sample_states(own, 2, 0), 20)
    assert [each.turns.tolist() for each in cases] == [[4.0, 1.0]] * len(cases)


NAMES = "pd", "constant-torque"


def test_engines_simulate_the_beginning_of_users_scenarios(bob, monkeypatch):
    request = request_cross_check(adopt_mechanism(str(bob), NAMES), True, 0)
    comparisons = robots.plan_robot(request).comparisons
    ids = [each.about.key.id for each in comparisons if "simulation" in each.about.key.quantity]
    assert "same-step/bob/links/simulation-pd/analytic:links~pinocchio:links" in ids
    assert {each.partition("simulation-")[2].partition("/")[0] for each in ids} == {*NAMES}
    chosen = [each for each in comparisons if each.about.key.id in ids]

    def judge() -> list[Finding]:
        outcomes = {task.key: task.perform() for task in collect_tasks(chosen)}
        return list(judge_comparisons(chosen, Results(outcomes)))

    assert {finding.verdict for finding in judge()} == {"agree"}
    right = PinocchioRobot.forward_dynamics
    monkeypatch.setattr(
        PinocchioRobot, "forward_dynamics", lambda *given: right(*given) * (1 + 1e-8)
    )
    assert "differ" in {finding.verdict for finding in judge()}


def test_of_a_motion_that_coarse_steps_blow_up_a_shorter_beginning_is_compared():
    """At 1e4 rad/s a step of some ms squares the rates, which overflow within ten."""
    own = two_link.robot()
    (case, *_) = make_cases(own, sample_states(own, 3, 0), 10)
    model = build_robot_model("analytic", own, case.level)
    moving = {"theta_rad": [0.3, 1.2], "theta_dot_rad_per_s": [1e4, -1e4]}
    start = Start.model_validate({**moving, "sun_planet_offset_m": 4e-6})
    scenario = make_rest_scenario().model_copy(update={"start": start})
    begun = robots.begin_scenario(model, case, scenario)
    coarse = begun.model_copy(
        update={"duration_s": case.run_s, "step_s": case.run_s / engines.STEPS}
    )
    with pytest.raises(Diverged):
        model.integrate(coarse)
    assert begun.duration_s < case.run_s / 8
    assert begun.start.sun_planet_offset_m == 4e-6
    assert begun.start.planet_ring_offset_m == robots.DEPTH > 0
    assert np.isfinite(model.integrate(begun)[0]).all()
    brief = scenario.model_copy(update={"duration_s": 1e-7})
    assert robots.begin_scenario(model, case, brief).duration_s == pytest.approx(1e-7)


def judge_robot(robot: Robot) -> list[Finding]:
    """The findings of all checks of a robot at few states."""
    models = sample_models(make_cases(robot, sample_states(robot, 4, 0), 10))
    comparisons, _ = plan_checks(Subjects(robots=models))
    outcomes = {task.key: task.perform() for task in collect_tasks(comparisons)}
    return list(judge_comparisons(comparisons, Results(outcomes)))


def find_alarms(robot: Robot) -> list[Finding]:
    """The checks of a robot that neither agree nor only measure."""
    return [each for each in judge_robot(robot) if each.verdict not in ("agree", "measured")]


def test_a_follower_before_a_second_branch_raises_no_false_alarm():
    """Numbers of joints and of coordinates part where a joint of an earlier branch follows."""
    body, follows = Solid(2.0, (0.1, 0.2, 0.0)), LIMIT + '<mimic joint="b" multiplier="0.5"/>'
    parts = [link("world"), *(link(name, body) for name in "ABCD")]
    parts += [joint("a", "world", "A"), joint("b", "A", "B", axis=(1.0, 0.0, 0.0))]
    parts += [joint("c", "B", "C", axis=(0.0, 1.0, 0.0), more=follows)]
    parts += [joint("d", "world", "D", axis=(0.0, 1.0, 0.0), at=(0.5, 0.0, 0.0))]
    own = robot(urdf(*parts))
    assert own.coordinates == (0, 1, 3)
    findings = judge_robot(own)
    assert {each.verdict for each in findings} <= {"agree", "measured"}
    single = [each for each in findings if ", and what" not in each.basis]  # no sum of two
    stated = [(re.match(r"([\d.e-]+) of", each.basis), each) for each in single]
    for share, finding in require_items(pair for pair in stated if pair[0]):
        assert float(share[1]) == finding.tolerance, finding  # as its reason says


@pytest.mark.campaign
def test_random_mechanisms_raise_no_false_alarm():
    first = fresh_seed()
    for seed in require_items(range(first, first + CHAINS)):
        assert find_alarms(random_chain(seed, MOST_JOINTS)) == [], seed


def test_an_energy_far_above_the_ground_is_known_to_its_rounding():
    """The weight has no part in the motion: its energy, 10 kJ, rounds more than all powers are."""
    turn = joint("turn", "ground", "arm", at=(0, 0, 1e3))
    assert find_alarms(robot(urdf(link("ground"), link("arm", Solid()), turn))) == []


@pytest.mark.parametrize(
    ("terms", "halvings", "verdict"),
    [
        ((0.5, 0.0, 0.0), 3, "agree"),
        # Orders 4.01 and 3.82 seem to tend to 3.63; the next is 3.85, and they tend to 4.
        ((-56.0, 3200.0, -57e3), 4, "agree"),
        (None, 6, "differ"),
    ],
)
def test_an_order_that_is_not_the_methods_is_confirmed_by_finer_steps(
    monkeypatch, terms, halvings, verdict
):
    """Ends of runs whose errors are h^4 (1 + a h + b h^2 + c h^3), or h^3."""
    own = two_link.robot()
    (sampled, *_) = sample_models(make_cases(own, sample_states(own, 2, 0), 10))

    def integrate(model, q, v, torques, seconds, steps):
        h = 0.1 / steps
        error = h**3 if terms is None else h**4 * np.polyval([*terms[::-1], 1.0], h)
        return q + 1 + error, v

    monkeypatch.setattr(convergence, "integrate", integrate)
    model = build_robot_model("analytic", own, sampled.setting.level)
    rows = convergence.refined_ends(model, sampled.setting)
    assert len(rows) == halvings + 2
    planned = next(convergence.plan(Subjects(robots=[sampled])))
    results = Results({task.key: rows for task in planned.needs})
    assert planned.finding(results).verdict == verdict


@pytest.mark.parametrize("change", [0.0102, 0.0098])
def test_a_run_is_resolved_if_half_its_steps_change_it_by_a_hundredth(monkeypatch, change):
    own = two_link.robot()
    case = make_cases(own, sample_states(own, 4, 0), 10)[0]

    def integrate(model, q, v, torques, seconds, steps):
        return q + 1 + change * (steps == engines.STEPS), v

    monkeypatch.setattr(robots, "integrate", integrate)
    model = build_robot_model("analytic", own, case.level)
    assert robots.is_resolved(model, case) == (change < 0.01)
    # and runs are halved until they are
    monkeypatch.setattr(robots, "is_resolved", lambda model, short: short.run_s < case.run_s / 5)
    assert robots.shorten_runs(model, case).run_s == case.run_s / 8


def test_runs_of_links_of_very_unequal_masses_are_short_enough_to_say_something(recwarn):
    """A ball of 500 t at the end of two rods of a kilogram: usual runs overflow."""
    ball, rod = Solid(5e5, (0.5, 0, 0), (200.0, 0, 0, 200, 0, 200)), Solid(1.0, (0.2, 0, 0.01))
    own = robot(
        urdf(
            link("base"),
            *(link("a", rod), link("b", rod), link("ball", ball)),
            joint("first", "base", "a", axis=(0, 1, 0)),
            joint("second", "a", "b", axis=(0, 1, 0), at=(0.5, 0, 0)),
            joint("third", "b", "ball", axis=(0, 1, 0), at=(0.5, 0, 0)),
        )
    )
    usual = two_link.robot()
    case, other = (make_cases(each, sample_states(each, 4, 0), 10)[0] for each in (own, usual))
    assert case.run_s < robots.RUN_S == other.run_s
    assert case.motion_s / robots.RUN_S == case.run_s / robots.RUN_S
    agreement = package.check(own, quick=True, jobs=1)
    assert [f.id for f in agreement.disagreeing] == []
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]


def test_torques_of_many_joints_fling_none_of_them():
    """With the first joint's the light ones turned by 1e18 rad, and rounding decided the rest."""
    own = random_chain(3104002622, 12)
    case = make_cases(own, sample_states(own, 4, 0), 10)[0]
    assert case.level == "links"
    ask = simulations.SimulationQuestion(simulations.make_scenario(case))
    first, second = (
        ask(tasks.build_robot_model(name, own, "links"), case) for name in ("analytic", "pinocchio")
    )
    assert 1e-3 < np.abs(first - first[0]).max() < np.pi
    np.testing.assert_allclose(first, second, rtol=0, atol=1e-12)
    passive = replace(own, joints=tuple(replace(each, has_motor=False) for each in own.joints))
    case = make_cases(passive, sample_states(own, 4, 0), 10)[0]
    assert simulations.make_scenario(case).drive.torque_N_m == 0.0


@pytest.mark.parametrize("joints", [3, 12])
def test_a_simulation_is_among_the_runs_that_must_be_resolved(joints, monkeypatch):
    """Also of a robot with more joints than any arm."""
    own = random_chain(3104002622, joints)
    case = make_cases(own, sample_states(own, 4, 0), 10)[0]
    scenario, asked = simulations.make_scenario(case), list[np.ndarray]()

    def integrate(model, q, v, torques, seconds, steps):
        asked.append(np.array([q[-1], v[-1], torques(0.0)[-1]]))
        return q, v

    monkeypatch.setattr(robots, "integrate", integrate)
    robots.is_resolved(build_robot_model("analytic", own, case.level), case)
    start, drive = scenario.start, scenario.drive
    expected = start.theta_rad, start.theta_dot_rad_per_s, drive.torque_N_m
    for found in require_items(asked):
        right = [np.broadcast_to(each, case.free) for each in expected]
        np.testing.assert_allclose(found, right, rtol=1e-9)  # a scenario rounds what it holds


def test_friction_that_stops_a_joint_at_once_leaves_the_runs_out_with_a_line():
    """At c / I above 2.5e8 1/s; the states are still asked."""
    for friction, are_asked in ((1e3, True), (1e10, False)):
        given = {"swing": {"kind": "direct", "friction_N_m_s_per_rad": friction}}
        plan = robots.plan_robot(CrossCheckRequest(robot(BOB, given), quick=True))
        asked = {each.about.key.quantity for each in plan.comparisons}
        assert {"mass_matrix", "forward_dynamics"} < asked
        for quantity in ("run", "simulation", "order-of-convergence", "energy"):
            is_of_runs = [
                each.about.key.quantity == quantity and each.about.key.family != "states"
                for each in plan.comparisons
            ]
            assert any(is_of_runs) == are_asked
        assert any("no runs, since steps" in line for line in plan.remarks) != are_asked


def test_every_question_to_a_model_has_a_size():
    questions = *ROBOT_QUESTIONS, engines.run
    assert {each.__name__ for each in questions} == {*SIZE_WORDS}


def test_settings_change_the_robot_that_is_checked():
    given = ["robot.joints.tilt.mesh.backlash_m=7e-5"]
    request = make_request("sliding", None, given, True, 0)
    assert request.mechanism.meshes[0][1].backlash_m == 7e-5


def test_entries_are_the_largest_differences_from_any_engine():
    """Of what engines answer for M: one is a fifth of an entry's size off, another no number."""
    pendulum = two_link.robot()
    models = sample_models(make_cases(pendulum, sample_states(pendulum, 3, 0), 10))
    first, second, third = (each for each in models if each.setting.level == "coupled")
    answers = np.zeros((3, 3, 2, 2))
    answers[1, 1, 0, 1] = 0.2
    answers[2, 2, 1, 1] = np.nan
    answers *= first.setting.sizes.mass_matrix
    asked = zip((first, second, third), answers, strict=True)
    results = Results({each.ask(mass_matrix).key: answer for each, answer in asked})
    (entries,) = compute_robot_entries(models, results)
    assert entries.engines == ("pinocchio:coupled", "exudyn:coupled")
    assert np.array(entries.relative) == pytest.approx(np.array([[0.0, 0.2], [0.0, np.inf]]))
