"""A wheel made from the source distribution is whole, and does what docs/ci says."""

import os
import re
import subprocess
import sys
import sysconfig
import tarfile
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from tests.processes import command_line
from tests.tool.supplied import model_file

pytestmark = pytest.mark.system

ROOT = Path(__file__).parents[2]
SOURCE_FOLDERS = ("crosscheck", "models", "analytic", "audit")
IMPORT_EVERY_MODULE = """
import importlib, pkgutil, crosscheck
for module in pkgutil.walk_packages(crosscheck.__path__, "crosscheck."):
    if not module.name.endswith("__main__"):
        importlib.import_module(module.name)
        print(module.name)
"""
FILE = ROOT / "docs" / "ci" / "github-actions.yml"
SLIPPED = """
right = two_link


def two_link(arm):
    return replace(right(arm), force=lambda torque: -np.asarray(torque))
"""


def steps() -> list[dict]:
    return yaml.safe_load(FILE.read_text(encoding="utf-8"))["jobs"]["trial"]["steps"]


def steps_that_run() -> list[str]:
    """Commands: of the installation and of the trial."""
    return [step["run"] for step in steps() if "run" in step]


@pytest.fixture(scope="module")
def project(tmp_path_factory) -> Path:
    """A folder with a model and an environment in which the workflow has installed the wheel.

    The wheel is built from the source distribution, as `pip install archive.tar.gz` does it.
    """
    folder = tmp_path_factory.mktemp("project")
    build_distribution("sdist", ROOT, folder)
    (archive,) = folder.glob("*.tar.gz")
    with tarfile.open(archive) as unpacked:
        unpacked.extractall(folder, filter="data")
    build_distribution("wheel", folder / archive.name.removesuffix(".tar.gz"), folder / "wheels")
    pip = ["--without-pip"] if find_spec("pip") else []  # the one that is there does
    subprocess.run([sys.executable, "-m", "venv", *pip, str(folder / "venv")], check=True)
    (site,) = (folder / "venv").glob("lib/python3*/site-packages")
    elsewhere = sysconfig.get_path("purelib")  # with the .pth files that are there
    (site / "dependencies.pth").write_text(f"import site; site.addsitedir({elsewhere!r})\n")
    model_file(folder, name="my_model.py")
    installed = run(folder, steps_that_run()[0])
    assert installed.returncode == 0, installed.stderr
    return folder


def build_distribution(kind: str, project: Path, folder: Path) -> None:
    """Build the source distribution or the wheel of a project into a folder."""
    words = ["-m", "hatchling", "build", "-t", kind, "-d", str(folder)]
    subprocess.run([sys.executable, *words], cwd=project, check=True, capture_output=True)


def source_modules() -> set[str]:
    """Names of all modules that the project's checkout has, without those run as a program."""
    files = subprocess.run(
        ["git", "ls-files", *SOURCE_FOLDERS], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split()
    paths = [Path(each).with_suffix("") for each in files if each.endswith(".py")]
    names = {".".join(path.parts).removesuffix(".__init__") for path in paths}
    inside = {name if name.startswith("crosscheck") else f"crosscheck.{name}" for name in names}
    return inside - {"crosscheck", "crosscheck.__main__"}


def run(project: Path, command: str) -> subprocess.CompletedProcess[str]:
    """As the build server does it, without a network and with the dependencies there."""
    environment = {
        **{key: value for key, value in os.environ.items() if key != "PYTHONPATH"},
        "PATH": f"{project / 'venv' / 'bin'}{os.pathsep}{os.environ['PATH']}",
        "PIP_NO_INDEX": "1",
        "PIP_NO_DEPS": "1",
        "PIP_FORCE_REINSTALL": "1",
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
    }
    words = ["bash", "-e", "-o", "pipefail", "-c", command]
    return subprocess.run(
        words, cwd=project, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.slow
def test_wheel_has_every_module(project):
    (project / "import_every_module.py").write_text(IMPORT_EVERY_MODULE)
    imported = run(project, "python import_every_module.py")
    assert imported.returncode == 0, imported.stderr
    assert set(imported.stdout.split()) == source_modules()


def test_wheel_runs_a_whole_cross_check(project):
    checked = run(project, "crosscheck run --quick --out cross-check")
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert (project / "cross-check" / "agreement.json").is_file()


@pytest.mark.slow
def test_commands_work_with_the_wheel_alone(project):
    _, trial = steps_that_run()
    where = run(project, 'python -c "import crosscheck; print(crosscheck.__file__)"').stdout
    assert str(project / "venv") in where
    arm = run(project, "crosscheck init my-arm.toml && sed -i /friction/d my-arm.toml")
    assert arm.returncode == 0, arm.stderr
    green = run(project, trial)
    assert green.returncode == 0, green.stdout + green.stderr
    model_file(project, SLIPPED, "my_model.py")
    red = run(project, trial)
    assert red.returncode == 1, red.stdout + red.stderr
    assert {*os.listdir(project / "report")} == {"trial.xml", "trial.json", "trial.html"}
    suite = ElementTree.parse(project / "report" / "trial.xml").getroot()
    assert int(suite.get("failures", "0")) > 0


@pytest.mark.slow
def test_the_wheel_leaves_the_names_of_its_folders_to_its_user(project):
    (project / "models").mkdir()
    (project / "models" / "__init__.py").write_text("ten = 10.0\n")
    (project / "analytic.py").write_text("eleven = 11.0\n")
    head = "from models import ten\nfrom analytic import eleven\nassert ten < eleven\n"
    given = model_file(project, name="neighbour.py")
    given.write_text(head + given.read_text())
    script = f"{head}import crosscheck; print(crosscheck.load_arm('paper-labelled').name)"
    found = run(project, f'python -c "{script}"')
    assert (found.stdout, found.stderr) == ("paper-labelled\n", "")
    trial = run(project, "crosscheck trial neighbour.py:two_link paper-labelled --quick")
    assert trial.returncode == 0, trial.stdout + trial.stderr


def test_the_action_uses_what_it_takes_and_what_is_there():
    text = (ROOT / "action.yml").read_text(encoding="utf-8")
    action = yaml.safe_load(text)
    assert set(re.findall(r"\$\{\{ inputs\.(\w+) \}\}", text)) == action["inputs"].keys()
    (trial,) = re.findall(r"crosscheck trial .*\n.*", text)
    options = {"--out", "--json", "--junit"}
    assert set(re.findall(r"--\w+", trial)) == options
    assert options <= set(re.findall(r"--\w+", command_line("trial", "--help").stdout))
    files = re.findall(r"ACTION_PATH/([\w./]+)", text)
    assert [name for name in files if not (ROOT / name).is_file()] == []
    assert {"run.lock", "tools/annotate_trial.py"} == set(files)
