"""Recorded baselines: what a repetition may differ by, and what it may not."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import crosscheck.analytic.model
from crosscheck.baseline.file import baseline_path, read_baseline, write_baseline
from crosscheck.baseline.reduction import find_uncompared, find_unrecorded_runs, make_baseline
from crosscheck.baseline.regression import describe_changes
from crosscheck.findings import ComparisonKey, Subject, make_check, make_unfinished_check
from crosscheck.models.arm.arm import Arm
from crosscheck.models.inputs import forget
from crosscheck.models.loading import load_arm
from crosscheck.provenance import mechanism_digest
from crosscheck.registry import MODELS, register
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.tasks import RunKey
from tests.baselines.short import (
    ANALYTIC,
    DURATION_S,
    EXUDYN,
    NUDGED,
    RENEW,
    about,
    edited,
    held_against,
    measurement,
    moved,
    put,
    quick,
    short_check,
    with_findings,
    with_run,
)
from tests.loops import require_items

pytestmark = pytest.mark.slow

COMMITTED = Path(__file__).parents[2] / "baselines"


# What stands


def test_a_record_read_back_is_the_record(result, recorded):
    baseline = make_baseline(result)
    assert read_baseline(recorded, result.request, RENEW) == baseline
    lost = make_unfinished_check(about("refined"), "")
    assert make_baseline(with_findings(result, [*result.agreement.findings, lost])) == baseline
    before = recorded.read_bytes()
    forget()  # a command that has read it does not write it
    write_baseline(recorded, baseline)
    assert recorded.read_bytes() == before


def test_extremes_on_record_are_where_the_run_has_them(result):
    """Each row's values stand in the run of planet 1 at each row's times, and none is beyond."""
    recorded = make_baseline(result).runs[str(ANALYTIC)]
    for name, table in require_items(recorded.extremes.items()):
        run = result.runs[ANALYTIC][name]
        run = run.isel(planet=0) if "planet" in run.dims else run
        for joint, low, low_s, high, high_s in require_items(table.rows):
            values = run.sel(joint=int(joint))
            assert float(values.sel(time=low_s, method="nearest")) == low == values.min()
            assert float(values.sel(time=high_s, method="nearest")) == high == values.max()


def test_planet_1_is_on_record(result):
    """What another planet does moves no row."""
    run = result.runs[ANALYTIC].copy(deep=True)
    assert run.sizes["planet"] > 1
    for name in ("x_sp", "x_pr", "F_sp", "F_pr"):
        run[name].loc[{"planet": run["planet"][-1]}] *= 1.5
    now, then = (make_baseline(each) for each in (with_run(result, ANALYTIC, run), result))
    for name, table in require_items(now.runs[str(ANALYTIC)].tables.items()):
        assert table.rows == then.runs[str(ANALYTIC)].tables[name].rows


def test_a_repetition_does_not_move(result, recorded):
    agreement = held_against(recorded, short_check(result.mechanism))
    assert agreement.exit_code == 0
    assert len(agreement.checks) == len(agreement.findings) > 40
    assert describe_changes(agreement) == []


@pytest.mark.parametrize("stand_in", [EXUDYN, NUDGED], ids=str)
def test_rounding_of_another_kind_does_not_move(result, recorded, stand_in):
    """Another implementation of the same steps rounds as differently as any machine could."""
    run = result.runs[stand_in].assign_attrs(result.runs[ANALYTIC].attrs)
    others = with_run(result, ANALYTIC, run)
    if stand_in == NUDGED:  # what one rounding grows to is still the distance of the two
        others = with_run(others, NUDGED, result.runs[ANALYTIC])
    agreement = held_against(recorded, others)
    assert agreement.exit_code == 0
    assert any(f.measured for f in agreement.checks if f.id.startswith(f"recorded-run/{ANALYTIC}/"))


def test_numbers_have_17_digits_and_one_row_each(recorded):
    lines = recorded.read_text(encoding="utf-8").splitlines()
    texts = ('"basis": ', '"title": ', '"command": ')
    assert max(len(line) for line in lines if not any(text in line for text in texts)) <= 110
    sampled = json.loads("\n".join(lines))["runs"][str(ANALYTIC)]["sampled"]["theta"]["rows"]
    last = f"[{DURATION_S!r}, {sampled[-1][1]:.16e}, {sampled[-1][2]:.16e}]"
    assert last in [line.strip() for line in lines]


# What moves


# Not the shoulder's carrier: it holds 0.04 of the 92 kg m^2 about it, and its millionth comes to
# 2e-12 rad in so short a run.
@pytest.mark.parametrize(
    ("place", "field"),
    [
        ("joints", "sun_mesh.backlash_m"),
        ("joints", "ring_mesh.backlash_m"),
        ("joints", "sun_mesh.stiffness.mean_N_per_m"),
        ("joints", "ring_mesh.stiffness.mean_N_per_m"),
        ("joints", "sun_mesh.tooth_error_m"),
        ("joints", "sun_mesh.damping_ratio"),
        ("joints", "sun_equivalent_mass_kg"),
        ("joints", "planet_equivalent_mass_kg"),
        ("links", "length_m"),
        ("links", "com_m"),
        ("links", "density_kg_per_m3"),
    ],
)
@pytest.mark.parametrize("key", [ANALYTIC, EXUDYN], ids=str)
def test_a_millionth_of_a_parameter_moves_a_run(result, recorded, key, place, field):
    """Of its first joint or link."""
    data = result.mechanism.model_dump()
    put(lambda value: value * (1 + 1e-6), place, 0, *field.split("."))(data)
    other = short_check(Arm.model_validate(data), only=key).runs[key]
    changes = moved(held_against(recorded, with_run(result, key, other)))
    assert changes
    assert {finding.verdict for finding in changes.values()} == {"differ"}
    assert all(name.startswith(f"recorded-run/{key}/") for name in changes)


def test_a_millionth_of_the_payload_moves_the_rigid_arm(result, recorded):
    key = RunKey("pd", "pinocchio:coupled")
    heavier = result.mechanism.model_copy(update={"payload_mass_kg": 10.0 * (1 + 1e-6)})
    other = short_check(heavier, only=key).runs[key]
    agreement = held_against(recorded, with_run(result, key, other))
    assert f"recorded-run/{key}/theta_dot" in moved(agreement)


def test_a_planted_fault_moves(result, recorded, monkeypatch):
    """The ring mesh at the sun's rate of Eq. 13: 27 cycles per turn for 99."""
    right = crosscheck.analytic.model.build_gears

    def wrong(*given: Any) -> Any:
        gears = right(*given)
        rate = gears.rate.copy()
        rate[1::2] *= 27 / 99
        return gears._replace(rate=rate)

    monkeypatch.setattr(crosscheck.analytic.model, "build_gears", wrong)
    changes = moved(held_against(recorded, short_check(result.mechanism)))
    assert f"recorded-run/{ANALYTIC}/x_pr" in changes
    worse = changes["recorded-verdict/same-step/pd/x_pr/analytic:physical~exudyn:tree"]
    assert worse.note.startswith("worse: agree -> differ")
    assert not any(str(EXUDYN) in name for name in changes)


