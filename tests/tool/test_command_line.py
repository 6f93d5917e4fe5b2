"""What every command has in common: help, version, speed of start, exit codes."""

import errno
import json
import os
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest

from crosscheck import __version__
from crosscheck.cli import listing
from crosscheck.cli.app import build_commands
from crosscheck.cli.help import GROUPS
from crosscheck.cli.output import print_and_write
from crosscheck.cli.simulation import SimulationRequest
from crosscheck.cli.trial import TrialOptions
from crosscheck.models.errors import InputError, Unfinished
from tests.loops import require_items
from tests.processes import ENGINES, HEAVY, command_line, modules_loaded_by, warm_command_line
from tests.tool.supplied import model_file


@pytest.mark.parametrize(
    "line", ["--help", "--version", "simulate --help", "run --help", "list", "init {}/mine.toml"]
)
def test_help_lists_and_init_load_no_engine_and_no_numbers(line, tmp_path):
    loaded = modules_loaded_by(*line.format(tmp_path).split())
    assert "crosscheck.cli.app" in loaded
    assert HEAVY.isdisjoint(loaded)


@pytest.mark.parametrize("arm", ["paper-labelled", "three-unlike"])
def test_an_arm_is_shown_without_engines_and_files(arm):
    loaded = modules_loaded_by("show", arm)
    assert "crosscheck.cli.show" in loaded
    assert ENGINES.isdisjoint(loaded)


def test_states_are_asked_for_without_engines_and_symbols(tmp_path):
    loaded = modules_loaded_by("trial", "--ask", "--quick", "--out", tmp_path / "states")
    assert "crosscheck.trial.coordinates.build" in loaded
    assert (ENGINES - {"jinja2"}).isdisjoint(loaded)


def test_a_list_reads_titles_without_the_schema():
    assert {"crosscheck.models.arm.arm", "crosscheck.models.experiment.scenario"}.isdisjoint(
        modules_loaded_by("list")
    )


def test_package_runs_as_a_module():
    answer = command_line("--version")
    left = answer.returncode, answer.stdout, answer.stderr
    assert left == (0, f"crosscheck {__version__}\n", "")


def test_help_has_types_of_people_and_an_example_that_the_parser_takes(crosscheck):
    """Switches have no type; every command is in a group and has an example."""
    commands = build_commands().commands
    for name, command in require_items(commands.items()):
        answer = crosscheck(name, "-h")
        assert (answer.code, answer.err) == (0, "")
        assert not re.search("<[a-z]", answer.out)
        assert command.rich_help_panel in GROUPS
        program, *words = shlex.split(command.epilog.removeprefix("Example: "))
        assert (program, words[0]) == ("crosscheck", name)
        context = command.make_context(name, words[1:])
        assert not context.args or name in ("baseline", "cache")


@pytest.mark.parametrize("group", [(), ("baseline",), ("cache",)])
def test_a_group_without_a_command_is_its_help(crosscheck, group):
    answer = crosscheck(*group)
    assert (answer.code, answer.err) == (2, "")
    assert "--help" in answer.out


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


