"""Short runs and brief plans of the command line."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.brief import brief
from tests.processes import Answer, Command


@pytest.fixture
def short(crosscheck: Command, tmp_path: Path) -> Command:
    """``short(*arguments)``: simulate 2 ms of constant torque into tmp_path / "run.nc"."""

    def command(
        *more: object,
        arm: object = "paper-labelled",
        model: str = "analytic:physical",
        settings: Sequence[str] = (),
    ) -> Answer:
        given = [*map(str, more), *(word for each in settings for word in ("--set", each))]
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


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """A time [s] that a test sets, of the limits of work and of what is said meanwhile."""
    now = [100.0]
    for module in ("cpu_limit", "progress", "progress_update"):
        clock = SimpleNamespace(monotonic=lambda: now[0])
        monkeypatch.setattr(f"crosscheck.runner.{module}.time", clock)
    return now


@pytest.fixture
def no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands do none of their work: what is refused is refused before it."""
    for work in (
        "cli.simulation.perform_all",
        "cli.commands.run_cross_check",
        "cli.trial.run_trial",
        "audit.errata.command.simulate_errata",
        "audit.page.report.write_paper",
    ):
        monkeypatch.setattr(f"crosscheck.{work}", None)


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The program's folder, in an empty cache folder of the user's."""
    from crosscheck.models import directories, numba_cache

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    remembered = (
        directories.prepare_cache_folder,
        directories.prepare_code_folder,
        directories.make_temporary_folder,
        numba_cache._stamp,
    )
    for function in remembered:
        function.cache_clear()
    yield tmp_path / "cache" / "geararm-crosscheck"
    for function in remembered:
        function.cache_clear()
