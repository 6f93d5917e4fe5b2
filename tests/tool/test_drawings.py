"""What the drawings of the meshes show is the arm's geometry, by the signs of Eqs. 2 and 3."""

import math
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from crosscheck.analytic.paper.kinematics import mesh_displacements, stage_geometry
from crosscheck.view.mesh_geometry import MeshGeometry, flank, mesh_geometry
from tests.arms import gear_stages
from tests.loops import require_items
from tools import animation, drawings
from tools.drawings import DOCS, SIDES, outline_teeth, push_direction, tangent_point, write_drawings

JOINTS = gear_stages("paper-labelled", "probe", "three-unlike")
CASES = [pytest.param(joint, side) for joint in JOINTS for side in SIDES]


def cross(a: complex, b: complex) -> float:
    return (np.conj(a) * b).imag


@pytest.mark.parametrize(("joint", "side"), CASES)
def test_line_of_action_touches_both_base_circles(joint, side):
    mesh, radii = mesh_geometry(joint, side), stage_geometry(joint)
    assert mesh.planet.base_radius == pytest.approx(radii.r_p, rel=1e-14)
    central = radii.r_s if side == "sun" else radii.r_cp + radii.r_p
    assert mesh.wheel.base_radius == pytest.approx(central, rel=1e-14)
    assert abs(push_direction(mesh)) == pytest.approx(1, rel=1e-14)
    for wheel in (mesh.wheel, mesh.planet):
        touching = tangent_point(mesh, wheel)
        assert abs(touching - wheel.centre) == pytest.approx(wheel.base_radius, rel=1e-13)
        assert cross(push_direction(mesh), touching - mesh.pitch_point) == pytest.approx(
            0, abs=1e-15
        )


@pytest.mark.parametrize(("joint", "side"), CASES)
def test_pitch_circles_touch_at_the_pitch_point(joint, side):
    mesh = mesh_geometry(joint, side)
    assert mesh.planet.centre == pytest.approx(stage_geometry(joint).r_c, rel=1e-14)
    for wheel in (mesh.wheel, mesh.planet):
        distance = abs(mesh.pitch_point - wheel.centre)
        assert distance == pytest.approx(wheel.pitch_radius, rel=1e-13)
    tangent = math.degrees(abs(np.angle(push_direction(mesh) / 1j)))
    assert tangent == pytest.approx(joint.pressure_angle_deg, rel=1e-13)


def approach(mesh: MeshGeometry, sun: float, planet: float, carrier: float) -> float:
    """Rate at which the teeth at the pitch point close, from rates of the gears' angles."""
    lever = mesh.pitch_point - mesh.planet.centre
    wheel = 1j * sun * mesh.pitch_point if mesh.side == "sun" else 0j
    on_planet = 1j * carrier * mesh.planet.centre - 1j * planet * lever  # counted clockwise
    return (np.conj(push_direction(mesh)) * (wheel - on_planet)).real


@pytest.mark.parametrize(("joint", "side"), CASES)
def test_arrows_count_as_the_papers_displacements(joint, side):
    mesh, radii = mesh_geometry(joint, side), stage_geometry(joint)
    for rates in require_items(np.eye(3)):
        expected = mesh_displacements(*rates, radii.r_s, radii.r_p, radii.r_cp)
        assert approach(mesh, *rates) == pytest.approx(expected[SIDES.index(side)], abs=1e-14)


@pytest.mark.parametrize(("joint", "side"), CASES)
def test_flanks_meet_at_the_pitch_point_across_the_line_of_action(joint, side):
    mesh = mesh_geometry(joint, side)
    counter_clockwise = {mesh.wheel: True, mesh.planet: side == "sun"}
    for wheel, which in require_items(counter_clockwise.items()):
        at = float(np.angle(mesh.pitch_point - wheel.centre))
        points = wheel.centre + flank(wheel, at, which)
        place = int(np.argmin(abs(points - mesh.pitch_point)))
        along = points[place + 1] - points[place - 1]
        steepness = abs((np.conj(along / abs(along)) * push_direction(mesh)).real)
        assert abs(points[place] - mesh.pitch_point) < 0.25 * joint.module_m
        assert steepness < 0.06
        assert abs(cross(along / abs(along), push_direction(mesh))) > 0.99


@pytest.mark.parametrize(("joint", "side"), CASES)
def test_carrying_teeth_are_on_either_side_of_the_contact(joint, side):
    mesh = mesh_geometry(joint, side)
    for wheel, sign in ((mesh.wheel, -1), (mesh.planet, 1)):
        (outline,) = outline_teeth(mesh, wheel, 0)
        ahead = (np.conj(push_direction(mesh)) * (outline.mean() - mesh.pitch_point)).real
        assert sign * ahead > 0


def test_drawings_are_written_beside_the_equations(tmp_path, monkeypatch):
    monkeypatch.setattr(drawings, "DOCS", tmp_path)
    write_drawings()
    names = {f"{side}-mesh.svg" for side in SIDES}
    assert {path.name for path in tmp_path.iterdir()} == names
    for name in names:
        for folder in (tmp_path, DOCS):
            assert ElementTree.parse(folder / name).getroot().tag.endswith("svg")


def test_the_moving_picture_shows_contact_as_the_run_has_it():
    """A frame is of lost contact where the force is 0; the file in docs is small, and is SVG."""
    frames, mesh = animation.simulate_contact_loss()
    style = next(animation.draw_mesh(frames, mesh))
    lost = re.findall(r"opacity:(\d)", style.partition("@keyframes lose")[2].partition("@")[0])
    assert lost == [str(int(force == 0)) for force in mesh["force"][frames]]
    assert set(lost) == {"0", "1"}
    assert animation.OUT.stat().st_size < 100_000
    assert ElementTree.parse(animation.OUT).getroot().tag.endswith("svg")