def test_a_terminal_of_unknown_width_is_no_terminal_of_no_width(crosscheck, monkeypatch):
    """Some shells say so by 0 columns, into which nothing fits."""
    monkeypatch.setenv("COLUMNS", "0")
    assert "paper-labelled" in crosscheck("list").out


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (OSError(errno.ENOSPC, "all full"), 2, "a file cannot be written: all full"),
        (OSError(errno.EDQUOT, "quota"), 2, "a file cannot be written: quota"),
        (OSError(errno.EMFILE, "many"), 2, "open files: many; raise the limit, or lower --jobs"),
        (InputError("file", "field", 3, "must be 2"), 2, "file: field = 3: must be 2"),
        (Unfinished("one: stopped"), 3, "one: stopped"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
def test_an_error_ends_with_its_line_and_its_code(crosscheck, monkeypatch, error, code, line):
    monkeypatch.setattr(listing, "list_command", raising(error))
    assert crosscheck("list") == (code, "", f"crosscheck: {line}\n")


def raising(error: BaseException) -> Callable[..., NoReturn]:
    def fail(*_: object) -> NoReturn:
        raise error

    return fail


def test_a_check_without_a_record_names_the_command_that_makes_it(
    crosscheck, tmp_path, monkeypatch
):
    model_file(tmp_path)
    monkeypatch.chdir(tmp_path)
    given = "paper-swapped --model mine.py:two_link --dir b --scenario pd --scenario back-and-forth"
    settings = ["--set", "arm.gravity_m_per_s2=[1,2]", "--set", "arm.payload_mass_kg=1"]
    answer = crosscheck("baseline", "check", *given.split(), *settings, "--quick")
    assert answer.code == 2
    settings[1] = f"'{settings[1]}'"
    assert answer.err.endswith(f"crosscheck baseline accept {given} {' '.join(settings)} --quick\n")


def trial_options(**given: object) -> TrialOptions:
    nothing = dict.fromkeys(("json_file", "junit", "out", "coordinates"))
    nothing |= dict.fromkeys(("quick", "ask", "run_code"), False)
    nothing |= {"names": ("m.py:f",), "seed": 0, "jobs": 1, "answers": (), "after": ()}
    return TrialOptions(**{**nothing, "scenarios": [], "settings": [], **given})


@pytest.mark.parametrize(
    ("given", "arm"),
    [
        ({}, "paper-labelled"),
        ({"names": ("m.py:f", "probe")}, "probe"),
        ({"names": ("probe",), "ask": True}, "probe"),
        ({"names": (), "ask": True}, "paper-labelled"),
        ({"names": ("probe",), "answers": (Path("a.csv"),)}, "probe"),
        ({"names": ("u.fmu", "probe"), "ask": True}, "probe"),
        ({"names": ("u.fmu",)}, "paper-labelled"),
    ],
)
def test_the_arm_of_a_trial_is_named_after_its_model(given, arm):
    assert trial_options(**given).arm == arm


def test_options_of_a_trial_are_reported_as_they_were_given():
    assert trial_options().format_shared_options() == "paper-labelled"
    given = {"names": ("my arm",), "ask": True, "settings": ["a=1"], "quick": True, "seed": 7}
    options = trial_options(**given, coordinates=Path("c.toml")).format_shared_options()
    assert options == "'my arm' --set a=1 --coordinates c.toml --quick --seed 7"
    assert trial_options(names=("a.fmu",)).fmu == Path("a.fmu")
    assert trial_options(names=("fmu.py:f",)).fmu is None


def test_what_was_written_is_named_after_the_lines(tmp_path, capsys):
    first, last = tmp_path / "a.txt", tmp_path / "b.txt"
    print_and_write(["one", "two"], (first, lambda: "A"), (None, lambda: "B"), (last, lambda: "C"))
    assert capsys.readouterr().out.splitlines() == ["one", "two", f"wrote {first}", f"wrote {last}"]
    assert (first.read_text(), last.read_text()) == ("A", "C")


def test_interruption_that_an_engine_makes_up_is_its_own_failure(short, monkeypatch, tmp_path):
    """Ctrl-C is for the program to answer; a worker never sees it."""
    monkeypatch.setattr(SimulationRequest, "perform", raising(KeyboardInterrupt()))
    answer = short(model="exudyn:tree")
    assert answer == (3, "", "crosscheck: exudyn:tree: KeyboardInterrupt\n")
    assert list(tmp_path.iterdir()) == []


def test_internal_error_is_exit_code_3_with_its_traceback(crosscheck, monkeypatch):
    monkeypatch.setattr(listing, "list_command", raising(RuntimeError("a bug")))
    answer = crosscheck("list")
    assert answer.code == 3
    assert "Traceback" in answer.err
    assert "RuntimeError: a bug" in answer.err
    assert "internal error" in answer.err.splitlines()[-1]
