"""`crosscheck simulate` of robots: every engine at every level, its file, and what is refused."""

import json

import numpy as np
import pytest
import xarray as xr

from crosscheck.analytic.ensemble import group_models
from crosscheck.analytic.robot.runs import RobotMember
from crosscheck.api import simulate
from crosscheck.cli.simulation import list_beyond_ranges
from crosscheck.models.errors import Diverged, InputError
from crosscheck.models.experiment.scenario import PdDrive, Scenario, switches
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import RobotSource, load_robot
from crosscheck.models.robot.robot import LEVELS
from crosscheck.provenance import ROOT
from crosscheck.registry import build
from tests.faults.robots import ROBOTS
from tests.loops import require_items
from tests.robots import chains, two_link
from tests.tool.test_bad_input import assert_one_line

PLANETARY = str(ROOT / "examples" / "robots" / "planetary-arm.toml")
DRIVES = {
    "constant": {"torque_N_m": [9.0, -4.0, 2.0]},
    "pd": {
        "target_rad": [0.5, -0.3, 0.2],
        "proportional_N_m_per_rad": [90.0, 80.0, 50.0],
        "derivative_N_m_s_per_rad": [4.0, 3.0, 6.0],
    },
    "sinusoid": {"amplitude_N_m": 5.0, "rate_rad_per_s": [50.0, 70.0, 90.0], "argument": "time"},
    "table": {
        "time_s": [0.0, 0.7e-3, 2e-3],
        "torque_N_m": [[0.0, 30.0, -20.0], [10.0, -10.0, 40.0], [3.0, 0.0, -5.0]],
    },
}


def experiment(drive: str = "pd", joints: int = 3, **changes: object) -> Scenario:
    """30 steps from a start in motion."""
    law = {
        key: value[:joints] if isinstance(value, list) and key != "time_s" else value
        for key, value in DRIVES[drive].items()
    }
    start = {
        "theta_rad": [0.3, -0.2, 0.5][:joints],
        "theta_dot_rad_per_s": [0.6, -0.9, 0.7][:joints],
    }
    return Scenario.model_validate(
        {
            "schema_version": 1,
            "name": "swing",
            "duration_s": 3e-4,
            "step_s": 1e-5,
            "start": start,
            "drive": {"kind": drive, **law},
            **changes,
        }
    )


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("level", LEVELS)
def test_engines_run_alike(drive, level):
    """The same steps: they differ by rounding, that teeth as stiff as these enlarge."""
    robot, scenario = ROBOTS["unlike"](), experiment(drive)
    assert robot.joints[-1].mimic is not None
    runs = [simulate(build(f"{engine}:{level}", robot, scenario)) for engine in chains.ENGINES]
    for name in ("theta", "theta_dot", "torque", "kinetic_energy"):
        first, *others = (run[name].values for run in runs)
        assert np.isfinite(first).all()
        for other in others:
            assert other == pytest.approx(first, abs=1e-8 * np.abs(first).max())


@pytest.mark.parametrize("level", LEVELS)
def test_members_side_by_side_have_every_signal_of_their_own_runs(level):
    """Unlike starts: each record of each member is as its robot alone has it."""
    own = ROBOTS["staged"]()
    other = {"theta_rad": [-0.4, 0.1, 0.2], "theta_dot_rad_per_s": [0.0, 0.8, -0.3]}
    scenarios = [experiment(), experiment(start=other)]
    names = ["theta", "theta_dot", "theta_ddot", "torque"]
    names += ["x_mesh", "x_mesh_dot", "F_mesh"] if level == "geared" else []
    (group,) = group_models([RobotMember(own, level, each) for each in scenarios])
    chunks = list(group.chunks())
    for lane, place in require_items(enumerate(group.members)):
        run = simulate(build(f"analytic:{level}", own, scenarios[place]))
        for name in require_items(names):
            values = np.concatenate([getattr(each, name)[..., lane] for each in chunks])
            size = np.nanmax(np.abs(run[name].values))
            np.testing.assert_allclose(values, run[name].values, rtol=0, atol=1e-9 * size)


