"""A table of answers is judged as the functions that made it: the same checks, entries, words."""

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm
from crosscheck.report.trials.output import format_trial_json
from crosscheck.trial.arms import subject as trial_module
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.input.loading import build_equations, load_equations
from crosscheck.trial.result import Trial
from crosscheck.trial.tables.answer_files import _reshape_by_row
from crosscheck.trial.tables.state_requests import (
    TableTrial,
    argument_columns,
    collect_state_request,
)
from crosscheck.trial.trial import run_trial
from tests.loops import require_items
from tests.processes import Command
from tests.schemas import assert_follows
from tests.tool.supplied import TWO_LINK
from tests.tool.test_bad_input import assert_one_line
from tests.trial.other_tools.tables import answers, bound, judge_table, sheets_of, write_csv
from tests.trial.test_dependence import UNLIKE, G, arm_of, bodies_of, pendulum
from tests.trial.test_gravity import SecondForgotten, TwoLinks, WithForce

ROOT = Path(__file__).parents[3]
EXAMPLES = ROOT / "examples"
# sympy_map's coordinates are no linear map; other tools' objects answer a table as functions do.
RIGID = (
    *("plain_functions", "coriolis_matrix", "mass_matrix_alone", "absolute_angles"),
    *("acceleration_alone", "inverse_dynamics_alone"),
)
GEARED = ("geared_lumped", "geared_free")
LUMPED = Coordinates("lumped")


def summarize(trial: Trial) -> dict:
    """All that its JSON says but for where and when it was made, and of the functions' source."""
    found = json.loads(format_trial_json(trial))
    for entry in found["wrong"]:
        del entry["source"]
    del found["agreement"]["provenance"], found["change"], found["search"]
    return found


@pytest.fixture
def few_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """As few as explanations need: more of them would show nothing else here."""
    monkeypatch.setattr(trial_module, "QUICK_STATES", 1)


@pytest.mark.usefixtures("asked_once")
@pytest.mark.parametrize("example", [*RIGID, *GEARED])
def test_judged_as_the_functions_are(example, tmp_path):
    # Geared ones on one arm, single planets on its shoulder, for the sake of time; a table has no
    # symbols.
    arm = load_arm("paper-labelled")
    if example == "geared_free":
        arm = arm.model_copy(update={"joints": arm.joints[:1], "links": arm.links[:1]})
    own = load_equations(f"{EXAMPLES / example}.py:model", arm, None)
    rigid = own.coordinates.gearing == "rigid"
    own = replace(own, symbolic=None) if rigid else replace(own, rebuild=None, any_arm=False)
    table = TableTrial(arm, own.coordinates, own.level, quick=True)
    file = write_csv(tmp_path / "answers.csv", sheets_of(table, own, own.any_arm))
    by_table = judge_table(table, file)
    assert (by_table.exit_code, by_table.diagnosis.entries) == (0, ())
    engines = {finding.right for finding in by_table.agreement.findings}
    assert rigid or {"pinocchio:gears", "exudyn:tree"} <= engines
    if rigid:
        assert summarize(by_table) == summarize(run_trial(table.make_request("yours", own)))


@pytest.mark.slow
@pytest.mark.usefixtures("asked_once")
def test_errors_are_reported_in_the_words_that_functions_get(tmp_path):
    right, wrong = "2 * v[0] * v[1]", "v[0] * v[1]"
    assert right in TWO_LINK
    file = tmp_path / "mine.py"
    file.write_text(TWO_LINK.replace(right, wrong), encoding="utf-8")
    arm = load_arm("paper-labelled")
    own, table = load_equations(f"{file}:two_link", arm, None), TableTrial(arm, quick=True)
    answers = write_csv(tmp_path / "answers.csv", sheets_of(table, own, True))
    direct = summarize(run_trial(table.make_request("yours", own)))
    assert direct["wrong"]
    assert summarize(judge_table(table, answers)) == direct


@pytest.mark.usefixtures("asked_once")
def test_other_units_are_reported(tmp_path):
    in_degrees = tried_changed(lambda v: v | {"force": np.degrees(v["force"])}, tmp_path / "a.csv")
    assert in_degrees.exit_code == 1
    line = "all of force 57.2958 times as large: another unit?"
    assert line in "\n".join(in_degrees.causes)


