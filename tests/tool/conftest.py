"""Short runs and brief plans of the command line."""

from pathlib import Path

import pytest

from tests.brief import brief
from tests.processes import Command


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
