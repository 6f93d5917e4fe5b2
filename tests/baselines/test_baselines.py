"""Recorded baselines: what a repetition may differ by, and what it may not."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import analytic.model
from crosscheck import cli, validate
from crosscheck.baseline import arm_digest, baseline_path, read_baseline, write_baseline
from crosscheck.comparison import Comparison, Results, findings_of, tasks_of
from crosscheck.findings import About, Agreement, Finding, Key, measured_only
from crosscheck.plan import Experiment
from crosscheck.provenance import provenance
from crosscheck.reduction import WIDEST, baseline_of
from crosscheck.registry import MODELS
from crosscheck.regression import changed_since, compare
from crosscheck.run import CrossCheck, runs_of
from crosscheck.run_suite import experiment_comparisons
from crosscheck.tasks import Failure, RunKey, Simulation
from crosscheck.workers import perform_all
from models.arm import Arm
from models.errors import InputError
from models.loading import Case, load_arm, load_scenario
from models.switches import switches

COMMITTED = Path(__file__).parents[2] / "baselines"
DURATION_S = 0.02  # PD: impact of the start, mesh vibration, its decay
ANALYTIC, EXUDYN = RunKey("pd", "analytic:physical"), RunKey("pd", "exudyn:tree")
NUDGED = RunKey("pd", "analytic:physical", "nudged")
RENEW = "crosscheck baseline accept paper-labelled --quick"


def short_check(arm: Arm, only: RunKey | None = None) -> CrossCheck:
    """A cross-check of one short experiment: real engines, real checks; or one run of it."""
    scenario = load_scenario("pd").model_copy(update={"duration_s": DURATION_S})
    experiment = Experiment("pd", Case(arm, scenario, switches()))
    planned = [c for c in experiment_comparisons(experiment) if _is_wanted(c, only)]
    results = Results(perform_all(tasks_of(planned), 1, lambda key: None))
    findings = list(findings_of(planned, results))
    return CrossCheck(arm, Agreement(findings, provenance(arm, 0, True)), runs_of(results))


def _is_wanted(comparison: Comparison, only: RunKey | None) -> bool:
    """The geared models and one rigid level; or what needs one run alone."""
    keys = [task.key for task in comparison.needs if isinstance(task, Simulation)]
    if only is not None:
        return keys == [only]
    levels = [key for key in keys if MODELS[key.model].role == "rigid"]
    return all(key.model.endswith("coupled") for key in levels)


@pytest.fixture(scope="module")
def result(labelled: Arm) -> CrossCheck:
    """What is recorded here."""
    return short_check(labelled)


@pytest.fixture
def recorded(result: CrossCheck, labelled: Arm, tmp_path: Path) -> Path:
    """A baseline file of it, alone in a folder."""
    path = baseline_path(tmp_path, labelled, quick=True)
    write_baseline(path, baseline_of(result))
    return path


def held_against(path: Path, result: CrossCheck) -> Agreement:
    """The comparison of a recorded file with a result."""
    return compare(read_baseline(path, load_arm("paper-labelled"), RENEW), result)


def edited(path: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """Change the record by hand."""
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(data), encoding="utf-8")


def with_run(result: CrossCheck, key: RunKey, run: Any) -> CrossCheck:
    """The result with another run in the place of one."""
    return replace(result, runs={**result.runs, key: run})


def with_findings(result: CrossCheck, findings: list[Finding]) -> CrossCheck:
    """The result with other Findings."""
    return replace(result, agreement=Agreement(findings, result.agreement.provenance))


def moved(agreement: Agreement) -> dict[str, Finding]:
    """Red Findings by id."""
    return {finding.id: finding for finding in agreement.red}


# What stands


def test_a_record_read_back_is_the_record(result: CrossCheck, recorded: Path) -> None:
    baseline = baseline_of(result)
    assert read_baseline(recorded, result.arm, RENEW) == baseline
    before = recorded.read_bytes()
    write_baseline(recorded, baseline)
    assert recorded.read_bytes() == before


def test_a_repetition_does_not_move(result: CrossCheck, recorded: Path) -> None:
    agreement = held_against(recorded, short_check(result.arm))
    assert agreement.exit_code == 0
    assert len(agreement.checks) == len(agreement.findings) > 40
    assert changed_since(agreement) == []


@pytest.mark.parametrize("stand_in", [EXUDYN, NUDGED], ids=str)
def test_rounding_of_another_kind_does_not_move(
    result: CrossCheck, recorded: Path, stand_in: RunKey
) -> None:
    """Another implementation of the same steps rounds as differently as any machine could."""
    run = result.runs[stand_in].assign_attrs(result.runs[ANALYTIC].attrs)
    agreement = held_against(recorded, with_run(result, ANALYTIC, run))
    assert agreement.exit_code == 0
    assert any(f.measured for f in agreement.checks if f.id.startswith(f"recorded-run/{ANALYTIC}/"))


def test_numbers_have_17_digits_and_one_row_each(recorded: Path) -> None:
    lines = recorded.read_text(encoding="utf-8").splitlines()
    longest = max(len(line) for line in lines if "basis" not in line and "title" not in line)
    assert longest <= 110
    sampled = json.loads("\n".join(lines))["runs"][str(ANALYTIC)]["sampled"]["theta"]["samples"]
    last = f"[{DURATION_S!r}, {sampled[-1][1]:.16e}, {sampled[-1][2]:.16e}]"
    assert last in [line.strip() for line in lines]


# What moves


def _scaled(arm: Arm, place: str, field: str) -> Arm:
    """The arm with one parameter of its first joint or link a millionth larger."""
    data = arm.model_dump()
    data[place][0][field] *= 1 + 1e-6
    return Arm.model_validate(data)


# Not the shoulder's carrier: it holds 0.04 of the 92 kg m^2 about it, and its millionth comes to
# 2e-12 rad in so short a run.
@pytest.mark.parametrize(
    ("place", "field"),
    [
        ("joints", "backlash_m"),
        ("joints", "mesh_stiffness_N_per_m"),
        ("joints", "tooth_error_m"),
        ("joints", "damping_ratio"),
        ("joints", "sun_equivalent_mass_kg"),
        ("joints", "planet_equivalent_mass_kg"),
        ("links", "length_m"),
        ("links", "com_m"),
        ("links", "density_kg_per_m3"),
    ],
)
@pytest.mark.parametrize("key", [ANALYTIC, EXUDYN], ids=str)
def test_a_millionth_of_a_parameter_moves_a_run(
    result: CrossCheck, recorded: Path, key: RunKey, place: str, field: str
) -> None:
    other = short_check(_scaled(result.arm, place, field), only=key).runs[key]
    changes = moved(held_against(recorded, with_run(result, key, other)))
    assert changes
    assert {finding.verdict for finding in changes.values()} == {"differ"}
    assert all(name.startswith(f"recorded-run/{key}/") for name in changes)


def test_a_millionth_of_the_payload_moves_the_rigid_arm(result: CrossCheck, recorded: Path) -> None:
    key = RunKey("pd", "pinocchio:coupled")
    heavier = result.arm.model_copy(update={"payload_mass_kg": 10.0 * (1 + 1e-6)})
    other = short_check(heavier, only=key).runs[key]
    agreement = held_against(recorded, with_run(result, key, other))
    assert f"recorded-run/{key}/theta_dot" in moved(agreement)


def test_a_planted_fault_moves(
    result: CrossCheck, recorded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The ring mesh at the sun's rate of Eq. 13: 27 cycles per turn for 99."""
    right = analytic.model.gears

    def wrong(*given: Any) -> Any:
        gears = right(*given)
        rate = gears.rate.copy()
        rate[1::2] *= 27 / 99
        return gears._replace(rate=rate)

    monkeypatch.setattr(analytic.model, "gears", wrong)
    changes = moved(held_against(recorded, short_check(result.arm)))
    assert f"recorded-run/{ANALYTIC}/x_pr" in changes
    worse = changes["recorded-verdict/same-step/pd/x_pr/analytic:physical~exudyn:tree"]
    assert worse.note.startswith("worse: agree -> differ")
    assert not any(str(EXUDYN) in name for name in changes)


