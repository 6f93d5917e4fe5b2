"""FMUs on trial: right ones agree, a wrong one has its entry named, hostile ones are refused."""

from __future__ import annotations

import io
import shutil
import stat
import subprocess
import zipfile
from pathlib import Path

import pytest

from analytic.kernel.export import c_text
from analytic.kernel.fmu import fmu_sources
from crosscheck.cli.export import fmu_file, model_of, prefix_of
from crosscheck.trial import trial as trial_module
from crosscheck.trial.fmu.archive import DESCRIPTION, unpacked
from crosscheck.trial.fmu.equations import fmu_equations
from crosscheck.trial.input.naming import named
from crosscheck.trial.trial import Asked, Trial, tried
from models.errors import InputError
from models.loading import load_arm
from tests.tool.conftest import crosscheck
from tests.tool.test_bad_input import assert_one_line

__all__ = ["crosscheck"]  # a fixture
COMPILER = shutil.which("gcc")
fmi3 = pytest.importorskip("fmpy.fmi3", reason="no FMPy here")
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


def exported(arm: str, name: str, *changes: tuple[str, str]) -> bytes:
    """The program's own FMU of a model, its C changed before it is compiled."""
    model = model_of(arm, name, [])
    text, prefix = c_text(model.term_equations, prefix_of(model), "a model"), prefix_of(model)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return fmu_file(model, text, prefix)


def judged(content: bytes, mapping: str, arm: str, folder: Path) -> Trial:
    file, names, into = folder / "unit.fmu", folder / "map.toml", folder / "unpacked"
    file.write_bytes(content)
    names.write_text(mapping, encoding="utf-8")
    into.mkdir()
    own = load_arm(arm)
    return tried(Asked("unit.fmu", fmu_equations(file, names, own, into), own, quick=True))


@pytest.mark.parametrize(
    ("arm", "model", "mapping", "level"),
    [
        ("paper-labelled", "analytic:coupled", RIGID, "coupled"),
        ("probe", "analytic:physical", GEARED, ""),
    ],
)
def test_right_models_are_not_blamed(arm, model, mapping, level, tmp_path):
    trial = judged(exported(arm, model), mapping, arm, tmp_path)
    assert (trial.exit_code, trial.wrong, trial.level) == (0, (), level)


def test_entry_of_a_wrong_model_is_named(tmp_path):
    """The payload at the second link's centre of mass, beside the diagonal of M."""
    coupling = [(f"mass_{k} = 13.614999999999998", f"mass_{k} = 10.115") for k in (3, 5)]
    content = exported("paper-labelled", "analytic:links", *coupling)
    trial = judged(content, RIGID, "paper-labelled", tmp_path)
    inertia = [wrong for wrong in trial.wrong if wrong.place.part == "mass_matrix"]
    entries = {named(wrong.place, trial.bench.frame.names) for wrong in inertia}
    assert entries == {"M[theta_1, theta_2]", "M[theta_2, theta_1]"}
    told = {
        slip.right for wrong in inertia if wrong.explanation for slip in wrong.explanation.slips
    }
    assert trial.level == "links"
    assert told == {"L2"}


def test_unit_that_crashes_costs_its_own_checks(tmp_path):
    crash = ("double a_theta1 =", "abort();\n    double a_theta1 =")
    content = exported(
        "paper-labelled",
        "analytic:links",
        crash,
        ("#include <math.h>", "#include <math.h>\n#include <stdlib.h>"),
    )
    trial = judged(content, RIGID, "paper-labelled", tmp_path)
    assert {finding.verdict for finding in trial.agreement.checks} == {"failed"}


VERSION_3 = """
#include <stddef.h>
#include <stdlib.h>
typedef struct { double t, state[2 * N], torque[JOINTS]; } Unit;
void *fmi3InstantiateModelExchange(const char *name, const char *token) {
    return calloc(1, sizeof(Unit));
}
void fmi3FreeInstance(void *c) { free(c); }
const char *fmi3GetVersion(void) { return "3.0"; }
int fmi3EnterInitializationMode(void *c) { return 0; }
int fmi3ExitInitializationMode(void *c) { return 0; }
int fmi3EnterContinuousTimeMode(void *c) { return 0; }
int fmi3UpdateDiscreteStates(void *c, _Bool *a, _Bool *b, _Bool *d, _Bool *e, _Bool *f, double *t) {
    *a = *b = *d = *e = *f = 0, *t = 0;
    return 0;
}
int fmi3SetTime(void *c, double t) { ((Unit *)c)->t = t; return 0; }
int fmi3SetFloat64(void *c, const unsigned *r, size_t n, const double *x, size_t m) {
    for (size_t k = 0; k < n; k++) ((Unit *)c)->torque[r[k] - 4 * N] = x[k];
    return 0;
}
int fmi3SetContinuousStates(void *c, const double *x, size_t n) {
    memcpy(((Unit *)c)->state, x, 8 * n);
    return 0;
}
int fmi3GetContinuousStates(void *c, double *x, size_t n) {
    memcpy(x, ((Unit *)c)->state, 8 * n);
    return 0;
}
int fmi3GetContinuousStateDerivatives(void *c, double *x, size_t n) {
    Unit *u = c;
    memcpy(x, u->state + N, 8 * N);
    PREFIX_acceleration(u->t, u->state, u->state + N, u->torque, x + N);
    return 0;
}
"""


