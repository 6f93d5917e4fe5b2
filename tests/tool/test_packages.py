"""Whatever an installed package's command, model or robot engine does is one line, and no more."""

import os
import time
from typing import NoReturn

import pytest

from crosscheck import registry
from crosscheck.checks.robot_states import SIZE_WORDS, sample_states
from crosscheck.cli.listing import _format_model
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.robot.file import load_robot
from crosscheck.planning import robots
from tests.processes import warm_command_line
from tests.tool.packages import offer

pytestmark = pytest.mark.system

UNPRINTABLE = "class Odd(Exception):\n    def __str__(self): raise ValueError\n"


def command(work: str) -> str:
    return f"def it():\n    {work}"


COMMANDS = {
    "no function": ("it = 3", "must be a function, is int"),
    "a class": ("class it: pass", "must be a function, is type"),
    "unusable arguments": (
        "def it(x: int | str): pass",
        "is not a function that Typer takes: Asser",
    ),
    "raises at import": ("raise OSError('no')", "cannot be imported: OSError: no"),
    "cannot be printed": (f"{UNPRINTABLE}raise Odd", "cannot be imported: Odd"),
    "leaves at import": ("os._exit(0)", "entry point guest: its process ended with exit code 0"),
    "raises": (command("1 / 0"), "command guest: raised ZeroDivisionError: div"),
    "raises what cannot be printed": (f"{UNPRINTABLE}{command('raise Odd')}", "guest: raised Odd"),
    "exits": (command("sys.exit(0)"), "command guest: raised SystemExit: 0"),
    "leaves": (command("os._exit(0)"), "command guest: its process ended with exit code 0"),
    "interrupts": (command("raise KeyboardInterrupt"), "command guest: raised KeyboardInterrupt"),
    "escapes": (command("raise ValueError('\\x1b[31mred\\nx')"), r"ValueError: \x1b[31mred x"),
}


@pytest.mark.parametrize("case", COMMANDS)
def test_whatever_a_packages_command_does_is_one_line(tmp_path, case):
    text, said = COMMANDS[case]
    offer(tmp_path, text)
    answer = warm_command_line("guest", folder=tmp_path)
    assert (answer.returncode, answer.stdout) == (2, "")
    assert answer.stderr.startswith("crosscheck: package guest-engine")
    assert said in answer.stderr
    assert (answer.stderr.count("\n"), answer.stderr[:-1].isprintable()) == (1, True)


@pytest.mark.parametrize("code", [0, 1])
def test_a_packages_command_ends_as_it_says(tmp_path, code):
    offer(tmp_path, f"import typer\ndef it(count: int):\n    raise typer.Exit({code})")
    assert warm_command_line("guest", 3, folder=tmp_path).returncode == code
    wrong = warm_command_line("guest", "three", folder=tmp_path)
    assert (wrong.returncode, wrong.stderr.count("\n")) == (2, 1)


def test_a_title_has_no_escapes_on_the_terminal():
    shown = _format_model("guest", "", "\x1b[31mred")
    assert [text.plain for text in shown] == ["guest", "\\x1b[31mred"]


def test_a_models_own_word_about_what_it_covers_may_raise(labelled):
    def covers(arm: object, chosen: object) -> bool:
        raise KeyboardInterrupt

    guest = registry.Entry("guest", "C", "geared", registry.STATES, covers=covers)
    with (
        registry.register("guest", guest),
        pytest.raises(InputError, match="model guest: covers: raised KeyboardInterrupt"),
    ):
        registry.find_covering_models("geared", labelled, switches())


def interrupt(robot: object, level: object) -> NoReturn:
    raise KeyboardInterrupt


def leave(robot: object, level: object) -> NoReturn:
    os._exit(0)


def hang(robot: object, level: object) -> None:
    time.sleep(1000)


@pytest.mark.parametrize(
    ("make", "said", "verdict"),
    [
        (interrupt, "KeyboardInterrupt", "failed"),
        (leave, "Died: the process of the model ended with exit code 0", "failed"),
        (hang, "TooSlow: stopped after", "unfinished"),
    ],
)
def test_whatever_an_engine_of_robots_does_fails_its_own_checks(
    monkeypatch, impatient, make, said, verdict
):
    promises = registry.ROBOT_ABILITIES
    entry = registry.Entry("", "", "robot", promises, levels=("links",), made=make)
    robot, engines = load_robot("sliding"), {"links": ("analytic", "guest")}
    monkeypatch.setattr(robots, "find_level_engines", lambda level: engines.get(level, ()))
    with registry.register("guest", entry):
        findings = robots.compare_engines(robot, sample_states(robot, 1, 0))
    assert len(findings) == len(SIZE_WORDS)
    assert all(each.note.startswith(f"guest:links: {said}") for each in findings)
    assert {each.verdict for each in findings} == {verdict}