@pytest.mark.parametrize(("by", "verdict"), [(0.9e-10, "agree"), (2e-10, "differ")])
def test_a_number_moves_beyond_its_tolerance(
    result: CrossCheck, recorded: Path, by: float, verdict: str
) -> None:
    def change(data: dict[str, Any]) -> None:
        data["runs"][str(ANALYTIC)]["sampled"]["theta"]["samples"][7][2] += by

    edited(recorded, change)
    agreement = held_against(recorded, result)
    finding = next(f for f in agreement.checks if f.id == f"recorded-run/{ANALYTIC}/theta")
    assert finding.verdict == verdict
    assert finding.measured == pytest.approx(by, rel=1e-5)
    assert finding.note.startswith("joint 2 at 0.007 s: ")
    assert len(agreement.red) == (verdict == "differ")


def test_a_measurement_moves(result: CrossCheck, recorded: Path) -> None:
    name = next(f.id for f in result.agreement.findings if f.id.startswith("deviation/pd/tip"))

    def change(data: dict[str, Any]) -> None:
        data["measurements"][name]["measured"] *= 1.01

    edited(recorded, change)
    assert list(moved(held_against(recorded, result))) == [f"recorded-measurement/{name}"]


def test_checks_and_measurements_appear_and_disappear(result: CrossCheck, recorded: Path) -> None:
    first, *rest = result.agreement.checks
    new = measured_only(About(Key("deviation", "new", "x", "a"), "m", ""), measured=1.0)
    check = replace(first, about=About(Key("new", "pd", "check", "a"), "m", ""))
    measurements = [f for f in result.agreement.findings if f.kind == "measurement"]
    other = with_findings(result, [*rest, check, *measurements[1:], new])
    notes = {name: finding.note for name, finding in moved(held_against(recorded, other)).items()}
    assert notes == {
        f"recorded-verdict/{first.id}": "disappeared; was agree",
        "recorded-verdict/new/pd/check/a": "appeared: agree, nothing on record",
        f"recorded-measurement/{measurements[0].id}": "disappeared",
        "recorded-measurement/deviation/new/x/a": "appeared: nothing on record",
    }


