"""The page's plots and scheme: they hold the run's and the file's own numbers, no peak is lost."""

import base64
import inspect
import re
from collections.abc import Callable
from functools import partial

import numpy as np
import pinocchio
import pytest
import xarray as xr
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.models.robot.file import load_robot
from crosscheck.models.trajectory import build_trajectory
from crosscheck.registry import RIGID_LEVELS, model_names
from crosscheck.report.plots import figures, scheme
from crosscheck.report.plots.charts import Pictures, draw_pictures
from crosscheck.report.plots.scheme import draw_arm, draw_robot
from crosscheck.report.plots.signals import RecordStretch, Signals, collect_signals, make_stretch
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.tasks import RunKey
from tests.arms import PAPER

TIMES, STEP_S = 4000, 1e-4
PEAK, PEAK_AT = 731.25, 1234  # of a single record; exact in float32
TINY = 3e-13  # a difference that float32 would lose beside the force itself
REFERENCE, OTHER, LEVEL = "analytic:physical", "exudyn:tree", "pinocchio:coupled"


def run(model: str, force: np.ndarray) -> xr.Dataset:
    time = STEP_S * np.arange(TIMES)
    angles = np.stack([np.sin(3 * time), np.cos(2 * time)], axis=1)
    signals = {"theta": angles, "F_sp": force}
    return build_trajectory(model, PAPER, load_scenario("pd"), switches(), time, **signals)


@pytest.fixture
def runs() -> dict[str, dict[str, xr.Dataset]]:
    """One sharp peak; contact lost at 0.2 s and found on the other side at 0.21 s."""
    force = np.full((TIMES, 2, 1), 10.0)
    force[PEAK_AT, 0, 0] = PEAK
    force[2000:2100], force[2100:] = 0.0, -10.0
    return {"pd": {REFERENCE: run(REFERENCE, force), OTHER: run(OTHER, force + TINY)}}


def numbers(level: RecordStretch, name: str) -> np.ndarray:
    found = np.frombuffer(base64.b64decode(level.data[name]), dtype="<f4")
    return found.reshape(level.count, 2) if level.binned else found


def sizes(found: list[Signals]) -> int:
    """Numbers of all lines over the whole runs."""
    stretches = [stretch for each in found for stretch in each.whole.values()]
    return sum(numbers(one, name).size for one in stretches for name in one.data)


def test_rigid_levels_are_drawn_where_they_have_the_signal(runs):
    rigid = run(LEVEL, np.zeros((TIMES, 2, 1))).drop_vars("F_sp")
    (found,) = collect_signals(REFERENCE, {"pd": runs["pd"] | {LEVEL: rigid}}, 30_000)
    assert found.rigid == (LEVEL,)
    models = {q: {line.model for line in found.lines if line.quantity == q} for q in found.whole}
    assert models == {"theta": {REFERENCE, OTHER, LEVEL}, "F_sp": {REFERENCE, OTHER}}
    assert found.whole["theta"].binned  # what has the most lines gives way first
    window = found.windows[0].full_rate["theta"]
    assert numbers(window, f"theta/1/{REFERENCE}").size == window.count


