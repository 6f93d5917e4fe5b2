"""Planets that cannot be as they are told to be: one line that says where, and exit code 2."""

from __future__ import annotations

from crosscheck.models.files import HERE
from tests.tool.test_bad_input import assert_one_line

APART = (HERE / "arms" / "planets-apart.toml").read_text(encoding="utf-8")


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
