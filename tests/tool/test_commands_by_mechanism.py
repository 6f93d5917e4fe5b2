"""Every command on every kind of mechanism: a table whose cells are all run.

Each ends with 0 or 1, and every file that it names is there with content. A cross-check is computed
once for a mechanism; each command that needs it renders it by itself.
"""

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from crosscheck.checks import engines, levels
from crosscheck.cli import commands
from crosscheck.identification import excitation
from crosscheck.models.arm.arm import Arm
from crosscheck.models.files import format_toml_fields
from crosscheck.planning import robots
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.run import CrossCheck, run_cross_check
from crosscheck.trial.tables.folder import format_arm_toml
from tests.arms import arm_of
from tests.brief import brief, perform_here
from tests.processes import Answer, Command
from tests.robots.chains import Solid, geared, joint, link, planetary, urdf
from tests.tool.test_bad_input import assert_one_line

BODY = Solid(2.0, (0.3, 0.02, -0.05), (0.05, 0.002, 0.001, 0.06, -0.003, 0.07))
DIRECT = {"kind": "direct"}
EQUATIONS = """
import crosscheck

def right(mechanism):
    scenario = crosscheck.load_scenario("constant-torque")
    model = crosscheck.build("analytic:coupled", mechanism, scenario)
    return crosscheck.Equations(mass_matrix=model.mass_matrix)
"""
STUDY = """
schema_version = 1
name = "study"
{kind} = "{file}"
scenario = "pd"
spot_checks = 1
settings = {{ "scenario.duration_s" = 0.01 }}
axes = [{{ path = "{path}", kind = "list", values = [1.0, 1.5] }}]
quantities = [{{ kind = "peak", signal = "theta_ddot", joint = 1 }}]
"""


@dataclass(frozen=True)
class MechanismFile:
    """A file that commands take; path: of a number that a study varies."""

    file: Path
    kind: str
    path: str
    has_meshes: bool
    is_direct: bool


def write_arm(folder: Path, arm: Arm, weight: float = 9.81) -> MechanismFile:
    """Write an arm's file."""
    changed = arm.model_copy(update={"gravity_m_per_s2": (0.0, -weight), "name": "mine"})
    file = folder / "mine.toml"
    file.write_text(format_arm_toml(changed))
    geared = any(joint.kind == "planetary" for joint in arm.joints)
    return MechanismFile(file, "arm", "arm.payload_mass_kg", geared, not geared)


def write_robot(folder: Path, **joints: dict[str, Any]) -> MechanismFile:
    """Write a chain's URDF and file, whose joints are slides if their names say so."""
    parts, parent = [link("base")], "base"
    for name in joints:
        kind = "prismatic" if "slide" in name else "revolute"
        parts += [link(f"{name}_link", BODY)]
        parts += [joint(name, parent, f"{name}_link", kind, (0, 1, 0), (0.4, 0, 0.1))]
        parent = f"{name}_link"
    (folder / "mine.urdf").write_text(urdf(*parts))
    file = folder / "mine.toml"
    fields = {"schema_version": 1, "name": "mine", "urdf": "mine.urdf", "joints": joints}
    file.write_text("\n".join(format_toml_fields(fields)))
    meshed = any("sun_mesh" in transmission for transmission in joints.values())
    varied = f"robot.links.{next(iter(joints))}_link.mass_kg"
    return MechanismFile(file, "robot", varied, meshed, all(t == DIRECT for t in joints.values()))


MECHANISMS: dict[str, Callable[[Path], MechanismFile]] = {
    "arm, one direct joint, no weight": lambda folder: write_arm(folder, arm_of(1, direct=(0,)), 0),
    "arm, direct and geared": lambda folder: write_arm(folder, arm_of(2, direct=(0,))),
    "robot, hinge": lambda folder: write_robot(folder, hinge=DIRECT),
    "robot, hinge with stage": lambda folder: write_robot(folder, hinge=planetary()),
    "robot, slide and hinge": lambda folder: write_robot(folder, slide=geared(-30), hinge=DIRECT),
}


@pytest.fixture(scope="module", params=MECHANISMS)
def mechanism(request, tmp_path_factory) -> Iterator[MechanismFile]:
    """A mechanism in a folder of its own, which is the working folder."""
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("mechanism")
        patch.chdir(folder)
        brief(patch)
        perform_here(patch)
        for module in (engines, levels):
            patch.setattr(module, "RUNS", 1)
        patch.setattr(excitation, "DRAWN", 1)
        patch.setattr(robots, "QUICK_COUNT", 4)
        patch.setattr(robots, "QUICK_STEPS", 20)
        patch.setattr(robots, "LEAST_STEPS", 10)
        patch.setattr(commands, "run_cross_check", ReplayedCrossCheck())
        yield MECHANISMS[request.param](folder)


