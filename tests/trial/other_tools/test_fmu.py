"""FMUs: right ones agree, a wrong one has its entry named, hostile ones are refused."""

import ctypes
import io
import json
import re
import shutil
import stat
import subprocess
import tomllib
import zipfile
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import cast
from unittest.mock import Mock

import numpy as np
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.analytic.kernel.export import generate_c_source
from crosscheck.analytic.kernel.fmu import generate_fmu_sources
from crosscheck.analytic.model import AnalyticModel
from crosscheck.checks.answers import sample_states
from crosscheck.checks.scales import geared_joints, motor_lever, sun_advance
from crosscheck.cli.files.export import build_model, make_c_name, unit_file
from crosscheck.findings import Finding
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.drive import torques_at
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.runner import cpu_limit
from crosscheck.runner.progress_update import ignore_progress
from crosscheck.trial.arms import subject as trial_module
from crosscheck.trial.fmu import archive
from crosscheck.trial.fmu import unit as unit_module
from crosscheck.trial.fmu.archive import DESCRIPTION, MappedUnit, load_unit, unpack_fmu
from crosscheck.trial.fmu.unit import (
    ExchangeUnit,
    LoadedUnit,
    build_fmu_equations,
    compare_unit_runs,
)
from crosscheck.trial.input.calls import describe_failure
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.judge.entries import format_entry
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import Trial
from crosscheck.trial.trial import run_trial
from tests.robots import chains, two_link
from tests.tool.test_bad_input import assert_one_line

COMPILER = shutil.which("gcc")
fmi2, fmi3 = (pytest.importorskip(f"fmpy.fmi{n}", reason="no FMPy here") for n in (2, 3))
pytestmark = pytest.mark.skipif(COMPILER is None, reason="no gcc here")
RIGID = """\
q = ["theta_1", "theta_2"]
v = ["v_theta_1", "v_theta_2"]
torque = ["torque_1", "torque_2"]
"""
GEARED = """
q = ["x_sp1", "x_pr1", "theta_1", "x_sp2", "x_pr2", "theta_2"]
v = ["v_x_sp1", "v_x_pr1", "v_theta_1", "v_x_sp2", "v_x_pr2", "v_theta_2"]
torque = ["torque_1", "torque_2"]
gearing = "lumped"
"""


@pytest.fixture(autouse=True)
def few_states(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_module, "QUICK_STATES", 1)


@pytest.fixture(autouse=True)
def trial_in_this_process() -> None:
    """Units are binaries, some of which abort or hang here: workers ask them."""


def generated(arm: str, name: str, *settings: str) -> tuple[AnalyticModel, str, str]:
    """A model, the prefix of its names in C, and its C."""
    model = build_model(arm, name, list(settings))
    prefix = make_c_name(model.arm.name)
    return model, prefix, generate_c_source(model.term_equations, prefix, "a model")


def replaced(text: str, changes: Iterable[tuple[str, str]]) -> str:
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return text


def exported(arm: str, name: str, *changes: tuple[str, str], settings: Sequence[str] = ()) -> bytes:
    """The program's own FMU of a model, its C changed before it is compiled."""
    model, prefix, text = generated(arm, name, *settings)
    joints = len(model.arm.joints)
    sources = generate_fmu_sources(replaced(text, changes), prefix, model.layout, joints)
    return unit_file(prefix, *sources)


def described_as(**words: str) -> bytes:
    """The program's own unit, words of its description changed, without binaries."""
    model, prefix, text = generated("paper-labelled", "analytic:links")
    _, description, *_ = generate_fmu_sources(text, prefix, model.layout, 2)
    return zipped({DESCRIPTION: replaced(description, words.items()).encode()})