def test_a_run_that_fails_has_disappeared(result: CrossCheck, recorded: Path) -> None:
    broken = with_run(result, EXUDYN, Failure("Diverged", "at t = 0.01 s"))
    notes = [finding.note for finding in moved(held_against(recorded, broken)).values()]
    assert notes == ["disappeared: Diverged: at t = 0.01 s"]


def test_other_settings_are_named_and_not_compared(result: CrossCheck, recorded: Path) -> None:
    def change(data: dict[str, Any]) -> None:
        data["runs"][str(ANALYTIC)]["scenario"]["step_s"] = 2e-5

    edited(recorded, change)
    changes = moved(held_against(recorded, result))
    assert list(changes) == [f"recorded-run/{ANALYTIC}/settings"]
    assert "scenario.step_s 2e-05 -> 1e-05" in changes[f"recorded-run/{ANALYTIC}/settings"].note


def test_what_else_changed_is_named(result: CrossCheck, recorded: Path) -> None:
    def change(data: dict[str, Any]) -> None:
        data["provenance"]["versions"]["exudyn"] = "1.0"
        data["provenance"]["lock_sha256"] = 64 * "0"

    edited(recorded, change)
    changed = changed_since(held_against(recorded, result))
    assert [line.split(" -> ")[0] for line in changed] == ["exudyn 1.0", "lock_sha256 000000000000"]


def test_without_a_meaningful_tolerance_nothing_is_compared(result: CrossCheck) -> None:
    """A start that one ulp decides: the run is recorded, the numbers are not held against it."""
    wild = result.runs[NUDGED]
    wild = with_run(result, NUDGED, wild.assign(x_sp=wild["x_sp"] + 1e-5))
    sampled = baseline_of(wild).runs[str(ANALYTIC)].sampled
    assert sampled["x_sp"].tolerance is None
    assert sampled["x_sp"].basis.startswith("not compared: 1000 x what one ulp")
    assert sampled["theta"].tolerance == 1e-10


# The command


@pytest.fixture
def command(
    result: CrossCheck, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Callable[..., int]]:
    """``crosscheck ...`` in an empty folder, on the short experiment."""
    monkeypatch.setattr(validate, "cross_check", lambda arm, **options: result)
    monkeypatch.chdir(tmp_path)

    def call(*words: str) -> int:
        monkeypatch.setattr(sys, "argv", ["crosscheck", *words])
        with pytest.raises(SystemExit) as exit_:
            cli.main()
        return int(str(exit_.value.code))

    return call


