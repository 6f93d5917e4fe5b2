"""`crosscheck view`: gears that mesh and roll, a page of the run's own numbers, bad input."""

import base64
import json
import re
import webbrowser
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from matplotlib.path import Path as Outline

from crosscheck.analytic.paper.kinematics import mesh_displacements, stage_geometry
from crosscheck.cli.view import view_page
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import load_scenario
from crosscheck.models.trajectory import build_trajectory, encode_netcdf
from crosscheck.output import write_files
from crosscheck.view.gears import TEETH_BESIDE, gear_angles, gear_assembly, make_close_up, outline
from crosscheck.view.mesh_geometry import SIDES, Wheel, mesh_geometry
from crosscheck.view.trajectory_file import Run
from tests.arms import PAPER, arm_of, gear_stages
from tests.tool.test_bad_input import assert_one_line

JOINTS = gear_stages("paper-labelled", "probe", "three-unlike", "planets-apart")
TIMES = 7


def placed(wheel: Wheel, turn: float, centre: complex = 0j) -> np.ndarray:
    return centre + np.exp(1j * turn) * outline(wheel)


def overlaps(joint: Planetary, theta: float, off: float = 0.0) -> int:
    """Corners of planets' teeth inside of the sun's, or outside of the ring's opening.

    off: pitches by which every planet is turned too far.
    """
    zero = np.zeros((1, joint.planet_count))
    sun_angles, planet_angles = gear_angles(joint, np.array([theta]), zero, zero)
    stand = gear_assembly(joint)
    sun, ring = (mesh_geometry(joint, side).wheel for side in SIDES)
    planet = mesh_geometry(joint, "sun").planet
    sun_at = placed(sun, sun_angles[0])
    opening = placed(ring, stand.ring)
    count = 0
    for n, where in enumerate(stand.planets):
        centre = abs(planet.centre) * np.exp(1j * (theta + where))
        turn = stand.spins[n] + planet_angles[0, n] + off * 2 * np.pi / planet.teeth
        teeth = placed(planet, turn, centre)
        corners = np.stack([teeth.real, teeth.imag], axis=1)
        count += int(inside(sun_at, corners).sum() + (~inside(opening, corners)).sum())
    return count


def inside(outer: np.ndarray, corners: np.ndarray) -> np.ndarray:
    found: np.ndarray = Outline(np.stack([outer.real, outer.imag], axis=1)).contains_points(corners)
    return found


@pytest.mark.parametrize("joint", JOINTS)
def test_teeth_meet_gaps_wherever_the_carrier_is(joint):
    assert [overlaps(joint, theta) for theta in (0.0, 0.4, -1.7, 3.0)] == [0, 0, 0, 0]
    assert overlaps(joint, 0.4, off=0.5) > 0  # else this could not fail


def test_gear_angles_turn_eqs_2_and_3_around():
    joint, rng = JOINTS[0], np.random.default_rng(5)
    carrier, x = rng.normal(size=3), 1e-4 * rng.normal(size=(2, 3, 1))
    (sun, planets), radii = gear_angles(joint, carrier, *x), stage_geometry(joint)
    back = mesh_displacements(sun, -planets[:, 0], carrier, radii.r_s, radii.r_p, radii.r_cp)
    assert np.allclose(back, x[:, :, 0], rtol=0, atol=1e-14)  # arcs of a metre, in double


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("joint", JOINTS[:2])
def test_the_gap_closes_where_x_is_half_the_backlash(joint, side):
    """Carrying flanks at the pitch point touch at x = b, and part by factor (b - x) else."""
    near = make_close_up(joint, side, 0.0)
    b = (joint.sun_mesh if side == "sun" else joint.ring_mesh).planet_mesh(0).backlash_m
    geometry = mesh_geometry(joint, side)
    middle = 1 + TEETH_BESIDE  # the rim stands first

    def gap(x: float) -> float:
        """Between the two flanks along the common tangent of the pitch circles, y."""
        spin = np.exp(1j * near.turn_per_m * x)
        turned = near.centre + spin * (near.planet[middle] - near.centre)
        return crossing(turned, near.centre, geometry.planet.pitch_radius, min) - crossing(
            near.wheel[middle],
            complex(-geometry.wheel.pitch_radius),
            geometry.wheel.pitch_radius,
            max,
        )

    along = np.cos(geometry.pressure_angle_rad)
    for x in (-b, 0.0, 0.5 * b, b):
        expected = near.factor * (b - x) / along
        assert gap(x) == pytest.approx(expected, abs=0.02 * joint.module_m)  # chords of flanks