def test_exported_unit_is_the_model_in_states_time_and_units(tmp_path):
    """Of a law by frequency times time, from a start that is not zero: FMPy asks, ours answers."""
    import fmpy

    own = "paper-labelled", "analytic:physical"
    model, file = build_model(*own, ["switches.phase=omega_t"]), tmp_path / "unit.fmu"
    n = len(model.layout)
    file.write_bytes(exported(*own, settings=["switches.phase=omega_t"]))
    description = fmpy.read_model_description(file)
    units = {each.name: each.unit for each in description.modelVariables}
    kinds = {c.name: "rad" if c.meaning == "theta" else "m" for c in model.layout.coordinates}
    assert [units[name] for name in kinds] == list(kinds.values())
    assert [units[f"v_{name}"] for name in kinds] == [f"{kind}/s" for kind in kinds.values()]
    unit = fmi2.FMU2Model(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(file), str(tmp_path / "unit")),
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="unit",
    )
    unit.instantiate()
    try:
        for t, q, v in zip(*sample_states(model.layout, model.arm, 5, 3), strict=True):
            torque = np.array([40.0 * np.sin(5 * t), -9.0 * np.cos(3 * t)])
            unit.reset()
            unit.setupExperiment(startTime=t)  # the first time alone, then a later one
            unit.enterInitializationMode()
            unit.setReal(range(2 * n), [*q, *v])
            unit.setReal([4 * n, 4 * n + 1], torque)
            unit.exitInitializationMode()
            for time in (t, t + 0.37):
                if time > t:
                    unit.setTime(time)
                found = np.array(unit.getReal(range(4 * n)))
                assert found[: 2 * n] == pytest.approx([*q, *v], rel=1e-15)
                assert found[2 * n : 3 * n] == pytest.approx(v, rel=1e-15)
                mass, bias = model.mass_matrix(q), model.bias(q, v)
                away = torque - torques_at(
                    model.drive, time, q[model.layout.theta], v[model.layout.theta]
                )
                force = model.generalized_force(time, q, v)
                for number, joint in geared_joints(model.arm):
                    force = force + away[number] / motor_lever(joint) * sun_advance(
                        model.layout, number
                    )
                    force[model.layout.at("theta", number)] += away[number]
                known = np.linalg.solve(mass, force - bias)
                assert found[3 * n :] == pytest.approx(known, rel=1e-9, abs=1e-9 * abs(known).max())
                # An integrator takes states and derivatives by calls of their own.
                states, derivatives = (ctypes.c_double * (2 * n))(), (ctypes.c_double * (2 * n))()
                unit.getContinuousStates(states, 2 * n)
                unit.getDerivatives(derivatives, 2 * n)
                assert [*states] == [*q, *v]
                assert [*derivatives] == [*found[2 * n :]]
    finally:
        unit.terminate()
        unit.freeInstance()


def mapped(content: bytes, mapping: str, arm: str, folder: Path) -> MappedUnit:
    file, names, into = folder / "unit.fmu", folder / "map.toml", folder / "unpacked"
    file.write_bytes(content)
    names.write_text(mapping, encoding="utf-8")
    into.mkdir()
    return load_unit(file, names, load_arm(arm), into)


def judged(content: bytes, mapping: str, arm: str, folder: Path) -> Trial:
    own = load_arm(arm)
    equations = build_fmu_equations(mapped(content, mapping, arm, folder), own)
    return run_trial(TrialRequest("unit.fmu", equations, own, quick=True))


def test_entry_of_a_wrong_model_is_named(tmp_path):
    """The payload at the second link's centre of mass, beside the diagonal of M."""
    coupling = [(f"mass_{k} = 13.614999999999998", f"mass_{k} = 10.115") for k in (3, 5)]
    content = exported("paper-labelled", "analytic:links", *coupling)
    trial = judged(content, RIGID, "paper-labelled", tmp_path)
    inertia = [wrong for wrong in trial.diagnosis.entries if wrong.place.part == "mass_matrix"]
    entries = {format_entry(wrong.place, trial.problem.frame.names) for wrong in inertia}
    assert entries == {"M[theta_1, theta_2]", "M[theta_2, theta_1]"}
    names = {
        error.right for wrong in inertia if wrong.explanation for error in wrong.explanation.errors
    }
    assert trial.level == "links"
    assert names == {"L2"}


