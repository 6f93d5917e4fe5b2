"""Numbers of an arm's comparison against a second program, and every view of them."""

import json
import tomllib
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from crosscheck.identification import output
from crosscheck.identification.compare import RecordComparison
from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import validate_record
from crosscheck.provenance import ROOT
from crosscheck.recordings.record import read_record
from tests.loops import require_items
from tests.measured import second
from tests.measured.records import compared
from tests.measured.second_robot import restrict, sample_rows

PAYLOAD = "arm.payload_mass_kg"
TOLERANCES = {PAYLOAD: 0.01}


@lru_cache
def content() -> dict[str, Any]:
    """An arm of two unlike geared joints with friction and gravity, as its file has it."""
    text = (ROOT / "models" / "arms" / "three-unlike.toml").read_text(encoding="utf-8")
    found = tomllib.loads(text)
    return found | {"joints": found["joints"][:2], "links": found["links"][:2], "name": "unlike"}


@lru_cache
def measured() -> tuple[RecordComparison, second.Runs]:
    """A record of more payload than the file's, and runs by a second program with that payload."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        second.write_record(path, second.with_value(content(), PAYLOAD, 5.1), "coupled")
        record = read_record(path, 2)
        comparison = compared(record, validate_record(Arm, content(), "unlike"), **TOLERANCES)
        estimate = comparison.sides[0].judgement.best.estimate
        heavy = second.with_value(content(), PAYLOAD, estimate.value)
        return comparison, second.Runs(path, heavy, TOLERANCES)


@pytest.mark.parametrize("level", ["armature", "coupled"])
def test_a_second_program_estimates_the_same_payload(level):
    """1e-8 is rounding times condition numbers; times of the record are uneven, lines make them
    even."""
    comparison, _ = measured()
    side, (record,) = comparison.sides[0], comparison.records
    changes = [each for each in side.judgement.changes if each.parameter.path == PAYLOAD]
    own = {each.level: each for each in changes}.get(level)
    if own is None:
        assert level == "armature"
        return
    even = np.linspace(record.time[0], record.time[-1], len(record.time))
    position, torque = (
        np.column_stack([np.interp(even, record.time, each) for each in signal.T])
        for signal in (record.position, record.motor_torque)
    )
    urdf = comparison.mechanism.robot.urdf
    signals = sample_rows(urdf, even, position, torque, side.bandwidth)
    contents = content(), second.with_value(content(), PAYLOAD, content()["payload_mass_kg"] + 1)
    bodies = [second.Bodies(each, level) for each in contents]
    rubs = bodies[0].friction
    fit = restrict(signals, *(lambda q, v, a, b=b: b.torques(q, v, a) - rubs * v for b in bodies))
    assert own.estimate.value == pytest.approx(content()["payload_mass_kg"] + fit.values[-1])
    assert own.estimate.error == pytest.approx(np.sqrt(fit.variances[-1]), rel=1e-6)
    ratios = fit.rms / np.sqrt((side.residual**2).sum(axis=0) / side.shown.sum(axis=0))
    assert own.ratios == pytest.approx(ratios, rel=1e-6)
    friction = [each.value for each in own.friction]
    assert friction == pytest.approx(fit.values[:-1].tolist(), rel=1e-6, abs=1e-9)


def test_runs_are_those_of_a_second_program():
    """1e-5: uncertainties are differences of runs."""
    comparison, runs = measured()
    windows = json.loads(output.comparison_json(comparison))["windows"]
    expected = runs.windows(comparison.sides[0].judgement.best.level)
    assert len(windows) == len(expected) == len(comparison.windows)
    for window, right in zip(windows, expected, strict=True):
        for name, value in require_items(window.items()):
            assert np.asarray(value) == pytest.approx(np.asarray(right[name]), rel=1e-5, abs=1e-13)
    axes = Figure().subplots()
    output.draw_runs(comparison.windows, 0, axes)
    for line, right in zip(axes.lines, expected, strict=True):
        assert line.get_ydata() == pytest.approx(right["E"][:, 0], rel=1e-5, abs=1e-13)


def test_every_view_has_the_same_numbers():
    comparison, _ = measured()
    data = json.loads(output.comparison_json(comparison))
    lines = list(output.describe_comparison(comparison))
    assert lines[: lines.index("")] == data["answer"]
    best = comparison.sides[0].judgement.best
    (change, *_) = data["sides"][0]["with_the_files_numbers"]["single_numbers"]
    assert (change["path"], change["level"]) == (PAYLOAD, best.level)
    assert change["number"]["estimate"] == best.estimate.value
    assert change["rms_over_that_of_any_links"] == best.ratios.tolist()
    page = output.comparison_page(comparison)
    row = [f"{best.estimate.value:.6g}", f"{best.estimate.half_width:.2g}"]
    for text in (*data["answer"], *row, best.parameter.phrase):
        assert text in page.replace("&#39;", "'").replace("&gt;", ">")
    assert page.count('<tr><td class="n">') == len(comparison.windows)
