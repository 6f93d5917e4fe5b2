"""What every command has in common: help, version, speed of start, exit codes."""

from __future__ import annotations

import subprocess
import sys

import pytest

from crosscheck import __version__, listing
from crosscheck.registry import MODELS
from models import exudyn_tree
from models.loading import builtin_arms, builtin_scenarios
from tests.processes import HEAVY, modules_loaded_by


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["simulate", "--help"]])
def test_help_loads_no_engine(arguments):
    loaded = modules_loaded_by(*arguments)
    assert "crosscheck.cli" in loaded
    assert HEAVY.isdisjoint(loaded)


def test_package_runs_as_a_module():
    command = [sys.executable, "-m", "crosscheck", "--version"]
    answer = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert answer.stdout == f"crosscheck {__version__}\n"


def test_version_is_printed(crosscheck):
    assert crosscheck("--version") == (0, f"crosscheck {__version__}\n", "")


@pytest.mark.parametrize("command", ["run", "simulate", "list", "init", "show"])
def test_help_of_every_command(crosscheck, command):
    answer = crosscheck(command, "--help")
    assert (answer.code, answer.err) == (0, "")
    assert "Usage:" in answer.out


def test_list_names_all_arms_models_and_scenarios(crosscheck):
    answer = crosscheck("list")
    assert (answer.code, answer.err) == (0, "")
    words = answer.out.split()
    assert set(words) >= {*builtin_arms(), *MODELS, *builtin_scenarios()}


def test_show_derives_the_papers_numbers(crosscheck):
    answer = crosscheck("show", "paper-labelled")
    assert (answer.code, answer.err) == (0, "")
    # Base radii [m], ratio and total dampings [N s/m] of the paper's arm.
    for number in ("0.0368240", "0.0490987", "0.0859228", "4.66666", "1224.74", "2437.21"):
        assert number in answer.out
    for unit in ("kg m^2", "N s/m", "N/m", "Hz", "rad", "deg"):
        assert f" {unit}" in answer.out


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

    monkeypatch.setattr(exudyn_tree, "_entry", lambda *_: interrupted)
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