def test_a_robot_takes_a_unit(crosscheck, tmp_path):
    """An arm's links as a unit agree with its URDF; with a payload elsewhere M[j1, j2] differs."""
    arm, robot = load_arm("paper-labelled"), tmp_path / "arm.urdf"
    ends = [(link.length_m, 0, 0) for link in arm.links]
    one, two = (
        chains.Solid(each.mass, (each.com_m, 0, 0), (0.1, 0, 0, each.inertia, 0, each.inertia))
        for each in arm.links
    )
    payload = chains.Solid(arm.payload_mass_kg, inertia=(0, 0, 0, 0, 0, 0))
    text = chains.urdf(
        *map(chains.link, ("base", "one", "two", "tool"), (None, one, two, payload)),
        chains.joint("j1", "base", "one"),
        chains.joint("j2", "one", "two", at=ends[0]),
        chains.joint("held", "two", "tool", "fixed", at=ends[1]),
    )
    robot.write_text(text, encoding="utf-8")
    (tmp_path / "map.toml").write_text(RIGID, encoding="utf-8")
    coupling = [(f"mass_{k} = 13.614999999999998", f"mass_{k} = 10.115") for k in (3, 5)]
    for name, changes, code, words in (
        ("right.fmu", [], 0, "agrees with the rigid robot"),
        ("wrong.fmu", coupling, 1, "M[j1, j2] alone is wrong"),
    ):
        (tmp_path / name).write_bytes(exported("paper-labelled", "analytic:links", *changes))
        options = "--coordinates", tmp_path / "map.toml", "--run-code", "--jobs", "1"
        answer = crosscheck("trial", tmp_path / name, robot, *options)
        assert (answer.code, words in answer.out) == (code, True), answer.out


@pytest.mark.parametrize("name", ["newDiscreteStates", "updateDiscreteStates"])
@pytest.mark.parametrize("count", [100, 101])
def test_a_unit_whose_events_do_not_end_does_not_start(count, name, monkeypatch):
    updates = iter([(True,)] * (count - 1) + [(False,)])
    own = {"unit": Mock(**{name: lambda: next(updates)}), "old": name.startswith("new")}
    monkeypatch.setattr(LoadedUnit, "__init__", lambda self, mapped: vars(self).update(own))
    ends = nullcontext() if count == 100 else pytest.raises(RuntimeError, match="do not end")
    with ends:
        ExchangeUnit(Mock(**{"description.states": ()}))


@pytest.mark.parametrize(
    "coordinates", [{"links": "absolute"}, {"matrix": [[1.0, 2.0], [0.5, 3.0]]}]
)
@pytest.mark.parametrize("kind", ["arm", "robot"])
def test_a_unit_in_other_coordinates_has_their_equations(kind, coordinates, monkeypatch):
    """With theta = J x: M_x = J' M J, bias_x = J' bias, and J' torque less weights is the force."""
    subject = load_arm("paper-labelled") if kind == "arm" else two_link.robot()
    J = np.array(coordinates.get("matrix", [[1.0, 0.0], [-1.0, 1.0]]))
    rng = np.random.default_rng(3)
    x, u, torque = rng.normal(size=(3, 2))

    def rates(t: float, x: np.ndarray, u: np.ndarray, torque: np.ndarray) -> np.ndarray:
        rest = torque - two_link.gravity(J @ x) - two_link.bias(J @ x, J @ u)
        return np.linalg.solve(J, np.linalg.solve(two_link.mass_matrix(J @ x), rest))

    fake = SimpleNamespace(rates=rates)
    monkeypatch.setattr(unit_module, "_load_exchange_unit", lambda unit, process: fake)
    mapped_unit = SimpleNamespace(
        coordinates=Coordinates(**coordinates), level="", v=(), places=lambda names: slice(None)
    )
    own = build_fmu_equations(cast("MappedUnit", mapped_unit), subject)
    q, v = J @ x, J @ u
    for found, expected in (
        (own.mass_matrix(x), J.T @ two_link.mass_matrix(q) @ J),
        (own.bias(x, u), J.T @ two_link.bias(q, v)),
        (own.force(0.0, x, u, torque), J.T @ (torque - two_link.gravity(q))),
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)  # pushes of 1e3 N m


def c_of(name: str) -> str:
    """The C of a unit beside that of its equations."""
    return Path(__file__).with_name("fmu").joinpath(f"{name}.c").read_text(encoding="utf-8")


def compile_library(code: str, interface: type, folder: Path) -> bytes:
    """The shared library of C; functions of the interface that nobody calls return an error."""
    called = [each for each in dir(interface) if each.startswith("fmi")]
    unused = [each for each in called if f"{each}(" not in code]
    code += "".join(f"int {each}(void) {{ return 3; }}\n" for each in unused)
    source, library = folder / "unit.c", folder / "unit.so"
    source.write_text(code, encoding="utf-8")
    command = [str(COMPILER), "-O1", "-fPIC", "-shared", "-o", library, source, "-lm"]
    subprocess.run(command, check=True)
    return library.read_bytes()