@pytest.mark.parametrize(("times", "verdict"), [(0.9, "agree"), (2.0, "differ")])
def test_a_number_moves_beyond_its_tolerance(result, recorded, times, verdict):
    tolerance = make_baseline(result).runs[str(ANALYTIC)].sampled["theta"].tolerance
    assert tolerance is not None
    by = times * tolerance
    place = "runs", str(ANALYTIC), "sampled", "theta", "rows", 7, 2
    edited(recorded, put(lambda angle: angle + by, *place))
    agreement = held_against(recorded, result)
    finding = next(f for f in agreement.checks if f.id == f"recorded-run/{ANALYTIC}/theta")
    assert finding.verdict == verdict
    assert finding.measured == pytest.approx(by, rel=1e-2)
    assert finding.note.startswith(f"joint 2 at {0.35 * DURATION_S:.4g} s: ")  # row 7 of 20
    assert len(agreement.disagreeing) == (verdict == "differ")


@pytest.fixture
def tip(result) -> str:
    """The id of a measurement."""
    return next(f.id for f in result.agreement.findings if f.id.startswith("deviation/pd/tip"))


def test_a_measurement_moves(result, recorded, tip):
    edited(recorded, put(lambda size: 1.01 * size, "measurements", tip, "measured"))
    assert list(moved(held_against(recorded, result))) == [f"recorded-measurement/{tip}"]


