"""What all tests share: arms as the project ships them, and the choice of a quick sample."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as on the command line

import ctypes
import gc
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

from tests.processes import Answer, Command

if TYPE_CHECKING:
    from crosscheck.models.arm.arm import Arm

gc.disable()  # until all is imported and collected: 5,000 tests take 7 s, not 10

# A first call may compile, and a machine may be busy: no example fails by the clock. The suite
# draws the same examples every time, so that only a change turns it red; `make fuzz` draws others.
settings.register_profile("suite", deadline=None, derandomize=True)
settings.register_profile("fuzz", deadline=None, print_blob=True)
settings.load_profile("fuzz" if "CROSSCHECK_DRAWS" in os.environ else "suite")


def import_program() -> None:
    """Import what tests need, in a process that runs any.

    Most tests fork: what is imported here is imported by none of their processes again.
    """
    from crosscheck.cli.app import build_commands
    from crosscheck.registry import BUILT_IN, load_model_class

    for model in BUILT_IN:
        load_model_class(model)
    build_commands()


@pytest.fixture(scope="session")
def labelled() -> "Arm":
    """The paper's arm, Table I as its labels say."""
    from crosscheck.models.loading import load_arm

    return load_arm("paper-labelled")


@pytest.fixture
def crosscheck(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """``crosscheck(*arguments)``: the command line, in this process."""
    from crosscheck.cli.app import main

    def command(*arguments: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["crosscheck", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            main()
        return Answer(int(left.value.code or 0), *capsys.readouterr())

    return command


@pytest.fixture
def refuse(
    crosscheck: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[str | list[str], Mapping[str, str | bytes]], str]:
    """``refuse(line, files)``: what is said of a command line in a folder of files.

    It is one line, and the folder is as before.
    """
    from tests.tool.test_bad_input import assert_one_line

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def refused(line: str | list[str], files: Mapping[str, str | bytes]) -> str:
        for name, text in files.items():
            content = text if isinstance(text, bytes) else text.encode("utf-8", "surrogateescape")
            (tmp_path / name).write_bytes(content)
        before = {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")}
        answer = crosscheck(*(line.split() if isinstance(line, str) else line))
        assert_one_line(answer)
        now = {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")}
        assert now == before
        return answer.err.replace(str(tmp_path), "...")

    return refused


@pytest.fixture(scope="session", autouse=True)
def few_states() -> Iterator[None]:
    """Quick trials of arms look at 5 states, not 150; those in processes of their own at all.

    Which numbers of an arm matter is asked at 1 state, not at 3. Where numbers are fitted, at 20
    more than there are, not at 50 more than twice as many. Axes of drawings stay where they were
    made: room for their labels takes half of the time. The best of 8 motions is suggested. Quick
    costs are of one state, 20 instants, and one run of ten steps.
    """
    from crosscheck.cli import cost
    from crosscheck.cost.shortcuts import SamplingPlan
    from crosscheck.identification import excitation
    from crosscheck.report.plots import figures
    from crosscheck.trial.arms import subject
    from crosscheck.trial.changes.arms import dependence, waves

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(subject, "QUICK_STATES", 5)
        patch.setattr(cost, "QUICK", SamplingPlan(1, 20, 1, 10, 100))
        patch.setattr(dependence, "FEW_STATES", 1)
        patch.setattr(excitation, "DRAWN", 8)
        patch.setattr(waves, "SPARE_STATES", 20)
        patch.setattr(waves, "STATES_PER_NUMBER", 1)
        leave_axes = wraps(figures._place_axes)(lambda figure: figure.set_layout_engine(None))
        patch.setattr(figures, "_place_axes", leave_axes)
        yield


@pytest.fixture(scope="session", autouse=True)
def usual_search() -> Iterator[Callable[..., object]]:
    """The search for the user's line, up to 15 s, but for who asks for it left out."""
    from crosscheck.trial import trial

    usual = trial.find_code
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trial, "find_code", lambda equations: None)
        yield usual


@pytest.fixture
def source_search(monkeypatch: pytest.MonkeyPatch, usual_search: Callable[..., object]) -> None:
    """Trials look for the line of the user's source that must change."""
    monkeypatch.setattr("crosscheck.trial.trial.find_code", usual_search)


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Work that uses no processor is stopped after a second, not a minute."""
    from crosscheck.runner import cpu_limit

    for name, seconds in {"IDLE_S": 1.0, "LEAST_S": 0.01, "LOOK_S": 0.1}.items():
        monkeypatch.setattr(cpu_limit, name, seconds)


@pytest.fixture(scope="module", autouse=True)
def freed_memory() -> Iterator[None]:
    """What a module has freed goes back to the system: a fork copies the table of every page."""
    yield
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # of glibc alone
    if trim is not None:
        trim(0)


@pytest.fixture(params=["paper-labelled", "paper-swapped"], scope="session")
def reading(request: pytest.FixtureRequest) -> "Arm":
    """Both readings of Table I."""
    from crosscheck.models.loading import load_arm

    return load_arm(request.param)


# Programs and recordings that a machine need not have, by the reason that skipped tests give.
OPTIONAL = ("no octave-cli here", "CROSSCHECK_RECORDINGS names no folder of recordings")


class SkipGuard:
    """Fails a run in CI in which a test was skipped for a reason that is not on the list."""

    def __init__(self) -> None:
        self.unexpected: list[str] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Look at a test's result."""
        self._note(report)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Look at a module's collection."""
        self._note(report)

    def _note(self, report: pytest.TestReport | pytest.CollectReport) -> None:
        if report.skipped and not hasattr(report, "wasxfail"):
            reason = str(report.longrepr[-1] if report.longrepr else "")
            if not any(allowed in reason for allowed in OPTIONAL):
                self.unexpected.append(f"{report.nodeid}: {reason}")

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Say which tests were skipped unexpectedly."""
        for line in self.unexpected:
            terminalreporter.write_line(f"skipped in CI, which fails the run: {line}", red=True)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Fail the run."""
        if self.unexpected and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_configure(config: pytest.Config) -> None:
    """Guard against skipped tests in CI, in the process that gathers the results."""
    is_worker = hasattr(config, "workerinput")
    if "CI" in os.environ and not is_worker:
        config.pluginmanager.register(SkipGuard())
    if is_worker or not config.getoption("numprocesses", None):  # else workers run the tests
        import_program()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """One more than cores: tests wait for processes and timers an eighth of their time."""
    return (os.cpu_count() or 1) + 1


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--first-cases``."""
    about = "of every test its first case, and none that is slow or a campaign"
    parser.addoption("--first-cases", action="store_true", help=about)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what ``--first-cases`` does not want."""
    if not config.getoption("--first-cases"):
        return
    first: dict[str, pytest.Item] = {}
    for item in items:
        if not {"slow", "campaign"} & {mark.name for mark in item.iter_markers()}:
            first.setdefault(item.nodeid.partition("[")[0], item)
    wanted = set(first.values())
    config.hook.pytest_deselected(items=[item for item in items if item not in wanted])
    items[:] = [item for item in items if item in wanted]


def pytest_collection_finish() -> None:
    """Keep what was imported and collected out of garbage collections, and shared by forks.

    Collections are rare: as often as usual, they take 3 % of the suite's time.
    """
    gc.freeze()
    gc.set_threshold(10_000, 10, 20)
    gc.enable()