def stepped_2(arm: str, name: str, folder: Path) -> bytes:
    """A unit of FMI 2.0 for Co-Simulation around the exported C."""
    model, prefix, code = generated(arm, name)
    _, description, *_ = generate_fmu_sources(code, prefix, model.layout, len(model.arm.joints))
    kind = f'ModelExchange modelIdentifier="{prefix}"', 'CoSimulation modelIdentifier="unit"'
    stepping = c_of("stepped_2").replace("PREFIX", prefix)
    library = compile_library(code + stepping, fmi2.FMU2Slave, folder)
    described = replaced(description, [kind]).encode()
    return zipped({DESCRIPTION: described, "binaries/linux64/unit.so": library})


def run_beside_engines(
    content: bytes, mapping: str, duration_s: float, folder: Path
) -> Sequence[Finding]:
    """The checks of a unit's run under constant torque."""
    arm, unit = load_arm("paper-labelled"), mapped(content, mapping, "paper-labelled", folder)
    scenario = load_scenario("constant-torque").model_copy(update={"duration_s": duration_s})
    given = unit, "unit.fmu", arm, [scenario], usual_switches(arm), 1, ignore_progress
    return compare_unit_runs(*given).checks


@pytest.mark.parametrize(
    ("model", "mapping"),
    [("analytic:coupled", RIGID + 'level = "coupled"\n'), ("analytic:physical", GEARED)],
)
def test_co_simulation_of_version_2_agrees(model, mapping, tmp_path):
    content = stepped_2("paper-labelled", model, tmp_path)
    found = run_beside_engines(content, mapping, 0.002, tmp_path)
    assert len(found) > 1
    assert [finding for finding in found if finding.verdict != "agree"] == []


def version_3(
    arm: str, name: str, folder: Path, steps: bool = False, *changes: tuple[str, str]
) -> bytes:
    """A unit of FMI 3.0 around the exported C."""
    model, prefix, code = generated(arm, name)
    code += c_of("version_3")
    if steps:  # where states are set as any variables
        code += c_of("stepped_3")
        torque = "((Unit *)c)->torque[r[k] - 4 * N] = x[k]"
        state = "((Unit *)c)->state[r[k]] = x[k]"
        code = replaced(code, [(torque, f"r[k] < 2 * N ? ({state}) : ({torque})")])
    code = replaced(code, [("PREFIX", prefix), *changes])
    library = compile_library(code, fmi3.FMU3Slave if steps else fmi3.FMU3Model, folder)
    description = description_3(list(model.layout.names), steps).encode()
    return zipped({DESCRIPTION: description, "binaries/x86_64-linux/unit.so": library})


def description_3(coordinates: list[str], steps: bool) -> str:
    n, names = len(coordinates), [*coordinates, *(f"v_{each}" for each in coordinates)]
    real = '<Float64 name="{}" valueReference="{}" variability="continuous" {}/>'
    state = 'causality="{}" initial="exact" start="0"'.format("output" if steps else "local")
    rows = [real.format(each, k, state) for k, each in enumerate(names)]
    rows += [
        real.format(f"der({each})", 2 * n + k, f'causality="local" derivative="{k}"')
        for k, each in enumerate(names)
    ]
    rows += [
        real.format(f"torque_{j + 1}", 4 * n + j, 'causality="input" start="0"') for j in range(2)
    ]
    rows.append(real.format("time", 999, 'causality="independent"'))
    unknowns = [f'<ContinuousStateDerivative valueReference="{2 * n + k}"/>' for k in range(2 * n)]
    unknowns += [f'<InitialUnknown valueReference="{2 * n + k}"/>' for k in range(2 * n)]
    outputs = [f'<Output valueReference="{k}"/>' for k in range(2 * n)] if steps else []
    kind = "CoSimulation" if steps else "ModelExchange"
    return (
        '<fmiModelDescription fmiVersion="3.0" modelName="unit" instantiationToken="{1}">'
        f'<{kind} modelIdentifier="unit"/>'
        f"<ModelVariables>{''.join(rows)}</ModelVariables>"
        f"<ModelStructure>{''.join(outputs + unknowns)}</ModelStructure></fmiModelDescription>"
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("version", "arm", "model", "mapping", "level"),
    [
        (2, "paper-labelled", "analytic:coupled", RIGID, "coupled"),
        (2, "probe", "analytic:physical", GEARED, ""),
        (3, "paper-labelled", "analytic:coupled", RIGID, "coupled"),
    ],
)
def test_right_models_are_not_blamed(version, arm, model, mapping, level, tmp_path):
    content = exported(arm, model) if version == 2 else version_3(arm, model, tmp_path)
    trial = judged(content, mapping, arm, tmp_path)
    assert (trial.exit_code, trial.diagnosis.entries, trial.level) == (0, (), level)


