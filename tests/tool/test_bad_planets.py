"""Planets that cannot be as they are told to be: one line that says where, and exit code 2."""

from __future__ import annotations

import pytest

from crosscheck.models.files import HERE
from tests.tool.test_bad_input import assert_one_line

APART = (HERE / "arms" / "planets-apart.toml").read_text(encoding="utf-8")
SUN = "arm.joints.0.sun_mesh"
BAD_SETTINGS = {
    "one planet short": (
        (f"{SUN}.backlash_m=[4e-5, 5e-5]",),
        ("joints[0].sun_mesh.backlash_m", "[4e-05, 5e-05]", "3, one for each planet; has 2"),
    ),
    "a law too many": (
        ("arm.joints.1.sun_mesh.damping_ratio=[0.1, 0.1, 0.1, 0.1, 0.1]",),
        ("joints[1].sun_mesh.damping_ratio", "4, one for each planet; has 5"),
    ),
    "out of range": (
        (f"{SUN}.static_error_m=[0.0, 0.0, 0.2]",),
        ("joints[0].sun_mesh.static_error_m[2]", "0.2", "-0.1 to 0.1 m"),
    ),
    "not a number": (
        (f'{SUN}.tooth_error_m=[5e-6, "much", 5e-6]',),
        ("joints[0].sun_mesh.tooth_error_m[1]", "'much'", "number"),
    ),
    "phases of other teeth": (
        (f"{SUN}.phase_rad=[0.0, 2.0944, 4.1888]",),
        ("joints[0].sun_mesh.phase_rad", "contradicts the teeth", "0, 4.189, 2.094 rad"),
    ),
    "a word that is no phase": (
        (f"{SUN}.phase_rad=from-tooth",),
        ("joints[0].sun_mesh.phase_rad", "'from-tooth'", "from-teeth"),
    ),
    "lumped though out of phase": (
        ("switches.planets=lumped",),
        ("joints[0].sun_mesh.", "alike for all planets", "planets = free"),
    ),
    "planets of a third kind": (
        ("switches.planets=single",),
        ("switches: planets", "'single'", "'lumped' or 'free'"),
    ),
    "a potential of time": (
        ("switches.mesh_work=conservative", "switches.phase=omega_t"),
        ("switches: mesh_work", "conservative", "phase = angle"),
    ),
    "a potential of Eq. 6": (
        ("switches.mesh_work=conservative", "switches.dead_zone=tanh"),
        ("switches: mesh_work", "conservative", "dead_zone = exact"),
    ),
    "a start of other planets": (
        ("scenario.start.planet_offset_m=[[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]",),
        ("start.planet_offset_m[1]", "4 values, one for each planet; has 3"),
    ),
    "a start of other joints": (
        ("scenario.start.planet_offset_m=[[0.0, 0.0, 0.0]]",),
        ("start.planet_offset_m", "2 values, has 1"),
    ),
}


@pytest.mark.parametrize("case", BAD_SETTINGS)
def test_bad_planets_are_named_with_field_and_value(short, tmp_path, case):
    settings, fragments = BAD_SETTINGS[case]
    flags = [part for setting in settings for part in ("--set", setting)]
    assert_one_line(short(*flags, arm="planets-apart"), *fragments)
    assert list(tmp_path.iterdir()) == []


def test_the_file_is_named(short, tmp_path):
    file = tmp_path / "arm.toml"
    file.write_text(APART.replace("[50e-6, 50e-6, 85e-6]", "[50e-6, 50e-6]"))
    assert_one_line(short(arm=file), str(file), "joints[0].ring_mesh.backlash_m", "has 2")
    assert list(tmp_path.iterdir()) == [file]


def test_lumped_planets_that_start_apart_are_refused(short, tmp_path):
    apart = "scenario.start.planet_offset_m=[[1e-6, 0.0, 0.0], [0.0, 0.0, 0.0]]"
    assert_one_line(short("--set", apart), "start.planet_offset_m[0]", "planets = free")
    assert list(tmp_path.iterdir()) == []


def test_a_cross_check_refuses_lumped_planets_that_differ(crosscheck, tmp_path):
    more = ("--quick", "--set", "switches.planets=lumped", "--json", tmp_path / "a.json")
    answer = crosscheck("validate", "planets-apart", *more)
    assert_one_line(answer, "planets-apart", "joints[0].sun_mesh.", "planets = free")
    assert list(tmp_path.iterdir()) == []


def test_the_papers_own_arm_may_have_free_planets(short):
    assert short("--set", "switches.planets=free").code == 0
    assert short("--set", "arm.joints.*.*_mesh.backlash_m=[5e-5, 4e-5, 5e-5]").code == 0