@pytest.mark.usefixtures("asked_once")
def test_single_precision_has_a_tolerance_of_its_own(tmp_path):
    def rounded(v: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """M's two halves differ by one step of single precision, as sums in another order do."""
        single = {part: values.astype(np.float32) for part, values in v.items()}
        single["mass_matrix"][:, 1, 0] = np.nextafter(single["mass_matrix"][:, 0, 1], np.float32(9))
        return {part: values.astype(float) for part, values in single.items()}

    trial = tried_changed(rounded, tmp_path / "answers.csv")
    assert trial.exit_code == 0
    assert "answers have single precision" in "\n".join(trial.scope)
    # A thousandth is no rounding of any file.
    off = tried_changed(lambda v: rounded(v | {"force": 1.001 * v["force"]}), tmp_path / "off.csv")
    assert {wrong.place.part for wrong in off.diagnosis.entries} == {"force"}


@pytest.mark.usefixtures("asked_once")
def test_seven_digits_are_fewer_than_a_double_has_and_no_single_precision(tmp_path):
    cut = np.vectorize(lambda value: float(f"{value:.7g}"))
    trial = tried_changed(lambda v: {p: cut(a) for p, a in v.items()}, tmp_path / "answers.csv")
    assert "answers have fewer digits than a double has" in "\n".join(trial.scope)


def test_columns_of_coordinates_in_any_order_have_their_own_units(snapshot: SnapshotAssertion):
    arm = load_arm("probe")
    coordinates = replace(LUMPED, order=build_frame(LUMPED, arm).names[::-1])
    columns = argument_columns(build_frame(coordinates, arm), coordinates, arm)
    assert {name: columns[name] for name in ("x", "v", "a")} == snapshot


def tried_changed(change: Callable[..., dict[str, np.ndarray]], file: Path) -> Trial:
    """The trial of right answers with a change; every row is answered."""
    arm = load_arm("paper-labelled")
    own = load_equations(f"{EXAMPLES / 'plain_functions'}.py:model", arm, None)
    table = TableTrial(arm, quick=True)
    sheet = collect_state_request(table)
    values = change(answers(bound(own, arm), sheet, everywhere=True))
    write_csv(file, [(sheet, values)])
    return judge_table(table, file)


DECLARED = """\
void {prefix}_mass_matrix(const double *q, double *M);
void {prefix}_bias(const double *q, const double *v, double *bias);
void {prefix}_force(double t, const double *q, const double *v, const double *torque,
                    double *force);
"""
CALLED = """\
    {prefix}_mass_matrix(q, M);
    {prefix}_bias(q, v, bias);
    {prefix}_force(t, q, v, torque, force);
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc here")
@pytest.mark.usefixtures("few_states")
def test_exported_c_in_the_template_of_c_agrees_in_both_rounds(crosscheck, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = "paper-labelled", "--quick"
    assert crosscheck("trial", "--ask", *options, "--out", "ask").code == 0
    first = answered_by_c(crosscheck, "paper-labelled", "ask", "states")
    again = "--after", first, "--out", "ask-2"
    assert crosscheck("trial", "--ask", *options, *again).code == 0
    more = [
        answered_by_c(crosscheck, f"ask-2/probe-{k}.toml", "ask-2", f"probe-{k}-states")
        for k in (1, 2)
    ]
    files = [word for file in (first, *more) for word in ("--answers", file)]
    reason = "is missing; no file has answers to the states of probe 2 of paper-labelled"
    assert_one_line(crosscheck("trial", *options, *files[:-2]), "--answers: M of rows ", reason)
    answer = crosscheck("trial", *options, *files, "--json", "trial.json")
    assert (answer.code, answer.err.count("Traceback")) == (0, 0)
    assert answer.out.startswith(f"{first} on paper-labelled agrees with coupled")
    assert "also on 2 other arms, to catch errors" in answer.out
    assert_follows(json.loads(Path("trial.json").read_text()), "trial")


def answered_by_c(crosscheck: Command, arm: str, folder: str, stem: str) -> str:
    """The answers' file of what an exported model says, called from the template."""
    model = Path(f"{stem}.c")
    exported = crosscheck("export", arm, "--model", "analytic:coupled", "--out", model)
    assert exported.code == 0
    prefix = re.search(r"void (\w+)_mass_matrix", model.read_text())[1]
    (template,) = Path(folder).glob("answers.c" if stem == "states" else f"answers_{stem[6]}.c")
    text = template.read_text()
    assert f"< {stem}.csv > {template.stem}.csv" in text
    unused = re.search(r"    \(void\)t, .*\n", text)[0]
    text = text.replace(unused, CALLED.format(prefix=prefix))
    source = Path(f"{stem}-answers.c")
    source.write_text(text.replace("/* Your", DECLARED.format(prefix=prefix) + "/* Your"))
    subprocess.run(["gcc", "-std=c11", "-O1", "-o", stem, source, model, "-lm"], check=True)
    states = (Path(folder) / f"{stem}.csv").read_bytes()
    answers = subprocess.run([f"./{stem}"], input=states, capture_output=True, check=True).stdout
    Path(f"{stem}-answers.csv").write_bytes(answers)
    return f"{stem}-answers.csv"


@pytest.mark.parametrize("source", [TwoLinks, WithForce, SecondForgotten])
def test_gravity_is_answered_apart_from_the_force(source, tmp_path):
    """M, C and g in a table, without a force or with one that has no weights."""
    arm = arm_of(*UNLIKE)
    own = build_equations(source, arm, None, "yours")
    table = TableTrial(arm, quick=True)
    file = write_csv(tmp_path / "answers.csv", sheets_of(table, own, False))
    by_table = judge_table(table, file)
    assert by_table.exit_code == (source is SecondForgotten)
    wrong = [(each.place.part, each.place.row) for each in by_table.diagnosis.entries]
    assert wrong == [("gravity", 1)] * (source is SecondForgotten)


def in_letters(arm: Arm) -> Equations:
    """M, bias and gravity of an arm that hangs along x, with its numbers."""
    own = pendulum(bodies_of(arm), arm.gravity_m_per_s2[0], arm.payload_mass_kg, driven=False)
    return replace(own, force=None, gravity=lambda q: -own.force(q))


@pytest.mark.parametrize(
    "numbers",
    [
        pytest.param({"payload": 0.0}, id="no payload"),
        pytest.param({"payload": 0.44}, id="another payload"),
        pytest.param({"g": 9.18}, id="digits of g exchanged"),
        pytest.param(
            {"first": (0.9, 0.5, 0.23, 0.03), "second": (1.3, 0.4, 0.17, 0.012)},
            id="masses exchanged",
        ),
        pytest.param({"second": (0.9, 0.4, 0.18, 0.012)}, id="another centre"),
    ],
)
def test_another_number_of_the_file_explains_a_table(numbers, tmp_path, snapshot):
    """One number, or two that are exchanged, at every state of M, bias and gravity."""
    first, second = UNLIKE
    arm = arm_of(first, second, payload=0.4)
    bodies = numbers.get("first", first), numbers.get("second", second)
    other = arm_of(*bodies, payload=numbers.get("payload", 0.4))
    other = other.model_copy(update={"gravity_m_per_s2": (numbers.get("g", G), 0.0)})
    table = TableTrial(arm, quick=True)
    file = write_csv(tmp_path / "answers.csv", sheets_of(table, in_letters(other), False))
    trial = judge_table(table, file)
    assert trial.causes == snapshot
    # Its answers come from no function of the user's, and every entry has the same cause.
    assert set(trial.sources.values()) == {None}
    assert len({each.cause for each in trial.wrong}) == 1


def test_a_bias_that_is_right_at_unit_rates_alone_is_wrong(tmp_path):
    arm = arm_of(*UNLIKE)
    right = in_letters(arm)

    def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.add(right.bias(q, v), (0.02 * v[1] * (1 - v[1]), 0.0))

    table = TableTrial(arm, quick=True)
    file = write_csv(tmp_path / "a.csv", sheets_of(table, replace(right, bias=bias), False))
    trial = judge_table(table, file)
    assert [each.name for each in trial.wrong] == ["bias[theta_1]"]
    assert list(trial.relative_errors) == ["mass_matrix", "gravity", "bias"]
    assert trial.verdict.text.startswith("bias[theta_1] is wrong")


def test_a_term_at_another_product_of_rates_is_named(tmp_path):
    arm = arm_of(*UNLIKE)
    right = in_letters(arm)

    def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        first, second = right.bias(q, v)
        return np.array([first, second * v[1] / v[0] if v[0] else 0.0])

    table = TableTrial(arm, quick=True)
    file = write_csv(tmp_path / "a.csv", sheets_of(table, replace(right, bias=bias), False))
    words = "yours has theta_1' theta_2' where theta_1'^2 belongs"
    wrong = judge_table(table, file).diagnosis.entries
    assert [each.notes for each in wrong] == [(words,), (words,)]


@pytest.mark.parametrize("name", ["paper-labelled", "sliding"])
def test_modelica_reads_arrays_of_the_sizes_that_the_file_has(name, crosscheck, tmp_path):
    assert crosscheck("trial", "--ask", name, "--out", tmp_path / "ask").code == 0
    text = (tmp_path / "ask" / "answers.mos").read_text(encoding="utf-8")
    written = loadmat(tmp_path / "ask" / "states.mat")
    (count,) = re.findall(r"Integer count = (\d+);", text)
    reads = re.findall(r'readRealMatrix\(file, \\"(\w+)\\", count, (\d+)\)', text)
    for array, columns in require_items(reads):
        assert written[array].shape == (int(count), int(columns)), array


def test_matrices_are_read_whether_states_come_first_or_last():
    rows = np.arange(18.0).reshape(2, 3, 3)
    for stacked in (rows, rows.transpose(1, 2, 0)):
        read = _reshape_by_row("made.mat", "coriolis", stacked, 2, 3, 3)
        np.testing.assert_array_equal(read, rows.reshape(2, 9))