@pytest.mark.parametrize("most", [20_000, 3_000, 200])
def test_bins_keep_every_extreme_and_windows_every_record(runs, most):
    (found,) = collect_signals(REFERENCE, runs, most)
    name, force = f"F_sp/1/{REFERENCE}", runs["pd"][REFERENCE]["F_sp"].values[:, 0, 0]
    whole = found.whole["F_sp"]
    assert whole.binned
    assert sizes([found]) <= 1.1 * most
    bins = numbers(whole, name)
    width = round(whole.step_s / STEP_S)
    assert tuple(bins[PEAK_AT // width]) == (min(10.0, PEAK), PEAK)
    assert (bins.min(), bins.max()) == (force.min(), force.max())
    (window,) = (each for each in found.windows if each.title.startswith("largest F_sp"))
    assert window.begin_s < PEAK_AT * STEP_S < window.end_s
    assert numbers(window.full_rate["F_sp"], name).max() == PEAK
    assert window.full_rate["F_sp"].step_s == pytest.approx(STEP_S)


def when(found: Signals, title: str) -> float:
    (window,) = (each for each in found.windows if each.title.startswith(title))
    return (window.begin_s + window.end_s) / 2


def test_of_several_joints_the_window_is_of_the_one_that_loses_contact_first(runs):
    force = runs["pd"][REFERENCE]["F_sp"].values
    force[1500:2000, 1] = 0.0  # of joint 2, half a tenth of a second before joint 1
    (found,) = collect_signals(REFERENCE, runs)
    assert when(found, "contact lost, joint 2") == pytest.approx(0.15, abs=STEP_S)
    force[:, 1] = force[:9] = 0.0  # no contact of joint 2, and none at first
    (found,) = collect_signals(REFERENCE, runs)
    assert when(found, "contact on the other side") == pytest.approx(0.21, abs=STEP_S)


def test_the_largest_force_may_be_a_negative_one(runs):
    turned = {name: each.assign(F_sp=-each["F_sp"]) for name, each in runs["pd"].items()}
    (found,) = collect_signals(REFERENCE, {"pd": turned})
    assert when(found, "largest F_sp") == pytest.approx(PEAK_AT * STEP_S, abs=STEP_S)


def test_a_page_is_shared_among_experiments(runs):
    many = {f"e{number}": runs["pd"] for number in range(5)}
    found = collect_signals(REFERENCE, many, 20_000)
    assert sizes(found) <= 1.1 * 20_000
    assert [s.experiment for s in found] == list(many)


@pytest.mark.parametrize("name", ["puma560", "six-joint"])
def test_a_robots_joints_stand_where_pinocchios_reader_has_them(name):
    """The picture is a plane view of the frames at zero: an affine map with orthogonal rows."""
    robot = load_robot(name)
    svg = draw_robot(robot)
    circles = re.findall(r'<circle class="(motor|slide)" cx="(\S+)" cy="(\S+)"', svg)
    pixels = np.array([[float(x), float(y)] for _, x, y in circles])
    model = pinocchio.buildModelFromXML(robot.urdf)
    data = model.createData()
    pinocchio.forwardKinematics(model, data, pinocchio.neutral(model))
    order = [model.getJointId(joint.name) for joint in robot.joints]
    places = np.array([data.oMi[number].translation for number in order])
    terms = np.column_stack([places - places.mean(axis=0), np.ones(len(places))])
    view, *_ = np.linalg.lstsq(terms, pixels, rcond=None)
    assert terms @ view == pytest.approx(pixels, abs=0.1)  # drawn to a tenth of a pixel
    right, down = view[:3].T
    assert right @ down == pytest.approx(0, abs=0.02 * (right @ right))
    assert np.linalg.norm(right) == pytest.approx(np.linalg.norm(down), rel=0.01)
    assert down[2] < 0  # gravity points down
    labels = re.findall(r"<text[^>]*>(.*?)<", svg)
    assert labels == [joint.name for joint in robot.joints]
    for x, y in re.findall(r'<text x="(\S+)" y="(\S+)"', svg):
        letter = np.array([float(x) + 4.5, float(y) - 5])
        assert np.linalg.norm(pixels - letter, axis=1).min() > 8  # its circle has a radius of 6


def scale_gears(factor: float) -> Arm:
    """The paper's arm with gears of another size, whose links are as they were."""
    arm = load_arm("paper-labelled")
    joints = [j.model_copy(update={"module_m": factor * j.module_m}) for j in arm.joints]
    return arm.model_copy(update={"joints": tuple(joints)})


SCHEMES: dict[str, Callable[[], str]] = {
    **{name: partial(draw_arm, load_arm(name)) for name in ("direct-between", "three-unlike")},
    "rings as long as ten links": partial(draw_arm, scale_gears(100.0)),
    "rings of a ten thousandth": partial(draw_arm, scale_gears(1e-3)),
    **{name: partial(draw_robot, load_robot(name)) for name in ("puma560", "six-joint")},
}


@pytest.mark.parametrize("name", SCHEMES)
def test_a_scheme_is_drawn(name: str, snapshot: SnapshotAssertion):
    """To a tenth of a pixel, an element a line."""
    assert SCHEMES[name]().replace("><", ">\n<") == snapshot


@pytest.mark.parametrize(
    ("upward", "across"), [((0, 0, 1), (1, 0, 0)), ((-1, 0, 0), (0, 1, 0)), ((0, 1, 0), (1, 0, 0))]
)
def test_a_robot_is_seen_from_the_side_and_a_little_above(upward, across):
    """By 0.6 rad about upward from the axis across, and 0.35 rad from above."""
    upward, across = np.array(upward, float), np.array(across, float)
    right, up = scheme._face_viewer(upward)
    beside = np.cross(upward, across)
    assert right == pytest.approx(np.cos(0.6) * across + np.sin(0.6) * beside, abs=1e-12)
    assert up @ upward == pytest.approx(np.cos(0.35))
    viewer = np.cross(right, up)  # the direction from which all is seen
    assert viewer @ upward == pytest.approx(np.sin(0.35))


def test_bins_and_times_of_a_stretch_are_those_of_its_records():
    time = 0.5 + 0.25 * np.arange(7)
    values = np.array([3.0, -1.0, 4.0, 1.0, -5.0, 9.0, 2.0])
    whole = make_stretch(time, {"a": values}, 1)
    assert (whole.start_s, whole.step_s, whole.count, whole.binned) == (0.5, 0.25, 7, False)
    binned = make_stretch(time, {"a": values}, 3)
    assert (binned.start_s, binned.step_s, binned.count, binned.binned) == (0.5, 0.75, 3, True)
    assert numbers(binned, "a").tolist() == [[-1.0, 4.0], [-5.0, 9.0], [2.0, 2.0]]
    assert make_stretch(time[:2], {"a": values[:2]}, 1).step_s == 0.25
    single = make_stretch(time[:1], {"a": values[:1]}, 1)
    assert (single.step_s, single.count) == (0.0, 1)


def test_room_is_shared_and_what_the_small_ones_leave_goes_to_the_large_ones(runs):
    """Both signals have 16,000 numbers; theta, the first, has no more than half the room."""
    (found,) = collect_signals(REFERENCE, runs, 32_000)
    assert [found.whole[name].binned for name in ("theta", "F_sp")] == [False, False]
    (found,) = collect_signals(REFERENCE, runs, 31_999)
    assert [found.whole[name].binned for name in ("theta", "F_sp")] == [True, False]
    (found,) = collect_signals(REFERENCE, runs, 12_000)
    widths = [round(found.whole[name].step_s / STEP_S) for name in ("theta", "F_sp")]
    assert widths == [6, 5]  # 16,000 x 2 / 6,000; then / 6,667


def run_for(model: str, seconds: float) -> xr.Dataset:
    time = np.linspace(0, seconds, 11)
    theta = ("time", "joint"), np.outer(time, [1.0, 2.0])
    return xr.Dataset({"theta": theta}, {"time": time, "joint": [1, 2]}, {"model": model})


def test_pictures_are_of_the_experiments_that_both_engines_ran(monkeypatch):
    """The longest of those with rigid levels is the still one; without any, the longest of all."""
    drawn = []

    def draw_levels(geared: xr.Dataset, rigid: dict[str, xr.Dataset]) -> str:
        return f"{geared.attrs['model']} beside {', '.join(rigid)}"

    def draw_pair(*pair: xr.Dataset) -> str:
        drawn.append([run.attrs["model"] for run in pair])
        return f"{float(pair[0]['time'][-1]):g} s"

    monkeypatch.setattr("crosscheck.report.plots.charts.draw_level_deviations", draw_levels)
    monkeypatch.setattr("crosscheck.report.plots.charts.draw_run_comparison", draw_pair)
    rigid = [f"pinocchio:{level}" for level in RIGID_LEVELS]
    partly = rigid[1:3]
    experiments = {
        "alone": (9.0, [REFERENCE, *rigid]),
        "b-long": (3.0, [REFERENCE, OTHER, *partly]),
        "c-short": (1.0, [REFERENCE, OTHER, *rigid, *model_names("form")]),
        "d-bare": (5.0, [REFERENCE, OTHER]),
        "e-last": (2.0, [OTHER]),
    }
    runs: dict[RunKey, xr.Dataset | Failure] = {
        RunKey(name, model): run_for(model, seconds)
        for name, (seconds, models) in experiments.items()
        for model in models
    }
    runs[RunKey("d-bare", rigid[0])] = Failure("Died", "in vain")
    pictures = draw_pictures(runs)
    assert draw_pictures(dict(reversed(runs.items()))) == pictures
    assert drawn.pop() == [REFERENCE, OTHER]
    assert pictures.levels == {
        "b-long": f"{REFERENCE} beside {', '.join(RIGID_LEVELS[1:3])}",
        "c-short": f"{REFERENCE} beside {', '.join(RIGID_LEVELS)}",
    }
    assert (pictures.still, pictures.still_of, drawn) == ("3 s", "b-long", [[REFERENCE, OTHER]])
    shown = {each.experiment: (each.reference, each.others) for each in pictures.signals}
    assert shown == {
        "b-long": (REFERENCE, (OTHER, *partly)),
        "c-short": (REFERENCE, (OTHER, model_names("form")[-1], *rigid)),
    }
    bare = draw_pictures(
        {
            RunKey(name, model): run_for(model, seconds)
            for name, (seconds, _) in experiments.items()
            for model in (REFERENCE, OTHER)
        }
    )
    assert bare.still_of == "alone"
    assert [each.experiment for each in bare.signals] == list(experiments)
    assert draw_pictures({}) == Pictures({})


def test_windows_hold_what_is_worth_a_look_and_end_with_the_run(runs):
    time = runs["pd"][REFERENCE]["time"].values
    off = runs["pd"][OTHER]["F_sp"].values.copy()
    off[3990, 0] -= 5.0  # the largest difference, near the end
    other = runs["pd"][OTHER].assign(F_sp=(runs["pd"][OTHER]["F_sp"].dims, off))
    (found,) = collect_signals(REFERENCE, {"pd": {REFERENCE: runs["pd"][REFERENCE], OTHER: other}})
    spans = {window.title: (window.begin_s, window.end_s) for window in found.windows}
    half = 2e-3
    assert spans == {
        "largest F_sp, joint 1": pytest.approx((0.1234 - half, 0.1234 + half)),
        "contact lost, joint 1": pytest.approx((0.1999 - half, 0.1999 + half)),
        "contact on the other side, joint 1": pytest.approx((0.21 - half, 0.21 + half)),
        f"largest difference of {OTHER}, joint 1": pytest.approx((0.399 - half, time[-1])),
    }


def test_axes_leave_each_other_room_for_their_labels(monkeypatch):
    monkeypatch.setattr(figures, "_place_axes", inspect.unwrap(figures._place_axes))
    figure, axes = figures.make_figure(2)
    for each in axes.flat:
        each.set_ylabel("two lines\nof a label")
        each.set_yticks([0.0, 1.0], ["far to the left of the axis", "1"])
    assert figures.to_svg(figure).startswith("<svg")
    boxes = [each.get_tightbbox() for each in axes.flat]
    assert not any(one.overlaps(other) for n, one in enumerate(boxes) for other in boxes[:n])
