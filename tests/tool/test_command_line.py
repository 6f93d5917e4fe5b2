"""What every command has in common: help, version, speed of start, exit codes."""

import json
import os

import pytest

from crosscheck import __version__
from crosscheck.cli import listing
from crosscheck.models.exudyn.tree import loads as exudyn_tree_loads
from crosscheck.models.files import builtin_arms, builtin_robots, builtin_scenarios
from crosscheck.registry import MODELS
from tests.processes import ENGINES, HEAVY, command_line, modules_loaded_by, warm_command_line
from tests.tool.supplied import model_file


@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], ["simulate", "--help"], ["run", "--help"], ["list"]]
)
def test_help_and_lists_load_no_engine_and_no_numbers(arguments):
    loaded = modules_loaded_by(*arguments)
    assert "crosscheck.cli.app" in loaded
    assert HEAVY.isdisjoint(loaded)


@pytest.mark.parametrize("arm", ["paper-labelled", "three-unlike"])
def test_an_arm_is_shown_without_engines_and_files(arm):
    loaded = modules_loaded_by("show", arm)
    assert "crosscheck.cli.show" in loaded
    assert ENGINES.isdisjoint(loaded)


def test_a_list_reads_titles_without_the_schema():
    assert {"crosscheck.models.arm.arm", "crosscheck.models.experiment.scenario"}.isdisjoint(
        modules_loaded_by("list")
    )


def test_package_runs_as_a_module():
    answer = command_line("--version")
    assert (answer.returncode, answer.stdout) == (0, f"crosscheck {__version__}\n")


def test_version_is_printed(crosscheck):
    assert crosscheck("--version") == (0, f"crosscheck {__version__}\n", "")


@pytest.mark.parametrize("command", ["run", "simulate", "list", "init", "show"])
def test_help_of_every_command(crosscheck, command):
    answer = crosscheck(command, "--help")
    assert (answer.code, answer.err) == (0, "")
    assert "Usage:" in answer.out


def test_a_shell_completes_commands():
    words = {"COMP_WORDS": "crosscheck tr", "COMP_CWORD": "1"}
    asked = {**os.environ, **words, "_CROSSCHECK_COMPLETE": "complete_bash"}
    code = "from crosscheck.cli.app import main; import sys; sys.argv = ['crosscheck']; main()"
    answer = command_line(python=("-c", code), env=asked)
    assert (answer.returncode, answer.stdout.split()) == (0, ["trial"])


def test_json_alone_goes_to_the_output(tmp_path):
    model = model_file(tmp_path)
    answer = warm_command_line("trial", f"{model}:two_link", "--quick", "--json", "-")
    assert json.loads(answer.stdout)["wrong"] == []
    assert "16 of 16 checks agree" in answer.stderr


def test_list_names_all_that_other_commands_accept(crosscheck):
    answer = crosscheck("list")
    assert (answer.code, answer.err) == (0, "")
    words = answer.out.split()
    assert set(words) >= {*builtin_arms(), *builtin_robots(), *MODELS, *builtin_scenarios()}


def test_show_derives_the_papers_numbers(crosscheck):
    answer = crosscheck("show", "paper-labelled")
    assert (answer.code, answer.err) == (0, "")
    # Base radii [m], ratio and total dampings [N s/m] of the paper's arm.
    for number in ("0.0368240", "0.0490987", "0.0859228", "4.66666", "1224.74", "2437.21"):
        assert number in answer.out
    for unit in ("kg m^2", "N s/m", "N/m", "Hz", "rad", "deg"):
        assert f" {unit}" in answer.out


def test_show_knows_joints_without_gears_and_other_laws(crosscheck):
    answer = crosscheck("show", "direct-between")
    assert (answer.code, answer.err) == (0, "")
    for row in ("rotor_inertia_kg_m2", "reflected inertia of the rotor", "joint 3, ring mesh"):
        assert row in answer.out
    assert "table" in answer.out
    assert answer.out.count("mesh mode ") == 4
    # The ratio that the damping of the wrist's ring mesh comes to, and the controller's rate.
    assert "0.0532808" in answer.out
    assert "5.71759" in answer.out


def test_an_arm_that_swings_under_its_weight_has_no_mesh_modes(crosscheck, tmp_path):
    text = """
        schema_version = 2
        name = "hanging"
        payload_mass_kg = 2.0
        gravity_m_per_s2 = [9.81, 0.0]
        joints = [{ kind = "direct", motor_mass_kg = 2.0, rotor_inertia_kg_m2 = 0.01 }]
        links = [{ length_m = 0.5, com_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.1 }]
    """
    (tmp_path / "hanging.toml").write_text(text, encoding="utf-8")
    answer = crosscheck("show", str(tmp_path / "hanging.toml"))
    assert (answer.code, answer.err) == (0, "")
    assert "mesh mode" not in answer.out
    assert "15.696" in answer.out  # (3 x 0.2 + 2 x 0.5) x 9.81 N m


def test_interruption_is_exit_code_130(crosscheck, monkeypatch):
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(listing, "list_command", interrupted)
    assert crosscheck("list") == (130, "", "crosscheck: interrupted\n")


def test_interruption_that_an_engine_makes_up_is_its_own_failure(short, monkeypatch, tmp_path):
    """Ctrl-C is for the program to answer; a worker never sees it."""
    calls = []

    def interrupted(*numbers: object) -> None:
        calls.append(numbers)
        if len(calls) > 50:
            raise KeyboardInterrupt

    monkeypatch.setattr(exudyn_tree_loads, "_entry", lambda *_: interrupted)
    answer = short(model="exudyn:tree")
    assert answer.code == 3
    assert answer.err == "crosscheck: exudyn:tree: KeyboardInterrupt\n"
    assert list(tmp_path.iterdir()) == []


def test_internal_error_is_exit_code_3_with_its_traceback(crosscheck, monkeypatch):
    def broken() -> None:
        raise RuntimeError("a bug")

    monkeypatch.setattr(listing, "list_command", broken)
    answer = crosscheck("list")
    assert answer.code == 3
    assert "Traceback" in answer.err
    assert "RuntimeError: a bug" in answer.err
    assert "internal error" in answer.err.splitlines()[-1]
