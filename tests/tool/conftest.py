"""The command line as its user meets it: arguments in; exit code, output and files out."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from crosscheck.cli.app import main
from tests.brief import brief


class Answer(NamedTuple):
    """What a command left behind."""

    code: int
    out: str
    err: str


Command = Callable[..., Answer]


@pytest.fixture
def crosscheck(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """``crosscheck(*arguments)``."""

    def command(*arguments: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["crosscheck", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            main()
        return Answer(int(left.value.code or 0), *capsys.readouterr())

    return command


@pytest.fixture
def short(crosscheck: Command, tmp_path: Path) -> Command:
    """``short(*arguments)``: simulate 2 ms of constant torque into tmp_path / "run.nc"."""

    def command(*more: object, arm: object = "paper-labelled", model: str = "analytic:physical"):
        given = [str(argument) for argument in more]
        fixed = ["--model", model, "--out", tmp_path / "run.nc"]
        if "--scenario" not in given:
            fixed += ["--scenario", "constant-torque"]
        if "--t-end" not in given and "--scenario" not in given:
            fixed += ["--t-end", "0.002"]
        return crosscheck("simulate", arm, *fixed, *given)

    return command


@pytest.fixture
def brief_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    """Quick cross-checks are brief."""
    brief(monkeypatch)