def crossing(tooth: np.ndarray, centre: complex, radius: float, end: Any) -> float:
    """y of where a tooth's outline crosses the pitch circle: of the lower or the upper flank."""
    away = np.abs(tooth - centre) - radius
    found = []
    for n in np.flatnonzero(np.sign(away) != np.sign(np.roll(away, -1))):
        one, other = tooth[n], np.roll(tooth, -1)[n]
        share = away[n] / (away[n] - np.roll(away, -1)[n])
        found.append(float((one + share * (other - one)).imag))
    return float(end(found))


def a_run(arm: Any = PAPER, **more: Any) -> Any:
    joints = len(arm.joints)
    time = 1e-3 * np.arange(TIMES)
    theta = np.outer(time, 1 + np.arange(joints))
    return build_trajectory("mine", arm, load_scenario("pd"), switches(), time, theta=theta, **more)


def of_meshes(value: float) -> dict[str, np.ndarray]:
    names = ("x_sp", "x_pr", "F_sp", "F_pr")
    return {name: np.full((TIMES, 2, 3), value) for name in names}


def scene_of(page: str) -> dict[str, Any]:
    (text,) = re.findall(r'id="scene-data">(.*?)</script>', page, flags=re.S)
    scene: dict[str, Any] = json.loads(text)
    return scene


def test_the_page_holds_the_runs_numbers(tmp_path, crosscheck, monkeypatch):
    file = tmp_path / "run.nc"
    run = a_run(**of_meshes(3e-5))
    write_files({file: encode_netcdf(run)})
    assert crosscheck("view", file).code == 0
    page = (tmp_path / "run.html").read_text(encoding="utf-8")
    joint = scene_of(page)["joints"][1]
    theta = np.frombuffer(base64.b64decode(joint["theta"]), "<f4")
    assert np.array_equal(theta, run["theta"].values[:, 1].astype("f4"))
    assert joint["meshes"]["sun"]["half_clearance_m"] == PAPER.joints[1].sun_mesh.backlash_m
    assert not re.search(r"<(script|link|iframe|img)[^>]+(src|href)=", page)
    shown = []
    monkeypatch.setattr(webbrowser, "open", shown.append)
    assert crosscheck("view", file, "--open").code == 0  # its own page is replaced
    assert shown == [file.with_suffix(".html").resolve().as_uri()]


@pytest.mark.parametrize("arm", [arm_of(1), arm_of(7, direct=(2,))], ids=lambda arm: arm.name)
def test_rigid_runs_and_direct_joints_are_shown(arm):
    run = a_run(arm)
    page = view_page(Run("<b>&", arm, run["time"].values, {"theta": run["theta"].values}))
    kinds = [joint["kind"] for joint in scene_of(page)["joints"]]
    assert kinds == [joint.kind for joint in arm.joints]
    assert "<b>" not in page
    assert "they roll without clearance" in page


def damaged(file: Path, kind: str) -> None:
    """A run's file that is none."""
    content = encode_netcdf(a_run(**of_meshes(0.0)))
    if kind in ("empty", "truncated", "no HDF5"):
        half = content[: len(content) // 2]
        file.write_bytes({"empty": b"", "truncated": half, "no HDF5": b"time,theta\n0,1\n"}[kind])
        return
    file.write_bytes(content)
    with h5py.File(file, "r+") as run:
        if kind == "older":
            run.attrs["schema_version"] = 0
        elif kind == "another arm":
            run.attrs["arm"] = '{"name": "mine"}'
        elif kind == "not finite":
            run["theta"][3, 0] = np.nan
        elif kind == "no angles":
            del run["theta"]


SAID = {
    "empty": "is not a trajectory; crosscheck simulate writes one",
    "truncated": "is not a trajectory",
    "no HDF5": "is not a trajectory; crosscheck simulate writes one",
    "older": "schema_version 0; 1 is read",
    "another arm": "its arm cannot be used",
    "not finite": "theta is not finite",
    "no angles": "has no theta",
}


@pytest.mark.parametrize("kind", SAID)
def test_another_file_is_refused_in_one_line(tmp_path, crosscheck, kind):
    file = tmp_path / "run.nc"
    damaged(file, kind)
    assert_one_line(crosscheck("view", file), str(file), SAID[kind])
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


def test_a_page_that_cannot_be_written_is_reported(tmp_path, crosscheck):
    file, mine = tmp_path / "run.nc", tmp_path / "run.html"
    write_files({file: encode_netcdf(a_run())})
    mine.write_text("mine", encoding="utf-8")
    for out in (file, tmp_path, file / "page.html", mine):
        assert_one_line(crosscheck("view", file, "--out", out), str(tmp_path))
    assert mine.read_text(encoding="utf-8") == "mine"
