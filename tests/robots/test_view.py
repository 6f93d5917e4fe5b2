"""The page of a robot's run: its numbers put the tip where the engine has it; files as found."""

import base64
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crosscheck.api import simulate
from crosscheck.cli.view import view_page
from crosscheck.models.errors import InputError
from crosscheck.models.mechanism import select_robot
from crosscheck.models.robot.file import load_robot
from crosscheck.models.trajectory import encode_netcdf
from crosscheck.registry import build, build_robot_model
from crosscheck.view import scene as scenes
from crosscheck.view.rods import find_rod_ends, find_upward
from crosscheck.view.scene import build_scene
from crosscheck.view.trajectory_file import Run, TrajectoryFile

SHORT = ["scenario.duration_s=0.001", "scenario.start.theta_rad=0.4"]


def read(path: Path) -> Any:
    """The run of a file, in this process."""
    with h5py.File(path) as file:
        return TrajectoryFile(path, file).read_run()


@pytest.fixture(params=["sliding", "six-joint"])
def written(request, tmp_path) -> tuple[Path, Any]:
    """A file of a run, and its robot."""
    own, (scenario,), *_ = select_robot(request.param, ["constant-torque"], SHORT)
    path = tmp_path / "run.nc"
    path.write_bytes(encode_netcdf(simulate(build("analytic:coupled", own, scenario))))
    return path, own


def numbers(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype="<f4").astype(float)


def test_nested_frames_lead_to_the_tip(written):
    """As the script nests them: place of the joint, then turn or slide, then the end of a rod."""
    path, own = written
    run = read(path)
    scene, poses = build_scene(run), []
    for joint in scene["joints"]:
        under, at = (np.eye(3), np.zeros(3)) if joint["parent"] < 0 else poses[joint["parent"]]
        at, under = at + under @ joint["position"], under @ np.array(joint["rotation"])
        value, axis = numbers(joint["theta"])[-1], np.array(joint["axis"])
        if joint["kind"] == "prismatic":
            at = at + value * under @ axis
        else:
            under = under @ Rotation.from_rotvec(value * axis).as_matrix()
        poses.append((under, at))
    assert scene["reach"] >= max(np.linalg.norm(place) for _, place in poses)
    rotation, at = poses[-1]
    ends = scene["joints"][-1]["ends"] or [[0.0, 0.0, 0.0]]
    tip = at + rotation @ ends[-1]
    model = build_robot_model("analytic", own, "links")
    free = list(own.coordinates)
    expected = model.tip(run.signals["theta"][-1:, free])[0]
    assert tip == pytest.approx(expected, abs=1e-6)  # of float32 numbers


def test_page_stands_alone(written):
    page = view_page(read(written[0]))
    assert "Run of " in page
    assert '"ground"' in page
    assert '"up": [0.0, 0.0, 1.0]' in page  # these stand under gravity (0, 0, -9.81)
    assert "http://" not in page.replace("http://www.w3.org", "")


@pytest.mark.parametrize(
    ("attribute", "value", "said"),
    [
        ("robot", "{}", "its robot cannot be used: file"),
        ("robot", 3, "has no robot"),
        ("schema_version", 9, "schema_version 9"),
    ],
)
def test_a_changed_file_is_one_line(written, attribute, value, said):
    path, _ = written
    with h5py.File(path, "a") as file:
        file.attrs[attribute] = value
    with pytest.raises(InputError, match=said):
        read(path)


def test_every_few_records_of_a_long_run_are_shown(monkeypatch):
    """Of 7 records at most 3 frames: every third; the reach is that of rods and slides."""
    monkeypatch.setattr(scenes, "MOST_FRAMES", 3)
    robot = load_robot("sliding")
    time = 0.5 + 0.01 * np.arange(7)
    theta = np.outer(np.arange(7.0), [0.1, -0.02, 0.3])
    scene = build_scene(Run("mine", robot, time, {"theta": theta}))
    assert (scene["name"], scene["model"]) == ("sliding", "mine")
    assert (scene["frames"], scene["every"], scene["start_s"]) == (3, 3, 0.5)
    assert scene["step_s"] == pytest.approx(0.03)
    shown = [numbers(joint["theta"]) for joint in scene["joints"]]
    assert np.transpose(shown) == pytest.approx(theta[::3], rel=1e-6)
    assert scene["described"] == f"The whole robot: 3 joints, {len(robot.rotors)} rotors"
    places = [robot.joints[n].placement.position for n in range(3)]
    ends = find_rod_ends(robot)
    rods = {joint.parent: [] for joint in robot.joints}
    for joint, place in zip(robot.joints, places, strict=True):
        rods[joint.parent].append(np.linalg.norm(place))
    rods.setdefault(robot.frames[robot.tip].body, []).append(
        np.linalg.norm(robot.frames[robot.tip].placement.position)
    )
    assert {n: len(each) for n, each in ends.items() if each} == {
        n: len(each) for n, each in rods.items()
    }
    slid = 6 * 0.02  # the second joint, at the last frame
    assert scene["reach"] == pytest.approx(sum(map(max, rods.values())) + slid)
    assert (scene["payload"], scene["teeth"]) == (False, True)


@pytest.mark.parametrize(
    ("gravity", "upward"), [((0, 3.0, -4.0), (0, -0.6, 0.8)), ((0, 0, 0), (0, 0, 1))]
)
def test_upward_is_against_gravity(gravity, upward):
    robot = replace(load_robot("sliding"), gravity=np.array(gravity, dtype=float))
    assert find_upward(robot) == pytest.approx(upward)