def test_the_papers_arm_as_a_robot_runs_as_its_planar_model():
    """Other coordinates, other equations: over absolute angles, with the gears' own spins."""
    scenario = experiment("constant", joints=2)
    laws = switches(damping="contact", mesh_work="conservative")
    arm = build("analytic:physical", load_arm("paper-labelled"), scenario, laws)
    model = build("analytic:geared", load_robot(PLANETARY), scenario)
    planar, robot = arm.simulate(), simulate(model)
    for name in ("theta", "theta_dot", "x_sp", "x_pr", "F_sp", "F_pr", "kinetic_energy"):
        size = np.abs(planar[name].values).max()
        assert robot[name].values == pytest.approx(planar[name].values, abs=1e-9 * size)
    assert model.largest_stable_step() == pytest.approx(arm.largest_stable_step(), rel=1e-9)


def test_rates_and_accelerations_of_a_run_are_slopes():
    """By differences over 2 us, which teeth that swing with 1e5 rad/s leave 0.5 % of."""
    run = simulate(build("analytic:geared", ROBOTS["staged"](), experiment(step_s=1e-6)))
    for name in ("theta", "theta_dot", "x_mesh", "x_sp", "x_pr"):
        slope = run[name].differentiate("time").values[1:-1]
        rate = run["theta_ddot" if name == "theta_dot" else f"{name}_dot"].values[1:-1]
        size = np.nanmax(np.abs(rate))
        assert slope == pytest.approx(rate, abs=0.01 * size, nan_ok=True)


def test_a_step_is_stable_at_every_quarter_of_a_turn():
    """A controller that damps alone, on M in closed form: Runge-Kutta ends at 2.785 / rate."""
    damping = [300.0, 500.0]
    law = {"proportional_N_m_per_rad": 0.0, "derivative_N_m_s_per_rad": damping}
    drive = PdDrive(kind="pd", target_rad=0.0, **law)
    started = experiment(joints=2, start={"theta_rad": [0.3, 1.5]})
    scenario = started.model_copy(update={"drive": drive})
    rates = [
        np.linalg.eigvals(np.linalg.solve(two_link.mass_matrix((0.0, elbow)), np.diag(damping)))
        for elbow in np.pi / 2 * np.arange(4)
    ]
    step = build("analytic:armature", two_link.robot(), scenario).largest_stable_step()
    assert step == pytest.approx(2.7853 / np.max(rates), rel=5e-4)  # tried in thousandths


def test_a_precise_run_is_where_smaller_steps_lead():
    """The error of steps over edges of the backlash falls with the step at least."""
    robot = ROBOTS["unlike"]()
    model = build("analytic:geared", robot, experiment(duration_s=1e-3))
    exact = simulate(model, rtol=1e-11)["theta"].values[-1]
    errors = []
    for step in (1e-5, 1e-6):
        finer = experiment(duration_s=1e-3, step_s=step, record_every=round(1e-5 / step))
        run = simulate(build("analytic:geared", robot, finer))
        errors.append(np.abs(run["theta"].values[-1] - exact).max())
    assert errors[1] < errors[0] / 5
    assert errors[1] < 1e-9


def test_a_precise_run_of_rigid_gears_is_that_of_fine_steps():
    run = experiment(duration_s=2e-3, step_s=1e-5, record_every=50)
    model = build("analytic:coupled", ROBOTS["unlike"](), run)
    exact, stepped = (simulate(model, **more)["theta"].values for more in ({"rtol": 1e-11}, {}))
    assert np.ptp(exact[:, 0]) > 1e-6
    np.testing.assert_allclose(exact, stepped, rtol=0, atol=1e-10)


def test_runs_start_where_teeth_touch_or_where_they_are_asked_to():
    for mesh, expected in (("contact", 2e-5), ("centre", 0.0)):
        started = experiment(start={"mesh": mesh, "theta_rad": 0.4})
        run = simulate(build("analytic:geared", ROBOTS["unlike"](), started))
        assert run["x_mesh"].values[0, 1:3] == pytest.approx([expected] * 2)
        assert np.isnan(run["x_mesh"].values[:, [0, 3]]).all()
        assert run["theta"].values[0] == pytest.approx([0.4, 0.4, 0.4, -0.5 * 0.4 + 0.3])


def test_a_step_beyond_stability_is_refused_and_grows_without_bound():
    long = experiment("constant", joints=2, step_s=5e-3, duration_s=5.0, start={})
    model = build("analytic:geared", ROBOTS["all sprung"](), long)
    with pytest.raises(InputError, match="largest stable step of analytic:geared is"):
        simulate(model)
    with pytest.raises(Diverged):
        simulate(model, force=True)