def test_accept_then_check(
    command: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command("baseline", "accept", "--quick") == 0
    assert command("baseline", "check", "--quick", "--junit", "out/check.xml") == 0
    assert "recorded results moved" in capsys.readouterr().out
    assert (tmp_path / "out" / "check.xml").is_file()

    def change(data: dict[str, Any]) -> None:
        data["runs"][str(ANALYTIC)]["extremes"]["F_sp"]["extremes"][0][3] += 1.0

    edited(tmp_path / "baselines" / "paper-labelled-quick.json", change)
    assert command("baseline", "check", "--quick") == 1
    assert "1 of" in capsys.readouterr().out


def test_validate_writes_what_it_is_asked_to(command: Callable[..., int], tmp_path: Path) -> None:
    assert command("validate", "--quick", "--json", "a.json", "--junit", "a.xml") == 0
    assert json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["schema_version"] == 2
    assert (tmp_path / "a.xml").is_file()


def _garble(data: dict[str, Any]) -> None:
    data["runs"][str(ANALYTIC)]["sampled"]["theta"]["samples"][3] = [0.1, "fast", 0.2]


def _shorten(data: dict[str, Any]) -> None:
    data["runs"][str(ANALYTIC)]["sampled"]["theta"]["samples"][3] = [0.1, 0.2]


def _other_arm(data: dict[str, Any]) -> None:
    data["provenance"]["arm"]["joints"][1]["backlash_m"] = 6e-5
    data["provenance"]["arm_sha256"] = 64 * "a"


REFUSED: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "another arm": (_other_arm, "joints[1].backlash_m was 6e-05, is 5e-05"),
    "another schema": (lambda data: data.update(schema_version=2), "schema_version = 2: only 1"),
    "a bool for a version": (lambda data: data.update(schema_version=True), "only 1 is allowed"),
    "another major version": (
        lambda data: data.update(project_version="7.1.0"),
        "project_version = '7.1.0': major version 0",
    ),
    "no version": (lambda data: data.pop("project_version"), "project_version: major version"),
    "wrong type": (lambda data: data.update(runs=[]), "runs = []: "),
    "wrong verdict": (
        lambda data: data["checks"].update(x="fine"),
        "checks.x = 'fine': ",
    ),
    "wrong number": (_garble, "sampled.theta.samples.3.1 = 'fast': "),
    "short row": (_shorten, "sampled.theta.samples: every row"),
    "missing field": (lambda data: data.pop("checks"), "checks: "),
    "unknown field": (lambda data: data.update(extra=1), "extra = 1: "),
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_record_of_something_else_is_refused(recorded: Path, labelled: Arm, what: str) -> None:
    change, said = REFUSED[what]
    edited(recorded, change)
    assert said in _refusal(recorded, labelled)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", "NaN", '{"schema_version": 1', "\ufeff{}", "[" * 100_000]
)
def test_a_truncated_or_garbled_record_is_refused(recorded: Path, labelled: Arm, text: str) -> None:
    recorded.write_text(text, encoding="utf-8")
    _refusal(recorded, labelled)


def test_not_a_number_is_refused(recorded: Path, labelled: Arm) -> None:
    text = recorded.read_text(encoding="utf-8").replace('"tolerance": 1e-10', '"tolerance": NaN', 1)
    recorded.write_text(text, encoding="utf-8")
    assert "tolerance = nan: " in _refusal(recorded, labelled)


def test_bytes_that_are_no_text_are_refused(recorded: Path, labelled: Arm) -> None:
    recorded.write_bytes(b"\xff\xfe\x00")
    assert "is not JSON" in _refusal(recorded, labelled)


def test_a_missing_record_is_refused_before_anything_runs(
    command: Callable[..., int],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(validate, "cross_check", lambda arm, **options: pytest.fail("ran"))
    assert command("baseline", "check", "--quick") == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"no such file; make it: {RENEW}" in said


def _refusal(path: Path, arm: Arm) -> str:
    """The one line that refuses a record."""
    with pytest.raises(InputError) as refused:
        read_baseline(path, arm, RENEW)
    said = str(refused.value)
    assert "\n" not in said
    assert said.startswith(str(path))
    assert said.endswith(RENEW)
    return said


def test_an_interrupted_write_leaves_the_old_record(
    result: CrossCheck, recorded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = recorded.read_bytes()

    def full(*paths: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("crosscheck.output.os.replace", full)
    with pytest.raises(InputError, match="No space left on device"):
        write_baseline(recorded, baseline_of(result).model_copy(update={"seed": 5}))
    assert recorded.read_bytes() == before
    assert list(recorded.parent.iterdir()) == [recorded]


# The records that come with the project


@pytest.mark.parametrize("name", ["paper-labelled", "paper-swapped"])
def test_the_projects_own_records_fit(name: str) -> None:
    """They are of today's arm, small, and no tolerance is too wide to mean anything."""
    arm = load_arm(name)
    path = baseline_path(COMMITTED, arm, quick=True)
    baseline = read_baseline(path, arm, RENEW)
    assert path.stat().st_size < 300_000
    assert baseline.provenance.arm_sha256 == arm_digest(arm)
    for run in baseline.runs.values():
        for quantity, record in (*run.sampled.items(), *run.extremes.items()):
            assert record.basis
            assert record.tolerance is not None
            assert record.tolerance <= WIDEST[quantity].value