@pytest.mark.parametrize("right", [True, False])
def test_co_simulation_is_run_beside_the_engines(right, tmp_path):
    """The wrong one has a payload that is a tenth lighter where it couples the links."""
    changes = [] if right else [("mass_3 = 13.614999999999998", "mass_3 = 12.914999999999998")]
    content = version_3("paper-labelled", "analytic:links", tmp_path, True, *changes)
    found = run_beside_engines(content, RIGID + 'level = "links"\n', 0.05, tmp_path)
    assert {finding.about.key.right for finding in found} == {"analytic:links", "pinocchio:links"}
    assert {finding.verdict for finding in found} == {"agree" if right else "differ"}


def test_co_simulation_asks_for_a_run_and_a_level(crosscheck, tmp_path):
    content = version_3("paper-labelled", "analytic:links", tmp_path, True)
    file, names = tmp_path / "stepped.fmu", tmp_path / "map.toml"
    file.write_bytes(content)
    names.write_text(RIGID, encoding="utf-8")
    given = "trial", file, "--coordinates", names, "--run-code"
    assert_one_line(crosscheck(*given), "map.toml: level: must say which rigid level")
    names.write_text(RIGID + 'level = "links"\n', encoding="utf-8")
    assert_one_line(crosscheck(*given), "is run beside the engines: needs --scenario")
    page = crosscheck(*given, "--scenario", "constant-torque", "--out", tmp_path / "o")
    assert_one_line(page, "is run beside the engines: needs --scenario, and has no page")
    given = *given, "--scenario", "constant-torque", "--set", "scenario.duration_s=0.01"
    answer = crosscheck(*given, "--json", tmp_path / "t.json")
    assert (answer.code, "4 of 4 checks agree" in answer.out) == (0, True)
    assert json.loads((tmp_path / "t.json").read_text())["findings"]


def zipped(files: dict[str, bytes]) -> bytes:
    found = io.BytesIO()
    with zipfile.ZipFile(found, "w") as archive_file:
        for name, content in files.items():
            archive_file.writestr(name, content)
    return found.getvalue()


def link() -> bytes:
    found, entry = io.BytesIO(), zipfile.ZipInfo("resources/here")
    entry.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(found, "w") as archive_file:
        archive_file.writestr(DESCRIPTION, b"<x/>")
        archive_file.writestr(entry, "/etc")
    return found.getvalue()


HARMLESS = {DESCRIPTION: b"<fmiModelDescription/>"}


HOSTILE = {
    "no archive": b"PK and then nothing",
    "an empty archive": zipped({}),
    "a path upwards": zipped({**HARMLESS, "../evil.so": b""}),
    "a path from the root": zipped({**HARMLESS, "/tmp/evil.so": b""}),
    "a path in the middle": zipped({**HARMLESS, "resources/../../e": b""}),
    "a path of another system": zipped({**HARMLESS, "..\\evil.dll": b""}),
    "a link": link(),
    "entities": zipped({DESCRIPTION: b'<!DOCTYPE x [<!ENTITY a "aaaa">]><x>&a;</x>'}),
    "an entity alone": zipped({DESCRIPTION: b'<!ENTITY a "a"><x/>'}),
    "a type alone": zipped({DESCRIPTION: b"<!DOCTYPE x><x/>"}),
    "another encoding": zipped({DESCRIPTION: b"<\0x\0/\0>\0"}),
}
DAMAGED = {
    "a file that is a folder too": zipped({**HARMLESS, "resources/a": b"x", "resources/a/b": b"y"}),
    "a name that no file can have": zipped({**HARMLESS, f"resources/{'n' * 300}": b"x"}),
    "a path that no file can have": zipped({**HARMLESS, "resources/" + "d/" * 3000 + "x": b""}),
    "a damaged file": zipped({**HARMLESS, "resources/a": b"sound" * 9}).replace(b"sound", b"other"),
}


