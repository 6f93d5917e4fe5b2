"""No verdict, no exit code 0: whatever code that a command runs does to its process."""

import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.processes import command_line, warm_command_line
from tests.tool.supplied import model_file

pytestmark = pytest.mark.system

Run = Callable[..., subprocess.CompletedProcess[str]]
LEAVES = "os._exit(0)"
AT_THE_END = "import atexit; atexit.register(os._exit, 0)"
ODD = "class Odd(BaseException): pass\n"
WRONG = "def f(arm): return replace(two_link(arm), bias=lambda q, v: [0.0, 0.0])"
FOREIGN = "with track_foreign_code('theirs'): "
MAPPED = (
    "def phi(x):\n    {}\n    return x\n"
    "def f(arm): return replace(two_link(arm), coordinates=Coordinates(function=phi))"
)
LEAVING = {
    "import": (f"{LEAVES}\ndef f(arm): return two_link(arm)", "its process ended with exit code 0"),
    "factory": (f"def f(arm): {LEAVES}", "its process ended with exit code 0"),
    "map": (MAPPED.format(LEAVES), "its process ended with exit code 0"),
    "crash": ("def f(arm): os.kill(os.getpid(), 11)", "its process was ended by SIGSEGV"),
    "odd import": (f"{ODD}raise Odd('here')", "f: raises Odd: here (mine.py, line "),
    "odd factory": (f"{ODD}def f(arm): raise Odd('here')", "f: raises Odd: here (mine.py, line "),
    "odd map": (ODD + MAPPED.format("raise Odd('here')"), "function: raises Odd: here, at x = "),
    "interrupt": ("def f(arm): raise KeyboardInterrupt", "f: raises KeyboardInterrupt (mine.py"),
}


def tried(folder: Path, more: str, run: Run = warm_command_line) -> tuple[int, str]:
    """Exit code and errors of the trial of ``f``."""
    target = folder / "t.json"
    file = model_file(folder, more)
    answer = run("trial", f"{file}:f", "--quick", "--jobs", 1, "--json", target)
    assert target.exists() == (answer.returncode in (0, 1))
    return answer.returncode, answer.stderr


@pytest.mark.slow
@pytest.mark.parametrize("case", LEAVING)
def test_a_users_model_that_ends_its_process_is_bad_input(tmp_path, case):
    more, said = LEAVING[case]
    code, err = tried(tmp_path, more)
    assert code == 2
    assert err.count("\n") == 1
    assert said in err


@pytest.mark.slow
def test_what_a_users_model_does_when_its_process_ends_changes_no_verdict(tmp_path):
    assert tried(tmp_path, f"{AT_THE_END}\n{WRONG}", command_line) == (1, "")


@pytest.mark.parametrize("fork", ["os.fork()", "os.fork() or os.setsid()"])
def test_a_process_that_a_users_model_forks_ends_with_the_command(tmp_path, fork):
    note = tmp_path / "pid"
    more = (
        f"import pathlib\nif not ({fork}):\n"
        f"    pathlib.Path({str(note)!r}).write_text(str(os.getpid()))\n    time.sleep(100)\n"
        f"while not os.path.exists({str(note)!r}): time.sleep(0.01)\n"
    )
    assert tried(tmp_path, f"{more}{WRONG}") == (1, "")
    assert not Path("/proc", note.read_text()).exists()


@pytest.mark.slow
def test_results_go_where_the_command_was_started_and_can_be_read(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    moving = f"os.chdir({str(tmp_path / 'elsewhere')!r}); os.umask(0o777); sys.stdout = None"
    file = model_file(tmp_path, f"{moving}\ndef f(arm):\n    {moving}\n   {WRONG[11:]}")
    answer = warm_command_line("trial", f"{file}:f", "--quick", "--json", "t.json", folder=tmp_path)
    assert answer.returncode == 1, answer.stderr
    assert "wrote t.json" in answer.stdout
    assert (tmp_path / "t.json").stat().st_mode & 0o444
    assert not list((tmp_path / "elsewhere").iterdir())


@pytest.mark.parametrize(
    ("work", "code", "said"),
    [
        ("os._exit(0)", 3, "came to no verdict: its process ended with exit code 0"),
        ("os.kill(os.getpid(), 9)", 3, "came to no verdict: its process was ended by SIGKILL"),
        ("sys.exit(0)", 0, ""),
        ("sys.exit(1)", 1, ""),
        ("sys.exit('no')", 1, "no"),
        ("atexit.register(os._exit, 0); sys.exit(1)", 1, ""),
        ("atexit.register(time.sleep, 50); sys.exit(1)", 1, ""),
        ("threading.Thread(target=time.sleep, args=(50,)).start(); sys.exit(1)", 1, ""),
        ("os.closerange(3, 100); sys.exit(0)", 3, "no verdict: its process ended with exit code 0"),
        (f"{FOREIGN}time.sleep(50)", 2, "theirs: stopped after 0 s without any"),
        (f"{FOREIGN}os._exit(0)", 2, "theirs: its process ended with exit code 0"),
        (f"{FOREIGN}pass\n    os._exit(0)", 3, "came to no verdict"),
        (
            "with track_foreign_code('theirs'):\n        while True: os.fork()",
            2,
            "processes of its own; at most 64 may run at once",
        ),
        (f"{FOREIGN}os.fork()\n    sys.exit('once')", 1, "once"),
        ("if not os.fork(): os._exit(0)\n    time.sleep(0.2); sys.exit(1)", 1, ""),
        ("if not os.fork(): sys.exit(0)\n    time.sleep(0.2); sys.exit(1)", 1, ""),
    ],
)
def test_the_commands_last_word_is_the_exit_code(work, code, said):
    text = (
        "import atexit, os, sys, threading, time\n"
        "from crosscheck.runner import cpu_limit, supervision\n"
        "from crosscheck.runner.supervision import run_supervised, track_foreign_code\n"
        "cpu_limit.IDLE_S, cpu_limit.LOOK_S, supervision.CLOSING_S = 0.2, 0.05, 0.3\n"
        f"def command():\n    {work}\n"
        "sys.exit(run_supervised(command))\n"
    )
    began = time.monotonic()
    answer = command_line(python=("-c", text))
    assert answer.returncode == code, answer.stderr
    assert answer.stderr.count("\n") == bool(said)
    assert said in answer.stderr
    assert time.monotonic() - began < 40  # their sleeps are of 50 s