def test_checks_and_measurements_appear_and_disappear(result, recorded):
    first, *rest = result.agreement.checks
    new = measurement("new")
    measurements = [f for f in result.agreement.findings if f.kind == "measurement"]
    check = replace(first, about=about("new"))
    other = with_findings(result, [*rest, check, *measurements[1:], new])
    notes = {name: finding.note for name, finding in moved(held_against(recorded, other)).items()}
    assert notes.pop("recorded-verdict/new/pd/theta/a~b").startswith(
        "appeared: nothing on record; agree: measured "
    )
    assert notes == {
        f"recorded-verdict/{first.id}": "disappeared; was agree",
        f"recorded-measurement/{measurements[0].id}": "disappeared",
        "recorded-measurement/deviation/new/theta/a~b": "appeared: nothing on record",
    }


def test_a_guest_that_came_in_later_is_said_and_not_judged(result, recorded):
    """Unless it is red: a record without it is held against the rest."""
    subject = Subject(
        ComparisonKey("same-step", "pd", "theta", "analytic:physical", "guest"), "rad", ""
    )
    fine = make_check(subject, measured=1e-12, tolerance=1e-10, basis="")
    findings = result.agreement.findings
    with register("guest", MODELS["pinocchio:gears"]):
        agreement = held_against(recorded, with_findings(result, [*findings, fine]))
        (new,) = (f for f in agreement.findings if "came in after the record" in f.note)
        assert (new.kind, agreement.exit_code) == ("measurement", 0)
        wrong = make_check(subject, measured=1e-9, tolerance=1e-10, basis="")
        assert moved(held_against(recorded, with_findings(result, [*findings, wrong])))
    assert moved(held_against(recorded, with_findings(result, [*findings, fine])))


def test_a_run_that_fails_has_disappeared(result, recorded):
    broken = with_run(result, EXUDYN, Failure("Diverged", "at t = 0.01 s"))
    notes = [finding.note for finding in moved(held_against(recorded, broken)).values()]
    assert notes == ["disappeared: Diverged: at t = 0.01 s"]


def test_other_settings_are_named_and_not_compared(result, recorded):
    edited(recorded, put(2e-5, "runs", str(ANALYTIC), "scenario", "step_s"))
    changes = moved(held_against(recorded, result))
    assert list(changes) == [f"recorded-run/{ANALYTIC}/settings"]
    assert "scenario.step_s 2e-05 -> 1e-05" in changes[f"recorded-run/{ANALYTIC}/settings"].note


def test_what_else_changed_is_named(result, recorded):
    edited(recorded, put("1.0", "provenance", "versions", "exudyn"))
    edited(recorded, put(64 * "0", "provenance", "lock_sha256"))
    changed = describe_changes(held_against(recorded, result))
    assert [line.split(" -> ")[0] for line in changed] == ["exudyn 1.0", "lock_sha256 000000000000"]


def test_without_a_meaningful_tolerance_nothing_is_compared(result):
    """A start that one rounding decides: a run is recorded, no numbers are held against it."""
    wild = result.runs[NUDGED]
    wild = with_run(result, NUDGED, wild.assign(x_sp=wild["x_sp"] + 1e-5))
    baseline = make_baseline(wild)
    sampled = baseline.runs[str(ANALYTIC)].sampled
    assert sampled["x_sp"].tolerance is None
    basis = sampled["x_sp"].basis
    assert basis.startswith("not compared: the same steps again: rounding")
    found, most = re.findall(r", (\S+); (\S+) at most, ", basis)[0]
    assert float(found) > float(most)
    assert float(most) == pytest.approx(sampled["x_sp"].widest, rel=0.05)  # two digits
    assert f"{ANALYTIC} x_sp: {basis}" in list(find_uncompared(baseline))
    assert sampled["theta"].tolerance is not None


def test_an_adaptive_run_without_a_second_one_is_not_compared(result):
    """Its steps hang on roundings of BLAS, which are other ones on other processors."""
    adaptive = replace(ANALYTIC, variant="reference")
    second = replace(ANALYTIC, variant="reference-coarse")
    alone = with_run(result, second, Failure("Diverged", "at t = 0.01 s"))
    sampled = make_baseline(alone).runs[str(adaptive)].sampled
    assert {table.tolerance for table in sampled.values()} == {None}
    assert sampled["theta"].basis.startswith("not compared: the integrator chooses its own steps")