def version_3(arm: str, name: str, folder: Path) -> bytes:
    """A unit of FMI 3.0 around the exported C; what nobody calls returns an error."""
    model = model_of(arm, name, [])
    prefix, n = prefix_of(model), len(model.layout)
    code = c_text(model.term_equations, prefix, "a model") + VERSION_3.replace("PREFIX", prefix)
    unused = [
        name for name in dir(fmi3.FMU3Model) if name.startswith("fmi3") and f"{name}(" not in code
    ]
    code += "".join(f"int {name}(void) {{ return 3; }}\n" for name in unused)
    source, library = folder / "unit.c", folder / "unit.so"
    source.write_text(code, encoding="utf-8")
    subprocess.run(
        [str(COMPILER), "-O1", "-fPIC", "-shared", "-o", library, source, "-lm"], check=True
    )
    names = [*model.layout.names, *(f"v_{each}" for each in model.layout.names)]
    real = '<Float64 name="{}" valueReference="{}" variability="continuous" {}/>'
    rows = [
        real.format(each, k, 'causality="local" initial="exact" start="0"')
        for k, each in enumerate(names)
    ]
    rows += [
        real.format(f"der({each})", 2 * n + k, f'causality="local" derivative="{k}"')
        for k, each in enumerate(names)
    ]
    rows += [
        real.format(f"torque_{j + 1}", 4 * n + j, 'causality="input" start="0"') for j in range(2)
    ]
    rows += [
        '<Float64 name="time" valueReference="999" variability="continuous"'
        ' causality="independent"/>'
    ]
    unknowns = [f'<ContinuousStateDerivative valueReference="{2 * n + k}"/>' for k in range(2 * n)]
    initial = [f'<InitialUnknown valueReference="{2 * n + k}"/>' for k in range(2 * n)]
    text = (
        '<fmiModelDescription fmiVersion="3.0" modelName="unit" instantiationToken="{1}">'
        '<ModelExchange modelIdentifier="unit"/>'
        f"<ModelVariables>{''.join(rows)}</ModelVariables>"
        f"<ModelStructure>{''.join(unknowns + initial)}</ModelStructure></fmiModelDescription>"
    )
    return zipped(
        {DESCRIPTION: text.encode(), "binaries/x86_64-linux/unit.so": library.read_bytes()}
    )


def test_version_3_agrees_too(tmp_path):
    content = version_3("paper-labelled", "analytic:coupled", tmp_path)
    trial = judged(content, RIGID, "paper-labelled", tmp_path)
    assert (trial.exit_code, trial.wrong, trial.level) == (0, (), "coupled")


def zipped(files: dict[str, bytes], packed: int = zipfile.ZIP_STORED) -> bytes:
    found = io.BytesIO()
    with zipfile.ZipFile(found, "w", packed) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return found.getvalue()


def link() -> bytes:
    found, entry = io.BytesIO(), zipfile.ZipInfo("resources/here")
    entry.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(found, "w") as archive:
        archive.writestr(DESCRIPTION, b"<x/>")
        archive.writestr(entry, "/etc")
    return found.getvalue()