@pytest.mark.parametrize("case", HOSTILE | DAMAGED)
def test_a_hostile_or_damaged_archive_is_refused(
    case, tmp_path, monkeypatch, snapshot: SnapshotAssertion
):
    """A hostile one before it is unpacked."""
    monkeypatch.chdir(tmp_path)
    file, folder = Path("unit.fmu"), Path("unpacked")
    file.write_bytes((HOSTILE | DAMAGED)[case])
    folder.mkdir()
    with pytest.raises(InputError) as error:
        unpack_fmu(file, folder)
    assert str(error.value) == snapshot
    assert {path.name for path in tmp_path.iterdir()} == {"unit.fmu", "unpacked"}
    if case in HOSTILE:
        assert not [path for path in folder.rglob("*") if path.name != DESCRIPTION]


def entry_of(name: str, size: int = 1, packed: int | None = None, flags: int = 0):
    """What an archive says of a file in it, without the file."""
    entry = zipfile.ZipInfo(name)
    entry.file_size, entry.flag_bits = size, flags
    entry.compress_size = size if packed is None else packed
    return entry


DESCRIBED = entry_of(DESCRIPTION)
LIMITS = {
    "files": ([entry_of(f"r/{n}") for n in range(10_000)], "holds 10001 files; may hold 10000"),
    "bytes": ([entry_of("r", 499_999_999), entry_of("s")], "would unpack to 500000001 bytes"),
    "ratio": ([entry_of("r", 400_000, 2000), entry_of("s", 400_001, 2000)], "s: is packed 200 tim"),
    "small": ([entry_of("r", 200_000, 1), entry_of("s", 200_001, 1)], "s: is packed 200001 times"),
    "twice": ([entry_of("r/a"), entry_of("r/./a")], "r/./a: is there twice"),
    "secret": ([entry_of("r"), entry_of("s", flags=9)], "s: is encrypted"),
    "colon": ([entry_of("r"), entry_of("c:r")], "c:r: leads out"),
}


@pytest.mark.parametrize("case", LIMITS)
def test_an_archive_is_refused_just_beyond_its_limits(case):
    """Without the last of the files it is harmless."""
    entries, said = LIMITS[case]
    archive._require_harmless("unit.fmu", [DESCRIBED, *entries[:-1]])
    with pytest.raises(InputError, match=re.escape(said)):
        archive._require_harmless("unit.fmu", [DESCRIBED, *entries])


def test_a_description_has_a_size_that_can_be_parsed():
    archive._require_harmless("unit.fmu", [entry_of(DESCRIPTION, 50_000_000)])
    with pytest.raises(InputError, match="has more than 50000000 bytes"):
        archive._require_harmless("unit.fmu", [entry_of(DESCRIPTION, 50_000_001)])


@pytest.mark.parametrize("kind", ["exchange", "co-simulation"])
def test_a_draft_of_a_mapping_takes_states_by_their_order(kind, snapshot: SnapshotAssertion):
    states = "a", 'b "', "v_a", "v_b"
    given = archive.FmuDescription(2, kind, "unit", "1", {}, ("in",), states)
    text = archive.draft_mapping("u.fmu", given)
    assert tomllib.loads(text)["q"] == ["a", 'b "']
    assert text == snapshot


UNUSABLE = {
    "no description": (zipped({DESCRIPTION: b'<fmiModelDescription fmiVersion="2.0"/>'}), RIGID),
    "no XML": (described_as(**{"</ModelVariables>": ""}), RIGID),
    "a reference in words": (described_as(**{'valueReference="1"': 'valueReference="one"'}), RIGID),
    "a reference below 0": (described_as(**{'valueReference="1"': 'valueReference="-1"'}), RIGID),
    "a variable that is not there": (described_as(**{'index="8"': 'index="800"'}), RIGID),
    "another version": (described_as(**{'fmiVersion="2.0"': 'fmiVersion="1.0"'}), RIGID),
    "a long name of its binary": (
        described_as(**{'modelIdentifier="paper': f'modelIdentifier="{"long" * 99}'}),
        RIGID,
    ),
    "no binary": (described_as(), RIGID),
    "another state": (described_as(), RIGID.replace('"theta_2"]', '"theta_3"]')),
    "another input": (described_as(), RIGID.replace("torque_1", "T1")),
    "too few": (described_as(), RIGID.replace('q = ["theta_1", ', "q = [")),
    "too many": (described_as(), RIGID.replace('"theta_2"]', '"theta_2", "v_theta_1"]')),
    "a name twice": (described_as(), RIGID.replace('"theta_1", "theta_2"', '"theta_1", "theta_1"')),
    "no inputs": (described_as(**{'causality="input"': 'causality="local"'}), RIGID),
    "an unknown key": (described_as(), RIGID + "u = 1"),
    "no torques": (described_as(), RIGID.rpartition("torque =")[0]),
}