@pytest.mark.parametrize(("times", "red"), [(50.0, False), (200.0, True)])
def test_a_tolerance_is_as_wide_as_is_granted_today(result, recorded, tip, times, red):
    """Whoever renews the digest too cannot make room for a change."""
    for place in (("runs", str(ANALYTIC), "sampled", "theta"), ("measurements", tip)):
        edited(recorded, put(lambda granted: times * granted, *place, "tolerance"))
    notes = {key: finding.note for key, finding in moved(held_against(recorded, result)).items()}
    names = [f"recorded-measurement/{tip}", f"recorded-run/{ANALYTIC}/theta"]
    assert list(notes) == (names if red else [])
    assert all(note.startswith("a tolerance that is not granted: ") for note in notes.values())


def test_without_a_tolerance_a_record_is_no_free_pass(result, recorded):
    def change(data: dict[str, Any]) -> None:
        kinds = [run[kind] for run in data["runs"].values() for kind in ("sampled", "extremes")]
        tables = [table for kind in kinds for table in kind.values()]
        for number in (*data["measurements"].values(), *tables):
            number["tolerance"] = None

    edited(recorded, change)
    baseline = make_baseline(result)
    numbers = len(baseline.measurements) + sum(len(run.tables) for run in baseline.runs.values())
    assert len(moved(held_against(recorded, result))) == numbers


def test_another_unit_of_a_measurement_is_named(result, recorded, tip):
    edited(recorded, put("km", "measurements", tip, "unit"))
    changes = moved(held_against(recorded, result))
    assert "recorded in 'km', now in 'm'" in changes[f"recorded-measurement/{tip}"].note


# Whatever a model puts into a run is a lost run, no crash.
SPOILT: dict[str, Callable[[xr.Dataset], xr.Dataset]] = {
    "not a number": lambda run: run.assign(theta=run["theta"] * np.nan),
    "beyond all bounds": lambda run: run.assign(x_sp=run["x_sp"] + np.inf),
    "half a run": lambda run: run.isel(time=slice(0, 100)),
    "a joint missing in one quantity": lambda run: run.assign(
        theta=run["theta"].isel(joint=[0]).rename(joint="one")
    ),
    "complex": lambda run: run.assign(theta=run["theta"] * 1j),
    "text": lambda run: run.assign(theta=run["theta"].astype(str)),
    "nothing": lambda run: run.assign(theta=xr.full_like(run["theta"], None, dtype=object)),
    "no attributes": lambda run: run.drop_attrs(),
    "other units": lambda run: run.assign(theta=run["theta"].assign_attrs(units="deg")),
    "no time": lambda run: run.isel(time=0),
    "empty": lambda run: run.isel(time=slice(0, 0)),
    "backwards": lambda run: run.isel(time=slice(None, None, -1)),
}


@pytest.mark.parametrize("how", SPOILT)
def test_a_spoilt_run_is_a_lost_run(result, recorded, how):
    spoilt = with_run(result, EXUDYN, SPOILT[how](result.runs[EXUDYN]))
    assert str(EXUDYN) not in make_baseline(spoilt).runs
    assert len(list(find_unrecorded_runs(spoilt))) == 1
    changes = moved(held_against(recorded, spoilt))
    note = changes[f"recorded-run/{EXUDYN}/run"].note
    assert note.startswith("disappeared: cannot be recorded: ")
    assert len(note) < 400


def test_a_run_of_fewer_joints_or_quantities_is_seen(result, recorded):
    run = result.runs[EXUDYN]
    one = moved(held_against(recorded, with_run(result, EXUDYN, run.isel(joint=[0]))))
    assert "another number of joints" in one[f"recorded-run/{EXUDYN}/theta"].note
    less = moved(held_against(recorded, with_run(result, EXUDYN, run.drop_vars("F_sp"))))
    assert "no such quantity" in less[f"recorded-run/{EXUDYN}/F_sp"].note


# The records that come with the project


@pytest.mark.parametrize("name", ["paper-labelled", "paper-swapped"])
def test_the_projects_own_records_fit(name):
    """They are of today's arm, small, and no tolerance is too wide to mean anything."""
    arm = load_arm(name)
    path = baseline_path(COMMITTED, quick(arm))
    baseline = read_baseline(path, quick(arm), RENEW)
    assert path.stat().st_size < 400_000
    assert baseline.provenance.arm_sha256 == mechanism_digest(arm)
    for key, run in baseline.runs.items():
        for quantity, record in run.tables.items():
            assert record.basis
            if record.tolerance is None:
                assert (key.split("-")[0], key.split("/")[-1]) == ("energy", "reference")
            else:
                assert record.tolerance <= record.widest, quantity