def test_joints_beyond_their_ranges_are_named():
    own = load_robot("sliding")
    within = np.array([[joint.limits.lower for joint in own.joints]])
    assert not list_beyond_ranges(own, within)
    assert list_beyond_ranges(own, within - [0.0, 1e-3, 0.0]).endswith("enforces: slide")
    assert not list_beyond_ranges(load_arm("probe"), np.full((1, 2), 100.0))


def test_a_file_says_what_was_run(crosscheck, tmp_path):
    out = tmp_path / "run.nc"
    settings = ["--set", "robot.joints.tilt.mesh.backlash_m=7e-5", "--t-end", "0.001"]
    rest = ["--model", "analytic:geared", "--scenario", "pd", "--out", out]
    for _ in range(2):  # a file of its own is written over
        answer = crosscheck("simulate", "sliding", *rest, *settings)
        assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith(f"wrote {out}: 11 times; at the end swivel ")
    assert "slide 9.6986" in answer.out
    run = xr.load_dataset(out, engine="h5netcdf")
    assert dict(run.sizes) == {"time": 11, "joint": 3}
    assert json.loads(run.attrs["joints"]) == ["swivel", "slide", "tilt"]
    answer = crosscheck("simulate", "sliding", *rest[:-1], tmp_path / "run.csv", *settings)
    assert_one_line(answer, "--out", "run.csv", "must end with .nc")
    assert json.loads(run.attrs["kinds"]) == ["revolute", "prismatic", "revolute"]
    assert run["x_mesh"].values[0, 2] == 7e-5
    kept = RobotSource.model_validate_json(run.attrs["robot"])
    assert kept.build().meshes[0][1].backlash_m == 7e-5
    assert run.attrs["model"] == "analytic:geared"


@pytest.mark.parametrize(
    ("level", "robot"),
    [*((level, "staged") for level in LEVELS), ("geared", "unlike")],  # of a ratio below 0
)
def test_a_robot_in_an_experiment_is_asked_as_an_arm_is(level, robot):
    """M a + bias = f at one state, by the drive of the scenario; engines agree on all four."""
    models = [
        build(f"{engine}:{level}", ROBOTS[robot](), experiment("sinusoid"))
        for engine in chains.ENGINES
    ]
    q, v = models[0].start()
    assert len(models[0].coordinates) == q.size
    q[3:] += 1e-5
    at = 1e-3, q, v
    answers = [
        (m.mass_matrix(q), m.bias(q, v), m.generalized_force(*at), m.acceleration(*at))
        for m in models
    ]
    torques = 5.0 * np.sin(1e-3 * np.array([50.0, 70.0, 90.0]))  # of the drive; at first none
    change = answers[0][2] - models[0].generalized_force(0.0, q, v)
    assert change[:3] == pytest.approx(torques, rel=1e-6)
    pd = build(models[0].name, ROBOTS[robot](), experiment("pd")).generalized_force(1e-3, q, v)
    target, stiff, damped = (np.array(each) for each in DRIVES["pd"].values())
    held = stiff * (target - q[:3]) - damped * v[:3]
    assert (pd - answers[0][2])[:3] + torques == pytest.approx(held, rel=1e-6)
    twice = models[0].bias(q, 2 * v)  # a force of rates is of their squares
    assert twice == pytest.approx(4 * answers[0][1], abs=1e-9 * np.abs(twice).max())
    for mass, bias, force, a in answers:
        assert mass @ a + bias == pytest.approx(force, abs=1e-9 * np.abs(mass @ a).max())
        for value, expected in zip((mass, bias, force), answers[0], strict=False):
            assert value == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    for model, (*_, a) in zip(models, answers, strict=True):  # at many states, too
        at_both = model.acceleration(1e-3, np.array([q, q + 1e-6]), np.array([v, v]))
        assert at_both[0] == pytest.approx(a, rel=1e-9)
        assert at_both[1] == pytest.approx(model.acceleration(1e-3, q + 1e-6, v), rel=1e-9)
    title = f"Model {models[0].name} of tested, experiment swing\ncoordinates: "
    assert repr(models[0]) == title + ", ".join(models[0].coordinates)
    with pytest.raises(InputError, match="must be numbers of shape"):
        models[0].mass_matrix([0.0])
    with pytest.raises(InputError, match="switches: is for arms"):
        build(models[0].name, ROBOTS["staged"](), experiment("sinusoid"), switches())
