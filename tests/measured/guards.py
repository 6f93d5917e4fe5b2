"""What is wrong with an arm's comparison, by a second program and by views that are read back."""

import json
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from crosscheck.identification import forward, output, restrictions
from crosscheck.identification.compare import RecordComparison
from crosscheck.identification.mechanism import PlanarArm
from crosscheck.identification.restrictions import FileJudgement, Restriction
from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_scenario, validate_record
from crosscheck.provenance import ROOT
from crosscheck.recordings import smoothing
from crosscheck.recordings.record import Record, read_record
from tests.measured import second
from tests.measured.records import compared, first_problem
from tests.measured.second_robot import TableFit, restrict, sample_rows

PAYLOAD, SUN = "arm.payload_mass_kg", "arm.joints.1.sun_inertia_kg_m2"
TOLERANCES = {PAYLOAD: 0.01}
LEVEL = "coupled"


class Case(NamedTuple):
    """A record of more payload than the file's, as it was compared."""

    comparison: RecordComparison
    problem: Any
    runs: second.Runs

    @property
    def record(self) -> Record:
        """The record."""
        return self.comparison.records[0]

    @property
    def judgement(self) -> FileJudgement:
        """What it says of the file."""
        judgement = self.comparison.sides[0].judgement
        assert judgement is not None
        return judgement


@lru_cache
def content() -> dict[str, Any]:
    """An arm of two unlike geared joints with friction and gravity, as its file has it."""
    text = (ROOT / "models" / "arms" / "three-unlike.toml").read_text(encoding="utf-8")
    data = tomllib.loads(text)
    return data | {"joints": data["joints"][:2], "links": data["links"][:2], "name": "unlike"}


@lru_cache
def kept() -> Case:
    """By code without a fault."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        second.write_record(path, second.with_value(content(), PAYLOAD, 5.1))
        record = read_record(path, 2)
        arm = PlanarArm(validate_record(Arm, content(), "unlike"))
        comparison = compared(record, arm, **TOLERANCES)
        problem = first_problem(arm.robot, record)
        return Case(comparison, problem, second.Runs(path, content(), TOLERANCES))


@lru_cache
def fit_again(path: str) -> TableFit:
    """A number at the level coupled, by the second program; lines make the times even."""
    record, side = kept().record, kept().comparison.sides[0]
    even = np.linspace(record.time[0], record.time[-1], len(record.time))
    position, torque = (
        np.column_stack([np.interp(even, record.time, each) for each in signal.T])
        for signal in (record.position, record.motor_torque)
    )
    limit = 'type="revolute"><limit lower="-9" upper="9" effort="1e9" velocity="1e9"/>'
    urdf = kept().comparison.mechanism.robot.urdf.replace('type="continuous">', limit)
    signals = sample_rows(urdf, even, position, torque, side.bandwidth)
    value = second.value_at(content(), path)
    plain, more = (
        second.Bodies(second.with_value(content(), path, each)) for each in (value, value + 1)
    )
    rubs = plain.friction
    return restrict(
        signals,
        lambda q, v, a: plain.torques(q, v, a) - rubs * v,
        lambda q, v, a: more.torques(q, v, a) - rubs * v,
    )


def apart(name: str, value: Any, right: Any, relative: float = 1e-6) -> Iterator[str]:
    """A line where two numbers, or rows of numbers, differ."""
    one, other = np.asarray(value, dtype=float), np.asarray(right, dtype=float)
    if one.shape != other.shape or not np.allclose(one, other, rtol=relative, atol=1e-13):
        yield f"{name}: {value}, must be {right}"


def wrong_estimates() -> Iterator[str]:
    """Of the payload and of a sun, of which one explains the record."""
    arm, side = kept().comparison.mechanism, kept().comparison.sides[0]
    judgement = kept().problem.fit_file(arm, side.bandwidth).judge(arm.levels)
    best = judgement.best
    if (best.level, best.parameter and best.parameter.path) != (LEVEL, PAYLOAD):
        yield f"explained by {best}"
    rms = np.sqrt((side.fit.residual**2).sum(axis=0) / side.fit.shown.sum(axis=0))
    given = [each for each in judgement.changes if each.level == LEVEL]
    for each in given:
        assert each.parameter is not None
        yield from _estimate(each, each.parameter.path, rms)
    yield from _estimate(fit_alone(SUN), SUN, rms)


def fit_alone(path: str) -> Restriction:
    """A number at the level coupled, whatever it explains."""
    arm, side = kept().comparison.mechanism, kept().comparison.sides[0]
    fits = kept().problem.fit_file(arm, side.bandwidth)
    level = next(each for each in arm.levels if each.name == LEVEL)
    parameter = next(each for each in arm.parameters if each.path == path)
    column = fits._compute_column(level, parameter)
    assert column is not None
    return fits._settle(level, parameter, column)


def _estimate(own: Restriction, path: str, rms: np.ndarray) -> Iterator[str]:
    fit, value = fit_again(path), second.value_at(content(), path)
    assert own.estimate is not None
    yield from apart("estimate", own.estimate.value, value + fit.values[-1])
    yield from apart("error", own.estimate.error, np.sqrt(fit.variances[-1]))
    yield from apart("ratios", own.ratios, fit.rms / rms)
    yield from apart("friction", [each.value for each in own.friction], fit.values[:-1], 1e-5)
    side = kept().comparison.sides[0]
    surprise = (side.fit.taken + side.fit.left) @ np.log((fit.rms / rms) ** 2)
    yield from apart("surprise", own.surprise, surprise, 1e-5)


def wrong_chances() -> Iterator[str]:
    """Of restrictions by SciPy's distributions, just within the limits and just beyond."""
    from scipy.stats import chi2, f

    ratios, further, left = np.array([1.1, 1.3]), np.array([2.0, 3.0]), np.array([30.0, 40.0])
    chances = f.sf((ratios**2 - 1) * left / further, further, left)
    right = chi2.sf(-2 * np.log(chances).sum(), 4)
    yield from apart("chance", restrictions.compute_chance(ratios, further, left), right)
    best = kept().judgement.best
    plain = replace(best, parameter=None, mechanism=kept().comparison.mechanism)
    for factor, is_within in ((1.01, True), (0.99, False)):
        if replace(plain, chance=factor * 1e-4).explains != is_within:
            yield f"chance {factor} of the limit"
        if replace(best, chance=factor * 1e-2).explains != is_within:
            yield f"chance of a number {factor} of the limit"
        other = replace(best, level="armature", surprise=best.surprise + 2 * np.log(100 / factor))
        judgement = FileJudgement((replace(plain, chance=0.0),), (best, other))
        if (len(judgement.explanations) == 2) != is_within:
            yield f"likelihood {factor} of the limit"
    if replace(best, mechanism=None).explains:
        yield "a number that no file may hold"