@pytest.mark.parametrize("case", UNUSABLE)
def test_unusable_unit_is_one_line(refuse, case, snapshot: SnapshotAssertion):
    line = "trial unit.fmu --coordinates map.toml --json t.json --run-code"
    files = zip(("unit.fmu", "map.toml"), UNUSABLE[case], strict=True)
    assert refuse(line, dict(files)) == snapshot


BROKEN = {
    "hangs": ("sleep(1000);", "TooSlow: stopped after"),
    "takes all memory": ("for (;;) memset(malloc(1 << 20), 1, 1 << 20);", "SIGSEGV"),
    "crashes": ("abort();", "SIGABRT"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_unit_that_does_not_come_back_is_one_line(crosscheck, case, tmp_path, monkeypatch):
    work, said = BROKEN[case]
    needs = "#include <math.h>\n#include <stdlib.h>\n#include <string.h>\n#include <unistd.h>"
    changes = ("#include <math.h>", needs), ("double a_theta1 =", f"{work}\n    double a_theta1 =")
    (tmp_path / "unit.fmu").write_bytes(exported("paper-labelled", "analytic:links", *changes))
    if case == "hangs":  # on a busy machine the others may wait for the processor longer than this
        monkeypatch.setattr(cpu_limit, "IDLE_S", 0.5)
        monkeypatch.setattr(cpu_limit, "LOOK_S", 0.1)
    monkeypatch.setattr(unit_module, "UNIT_BYTES", 100_000_000)
    (tmp_path / "map.toml").write_text(RIGID, encoding="utf-8")
    given = "trial", tmp_path / "unit.fmu", "--coordinates", tmp_path / "map.toml", "--run-code"
    assert_one_line(crosscheck(*given), "unit.fmu: does not run: ", said)


def test_an_error_of_a_unit_has_no_traceback(tmp_path):
    unit = {"guid": "", "modelIdentifier": "unit", "unzipDirectory": str(tmp_path)}
    with pytest.raises(Exception, match="Cannot find shared library") as raised:
        fmi2.FMU2Model(**unit, libraryPath=str(tmp_path / "none.so"))
    traceback = raised.value.__traceback__
    assert describe_failure(raised.value.with_traceback(traceback.tb_next)).trace == ""


def test_annotations_of_a_vendor_are_passed_over(crosscheck, tmp_path):
    """As Dymola writes them into every variable, though the schema of FMI 3.0 has none such."""
    note = '<Annotation type="com.3ds.dymola.declarationOrder" order="4"/>'
    plain = 'initial="exact" start="0"/>'
    described = description_3(["theta_1", "theta_2"], steps=False)
    assert plain in described
    noted = plain.replace("/>", f"><Annotations>{note}</Annotations></Float64>")
    content = zipped({DESCRIPTION: described.replace(plain, noted).encode()})
    (tmp_path / "unit.fmu").write_bytes(content)
    answer = crosscheck("trial", "--ask", tmp_path / "unit.fmu", "probe", "--out", tmp_path / "new")
    assert (answer.code, answer.err) == (0, "")
    assert RIGID in (tmp_path / "new" / "map.toml").read_text(encoding="utf-8")
    again = crosscheck("trial", "--ask", tmp_path / "unit.fmu", "--out", tmp_path / "new")
    assert_one_line(again, "map.toml: exists already")


REAL = '<ScalarVariable name="{}" valueReference="{}" causality="{}"><Real {}/></ScalarVariable>'
STATES = ("q1", "q2", "w1", "w2")


def described_2(
    states: dict[str, str], of_derivatives: str, listed: range, torque: str = "tau"
) -> bytes:
    """FMI 2.0: units of states by name; attributes of derivatives, number 1 the first state."""
    size = len(states)
    rows = [REAL.format(name, k, "local", unit) for k, (name, unit) in enumerate(states.items())]
    rows += [
        REAL.format(f"der({name})", size + k, "local", of_derivatives.format(k + 1))
        for k, name in enumerate(states)
    ]
    rows.append(REAL.format(torque, 2 * size, "input", 'start="0"'))
    unknowns = "".join(f'<Unknown index="{number}"/>' for number in listed)
    return (
        '<fmiModelDescription fmiVersion="2.0" modelName="unit" guid="1">'
        '<ModelExchange modelIdentifier="unit"/>'
        f"<ModelVariables>{''.join(rows)}</ModelVariables><ModelStructure>"
        f"<Derivatives>{unknowns}</Derivatives></ModelStructure></fmiModelDescription>"
    ).encode()


def per_second(*names: str) -> dict[str, str]:
    return {name: f'unit="{"rad/s" if name[0] == "w" else "rad"}"' for name in names}


PLAIN = dict.fromkeys(STATES, "")
WITH = 'derivative="{}"'
DRAFTED = {
    "as they must be": described_2(PLAIN, WITH, range(5, 9)),
    "one of them listed twice": described_2(PLAIN, WITH, range(5, 9)).replace(
        b"</Derivatives>", b'<Unknown index="5"/></Derivatives>'
    ),
    "no attribute derivative": described_2(PLAIN, "", range(5, 9)),
    "states listed as derivatives": described_2(PLAIN, WITH, range(1, 5)),
    "each rate behind its state": described_2(
        per_second("q1", "w1", "q2", "w2"), WITH, range(5, 9)
    ),
    "a rate that is the derivative": described_2(
        dict.fromkeys(("q1", "w1", "q2", "w2"), ""), WITH, range(5, 9)
    )
    .replace(b'(q1)" valueReference="4"', b'(q1)" valueReference="1"')
    .replace(b'(q2)" valueReference="6"', b'(q2)" valueReference="3"'),
}


@pytest.mark.parametrize("case", DRAFTED)
def test_draft_states_each_state_once(crosscheck, case, tmp_path):
    (tmp_path / "unit.fmu").write_bytes(zipped({DESCRIPTION: DRAFTED[case]}))
    answer = crosscheck("trial", "--ask", tmp_path / "unit.fmu", "--out", tmp_path / "new")
    assert (answer.code, answer.err) == (0, "")
    draft = tomllib.loads((tmp_path / "new" / "map.toml").read_text(encoding="utf-8"))
    assert (draft["q"], draft["v"]) == (["q1", "q2"], ["w1", "w2"])
    assert draft["torque"] == ["tau"]


ARRAY = "><Dimension start='2'/></Float64>"
PLAIN_2 = described_2(PLAIN, WITH, range(5, 9))
PLAIN_3 = description_3(["a", "b"], steps=False)
OF_STATE = 'variability="continuous" causality="local" initial="exact" start="0"/>'
OF_INPUT = 'variability="continuous" causality="input" start="0"/>'
NO_DRAFT = {
    "derivatives of nothing": described_2(PLAIN, "", range(5, 9)).replace(b"der(", b"rate("),
    "no derivatives": described_2(PLAIN, WITH, range(0)),
    "an odd number of states": described_2(dict.fromkeys(STATES[:3], ""), WITH, range(4, 7)),
    "no input": PLAIN_2.replace(b'"input"', b'"local"'),
    "two states of one name": PLAIN_2.replace(b'name="q2"', b'name="q1"'),
    "an input without a name": described_2(PLAIN, WITH, range(5, 9), torque=""),
    "an array of inputs": PLAIN_3.replace(
        f'"torque_1" valueReference="8" {OF_INPUT}',
        f'"tau" valueReference="8" causality="input" start="0 0"{ARRAY}',
    ).encode(),
    "an array of states": PLAIN_3.replace(
        f'"a" valueReference="0" {OF_STATE}',
        f'"a" valueReference="0" initial="exact" start="0 0"{ARRAY}',
    ).encode(),
}


@pytest.mark.parametrize("case", NO_DRAFT)
def test_draft_without_content_is_not_written(refuse, case, snapshot: SnapshotAssertion):
    files = {"unit.fmu": zipped({DESCRIPTION: NO_DRAFT[case]})}
    assert refuse("trial --ask unit.fmu --out new", files) == snapshot


def test_no_code_of_a_unit_runs_unasked(crosscheck, tmp_path):
    (tmp_path / "unit.fmu").write_bytes(described_as())
    (tmp_path / "map.toml").write_text(RIGID, encoding="utf-8")
    given = "trial", tmp_path / "unit.fmu", "--coordinates", tmp_path / "map.toml"
    assert_one_line(crosscheck(*given), "--run-code: is needed:", "unit.fmu is code")
    assert_one_line(crosscheck(*given[:2]), "--coordinates: is missing", "--out map drafts it")