class ReplayedCrossCheck:
    """``run_cross_check``, which computes once what several commands ask."""

    def __init__(self) -> None:
        self.result: CrossCheck | None = None

    def __call__(self, chosen: CrossCheckRequest, **more: Any) -> CrossCheck:
        if self.result is None:
            self.result = run_cross_check(chosen, **more)
        return self.result


@pytest.fixture
def perform(crosscheck: Command, mechanism: MechanismFile) -> Callable[..., Answer]:
    """``perform(arguments, files)``: the command, which must end well and write these files."""

    def command(arguments: str, *files: str) -> Answer:
        answer = crosscheck(*arguments.split())
        assert answer.code in (0, 1), answer.err
        assert "Traceback" not in answer.err
        lines = re.findall(r"^wrote ([^:\n]+)", answer.out, re.MULTILINE)
        written = {name.strip() for line in lines for name in line.split(" and ")}
        assert {Path(name).name for name in written} >= {Path(name).name for name in files}
        for path in map(Path, (*written, *files)):
            for file in path.glob("*.csv") if path.is_dir() else (path,):
                assert file.stat().st_size, file
                if file.suffix == ".json":  # without a number that JSON does not have
                    json.loads(file.read_text(encoding="utf-8"), parse_constant=pytest.fail)
        return answer

    return command


def test_show(perform):
    assert "gravity" in perform("show mine.toml").out


def test_validate(perform):
    answer = perform("validate mine.toml --quick --jobs 1 --json v.json --junit v.xml")
    assert answer.code == 0
    findings = json.loads(Path("v.json").read_text())["findings"]
    cases = list(ElementTree.fromstring(Path("v.xml").read_text()).iter("testcase"))
    assert len(findings) >= len(cases) > 50


def test_run(perform, mechanism):
    files = "report/index.html", "report/agreement.json"
    answer = perform("run mine.toml --quick --jobs 1 --out report", *files)
    has_mesh_column = mechanism.has_meshes and mechanism.kind == "arm"
    for view in (answer.out, Path("report/index.html").read_text()):
        assert ("mesh force" in view) == has_mesh_column


def test_simulate_and_view_the_finest_level(perform, mechanism):
    level = "geared" if mechanism.has_meshes else "coupled"
    level = "physical" if mechanism.kind == "arm" else level
    model = f"--model analytic:{level} --scenario constant-torque --t-end 0.02"
    perform(f"simulate mine.toml {model} --out run.nc", "run.nc")
    perform("view run.nc", "run.html")


def test_compare_a_run_of_links(perform):
    model = "--model analytic:links --scenario pd --t-end 0.02"
    perform(f"simulate mine.toml {model} --out links.nc", "links.nc")
    perform("compare links.nc mine.toml --json c.json --out .", "c.json", "compare.html")


def test_cost(perform, mechanism):
    rotors = " --ratio 101 --rotor-inertia 1e-4" * mechanism.is_direct
    perform(f"cost mine.toml --quick --json cost.json --out .{rotors}", "cost.json", "cost.html")


def test_export(perform, mechanism):
    perform("export mine.toml --model analytic:links --out model.c", "model.c")
    assert "double" in Path("model.c").read_text()
    if mechanism.kind == "arm":
        perform("export mine.toml --out arm.urdf", "arm.urdf", "arm.toml")


def test_trial(perform, mechanism):
    Path("equations.py").write_text(EQUATIONS)
    more = "--jobs 1 --json t.json --out ." + " --quick" * (mechanism.kind == "arm")
    answer = perform(f"trial equations.py:right mine.toml {more}", "t.json", "trial.html")
    assert answer.code == 0
    perform(f"trial --ask mine.toml --out asked{' --quick' * (mechanism.kind == 'arm')}", "asked")


def test_a_record_is_kept_until_the_mechanism_changes(perform, crosscheck, mechanism):
    perform("baseline accept mine.toml --quick --jobs 1 --dir .", "mine-quick.json")
    check = "baseline check mine.toml --quick --jobs 1 --dir ."
    assert "changed since the record: nothing" in perform(check).out
    changed = crosscheck(*check.split(), "--set", f"{mechanism.path}=7.5")
    assert_one_line(changed, f"another {mechanism.kind} than mine", "7.5")


def test_sweep_and_plot(perform, mechanism):
    names = {"kind": mechanism.kind, "file": mechanism.file.name, "path": mechanism.path}
    Path("study.toml").write_text(STUDY.format(**names))
    perform("sweep study.toml --out study.nc --jobs 1", "study.nc")
    perform("plot study.nc", "study.png")


def test_init(perform, mechanism):
    if mechanism.kind == "robot":
        perform("init begun.toml --urdf mine.urdf", "begun.toml")
    begun = Path("begun.toml").exists()
    assert begun == (mechanism.kind == "robot")