@lru_cache
def right_windows() -> list[dict[str, Any]]:
    """Of the second program."""
    return kept().runs.windows()


def wrong_runs() -> Iterator[str]:
    """Of the runs, their file and their picture: E and the uncertainties of ASME V&V 20."""
    pairs = [(kept().record, kept().record.motor_torque)]  # the file's numbers leave the record
    windows = list(forward.run_windows(pairs, kept().comparison.mechanism, LEVEL, TOLERANCES))
    if len(windows) != len(right_windows()):
        yield "number of runs"
        return
    changed = replace(kept().comparison, windows=tuple(windows))
    content = json.loads(output.comparison_json(changed))["windows"]
    for window, right in zip(content, right_windows(), strict=True):
        for name, value in window.items():
            yield from apart(name, value, right[name], 1e-5)
    for joint in range(2):
        axes = Figure().subplots()
        output.draw_runs(windows, joint, axes)
        for line, band, right in zip(axes.lines, axes.collections, right_windows(), strict=True):
            yield from apart("E in the picture", line.get_ydata(), right["E"][:, joint], 1e-5)
            corners = band.get_paths()[0].vertices[1 : len(right["E"]) + 1, 1]
            yield from apart("u_val", np.abs(corners), 2 * right["u_val"][:, joint])


def wrong_torques_of_a_drive() -> Iterator[str]:
    """Of a record without any, by the law of a controller."""
    time = np.linspace(0.0, 2.0, 2001)
    waves = np.outer(time, [3.0, 5.0])
    record = Record("file", time, 0.3 * np.sin(waves))
    law = {
        "target_rad": (0.5, -0.2),
        "proportional_N_m_per_rad": (100.0, 70.0),
        "derivative_N_m_s_per_rad": (40.0, 9.0),
    }
    scenario = load_scenario("pd")
    drive = scenario.drive.model_copy(update=law)
    given = smoothing.add_drive_torques(
        record, scenario.model_copy(update={"drive": drive})
    ).motor_torque
    rates = 0.3 * np.array([3.0, 5.0]) * np.cos(waves)
    right = np.array([100.0, 70.0]) * ([0.5, -0.2] - record.position) - [40.0, 9.0] * rates
    if not np.allclose(given, right, atol=1e-3):
        yield f"torques off by {np.abs(given - right).max()}"


def wrong_choice() -> Iterator[str]:
    """Of which blocks are looked at where there are many: as far apart as may be."""
    record = kept().record
    times = [
        block.time[0] for block in smoothing.smooth_record(record, record.motor_torque, 4, 800)
    ]
    for most in (1, 2, 3):
        blocks = smoothing.smooth_record(record, record.motor_torque, 4, most)
        places = [times.index(block.time[0]) for block in blocks]
        steps = max(most - 1, 1)
        if places != [round(n * (len(times) - 1) / steps) for n in range(most)]:
            yield f"blocks {places} of {len(times)}"