HARMLESS = {DESCRIPTION: b"<fmiModelDescription/>"}
HOSTILE = {
    "no archive": (b"PK and then nothing", "is no FMU"),
    "an empty archive": (zipped({}), "modelDescription.xml: is missing: this is no FMU"),
    "a path upwards": (
        zipped({**HARMLESS, "../evil.so": b""}),
        "../evil.so: leads out of the folder",
    ),
    "a path from the root": (zipped({**HARMLESS, "/tmp/evil.so": b""}), "leads out of the folder"),
    "a path in the middle": (zipped({**HARMLESS, "resources/../../e": b""}), "leads out of the"),
    "a path of another system": (
        zipped({**HARMLESS, "..\\evil.dll": b""}),
        "leads out of the folder",
    ),
    "a link": (link(), "resources/here: is a link"),
    "a bomb": (
        zipped({**HARMLESS, "resources/zeros": bytes(30_000_000)}, zipfile.ZIP_DEFLATED),
        "resources/zeros: is packed",
    ),
    "many files": (zipped({f"resources/{k}": b"" for k in range(10_001)}), "may hold 10000"),
    "entities": (
        zipped({DESCRIPTION: b'<!DOCTYPE x [<!ENTITY a "aaaa">]><x>&a;</x>'}),
        "must be XML in UTF-8 without definitions of its own",
    ),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_archive_is_refused_before_it_is_unpacked(case, tmp_path):
    content, fragment = HOSTILE[case]
    file, folder = tmp_path / "unit.fmu", tmp_path / "unpacked"
    file.write_bytes(content)
    folder.mkdir()
    with pytest.raises(InputError) as error:
        unpacked(file, folder)
    assert fragment in str(error.value)
    assert not [path for path in folder.rglob("*") if path.name != DESCRIPTION]
    assert {path.name for path in tmp_path.iterdir()} == {"unit.fmu", "unpacked"}


def described_as(**words: str) -> bytes:
    """The program's own unit, words of its description changed, without binaries."""
    model = model_of("paper-labelled", "analytic:links", [])
    text, prefix = c_text(model.term_equations, prefix_of(model), "a model"), prefix_of(model)
    description = fmu_sources(text, prefix, model.layout, 2)[1]
    for old, new in words.items():
        assert old in description
        description = description.replace(old, new)
    return zipped({DESCRIPTION: description.encode()})


UNUSABLE = {
    "no description": (
        zipped({DESCRIPTION: b'<fmiModelDescription fmiVersion="2.0"/>'}),
        RIGID,
        "is no model description",
    ),
    "another version": (
        described_as(**{'fmiVersion="2.0"': 'fmiVersion="1.0"'}),
        RIGID,
        "must be 2.0 or 3.0",
    ),
    "Co-Simulation alone": (
        described_as(ModelExchange="CoSimulation"),
        RIGID,
        "Co-Simulation alone",
    ),
    "no binary": (described_as(), RIGID, "binaries: holds none of paper_labelled for"),
    "another state": (
        described_as(),
        RIGID.replace('"theta_2"]', '"theta_3"]'),
        "q = 'theta_3': is no continuous state; there are theta_1, theta_2",
    ),
    "another input": (described_as(), RIGID.replace("torque_1", "T1"), "is no real input"),
    "too few": (described_as(), RIGID.replace('q = ["theta_1", ', "q = ["), "must be 2 names"),
    "an unknown key": (described_as(), RIGID + "u = 1", "unknown key"),
    "no torques": (described_as(), RIGID.rpartition("torque =")[0], "torque: is missing"),
}


@pytest.mark.parametrize("case", UNUSABLE)
def test_unusable_unit_is_one_line(crosscheck, case, tmp_path):
    content, mapping, fragment = UNUSABLE[case]
    (tmp_path / "unit.fmu").write_bytes(content)
    (tmp_path / "map.toml").write_text(mapping, encoding="utf-8")
    options = ["--coordinates", tmp_path / "map.toml", "--json", tmp_path / "t.json"]
    answer = crosscheck("trial", tmp_path / "unit.fmu", *options, "--run-code")
    assert_one_line(answer, fragment)
    assert {path.name for path in tmp_path.iterdir()} == {"unit.fmu", "map.toml"}


def test_no_code_of_a_unit_runs_unasked(crosscheck, tmp_path):
    (tmp_path / "unit.fmu").write_bytes(described_as())
    (tmp_path / "map.toml").write_text(RIGID, encoding="utf-8")
    given = "trial", tmp_path / "unit.fmu", "--coordinates", tmp_path / "map.toml"
    assert_one_line(crosscheck(*given), "--run-code: is needed:", "unit.fmu is code")
    assert_one_line(crosscheck(*given[:2]), "--coordinates: is missing", "--ask drafts it")


def test_draft_of_a_mapping_is_read_back(crosscheck, tmp_path):
    (tmp_path / "unit.fmu").write_bytes(described_as())
    answer = crosscheck("trial", "--ask", tmp_path / "unit.fmu", "--out", tmp_path / "new")
    assert (answer.code, answer.err) == (0, "")
    text = (tmp_path / "new" / "map.toml").read_text(encoding="utf-8")
    assert RIGID in text
    again = crosscheck("trial", "--ask", tmp_path / "unit.fmu", "--out", tmp_path / "new")
    assert_one_line(again, "map.toml: exists already")
