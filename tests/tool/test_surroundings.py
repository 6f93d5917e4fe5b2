"""The program where there is no home, no room, no folder to work in, no such letter, no reader."""

import os
import resource
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
import xarray as xr

from crosscheck.provenance import ROOT
from tests.processes import command_line

pytestmark = pytest.mark.system

SHORT = ("simulate", "--model", "pinocchio:links", "--scenario", "pd", "--t-end", "0.0002")
NOWHERE = "/dev/null/home"  # no folder can be made there, by anyone
HOMELESS = {"HOME": NOWHERE, "XDG_CACHE_HOME": "", "XDG_CONFIG_HOME": "", "MPLCONFIGDIR": ""}
# Python's own ways round a poor locale switched off.
PLAIN = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
LOCALES = {
    "C": {"LC_ALL": "C"},
    "POSIX": {"LC_ALL": "POSIX"},
    "ASCII": PLAIN,
    "latin-1": {"PYTHONIOENCODING": "latin-1"},
}


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """An arm whose file name and own name are in no single code page."""
    text = (ROOT / "models" / "arms" / "paper-labelled.toml").read_text(encoding="utf-8")
    file = tmp_path / "ärm\u2192.toml"
    file.write_text(text.replace('"paper-labelled"', '"Ä\u2192Ж"', 1), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def unwritable(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The packages where numba can keep nothing beside them."""
    root = tmp_path_factory.mktemp("unwritable")
    without = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "crosscheck", root / "crosscheck", ignore=without)
    for folder in {path.parent for path in root.rglob("*.py")}:
        (folder / "__pycache__").touch()
    return root


@pytest.mark.parametrize("locale", LOCALES)
def test_every_locale_has_every_letter(locale):
    script = (
        r"from crosscheck.cli.environment import prepare; prepare(); print('\u00c4\u2192\u0416')"
    )
    answer = command_line(python=("-c", script), env=LOCALES[locale], text=False)
    assert (answer.returncode, answer.stderr) == (0, b"")
    shown = {"latin-1": b"\xc4\\u2192\\u0416\n", "ASCII": b"\\xc4\\u2192\\u0416\n"}
    assert answer.stdout == shown.get(locale, "Ä\u2192Ж\n".encode())


def test_a_bad_name_is_one_line_in_a_locale_without_its_letters():
    answer = command_line("Ä\u2192Ж", env=PLAIN, errors="replace")
    assert (answer.returncode, answer.stdout) == (2, "")
    assert answer.stderr.startswith("crosscheck: No such command")
    assert answer.stderr.count("\n") == 1


def test_an_arm_is_shown_in_a_locale_without_its_letters(arm):
    answer = command_line("show", arm, env=PLAIN)
    assert (answer.returncode, answer.stderr) == (0, "")
    assert r"\xc4\u2192\u0416" in answer.stdout
    assert "0.0368240" in answer.stdout


@pytest.mark.slow
def test_files_are_written_in_a_locale_without_their_letters(arm, tmp_path):
    out = tmp_path / "Ordner Ä" / "run\u2192.nc"
    answer = command_line(*SHORT, arm, "--out", out, env=PLAIN)
    assert (answer.returncode, answer.stderr) == (0, "")
    assert "Ordner" in xr.load_dataset(out, engine="h5netcdf").attrs["command"]


@pytest.mark.parametrize("arguments", [("--help",), ("--version",)])
def test_a_full_disk_behind_standard_output_is_one_line(arguments):
    with open("/dev/full", "w") as full:
        answer = command_line(*arguments, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    line = "crosscheck: standard output: cannot be written: No space left on device\n"
    assert (answer.returncode, answer.stderr) == (2, line)


@pytest.mark.parametrize(("arguments", "code"), [(("--help",), 0), (("fly",), 2)])
def test_a_full_disk_behind_standard_error_changes_nothing(arguments, code):
    with open("/dev/full", "w") as full:
        answer = command_line(*arguments, capture_output=False, stdout=subprocess.PIPE, stderr=full)
    assert answer.returncode == code


def test_closed_streams_change_nothing(tmp_path):
    out = tmp_path / "run.nc"
    script = 'exec "$0" -m crosscheck "$@" >&- 2>&- <&-'
    command = ["sh", "-c", script, sys.executable, *SHORT, "probe", "--out", str(out)]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (answer.returncode, answer.stderr) == (0, "")
    assert xr.load_dataset(out, engine="h5netcdf").sizes["time"] == 3


def test_a_reader_may_stop_reading():
    script = 'set -o pipefail; "$0" -u -m crosscheck --help | true'
    command = ["bash", "-c", script, sys.executable]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (answer.returncode, answer.stderr) == (0, "")


@pytest.mark.parametrize("files", [8, 63])
def test_too_few_open_files_are_one_line(files):
    limit = partial(resource.setrlimit, resource.RLIMIT_NOFILE, (files, files))
    answer = command_line("--version", preexec_fn=limit)
    assert (answer.returncode, answer.stdout, answer.stderr.count("\n")) == (2, "", 1)
    assert f"open files: a limit of {files} is set; at least 64 are needed" in answer.stderr


@pytest.mark.parametrize("arguments", [("list",), ("run", "--quick")])
def test_a_removed_working_folder_is_one_line(tmp_path, arguments):
    folder = tmp_path / "gone"
    folder.mkdir()

    def remove() -> None:
        os.chdir(folder)
        folder.rmdir()

    answer = command_line(*arguments, preexec_fn=remove, env={"PYTHONPATH": str(ROOT)})
    assert (answer.returncode, answer.stdout) == (2, "")
    assert answer.stderr == "crosscheck: working folder: is gone: No such file or directory\n"


@pytest.mark.parametrize("home", [HOMELESS, HOMELESS | {"HOME": ""}, HOMELESS | {"HOME": "."}])
def test_drawing_needs_no_home(tmp_path, home):
    script = (
        "from crosscheck.cli.environment import prepare; prepare()\n"
        "import matplotlib; print(matplotlib.get_configdir(), matplotlib.get_cachedir())"
    )
    env = home | {"PYTHONPATH": str(ROOT), "TMPDIR": str(tmp_path)}
    answer = command_line(python=("-c", script), env=env, cwd=tmp_path)
    assert (answer.returncode, answer.stderr) == (0, "")
    assert not list(tmp_path.glob("geararm-*"))  # a folder for one process goes with it


@pytest.mark.slow
def test_kernels_need_no_writable_package_and_no_cache_folder(unwritable, tmp_path):
    script = (
        "from crosscheck.models import numba_cache\n"
        "assert numba_cache.__file__.startswith(os.environ['PYTHONPATH'])\n"
        "print(numba_cache.prepare_code_folder('compiled'))"
    )
    for home, kept_in in ((HOMELESS, tmp_path), ({"XDG_CACHE_HOME": str(unwritable)}, unwritable)):
        env = home | {"PYTHONPATH": str(unwritable), "TMPDIR": str(tmp_path)}
        answer = command_line(python=("-c", f"import os\n{script}"), env=env, cwd=tmp_path)
        assert (answer.returncode, answer.stderr) == (0, "")
        assert answer.stdout.startswith(str(kept_in))
    assert not list(tmp_path.glob("geararm-*"))
    assert (unwritable / "geararm-crosscheck").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("threads", ["", "3"])
def test_linear_algebra_has_one_thread_or_as_many_as_its_user_says(threads):
    # The library reads it when it is loaded.
    script = (
        "import os, sys\nfrom crosscheck.cli.app import main\nassert 'numpy' not in sys.modules\n"
        "from crosscheck.cli.environment import prepare\nprepare()\n"
        "print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    given = {key: value for key, value in os.environ.items() if key != "OPENBLAS_NUM_THREADS"}
    if threads:
        given["OPENBLAS_NUM_THREADS"] = threads
    said = subprocess.run(
        [sys.executable, "-c", script], env=given, capture_output=True, text=True, check=True
    )
    assert said.stdout == f"{threads or 1}\n"
