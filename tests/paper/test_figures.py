"""The figures' chapter: verdicts on both sides of their thresholds, measures of known signals."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from crosscheck.paper import events
from crosscheck.paper.figures import chapter as figures
from crosscheck.paper.figures import measures as figures_measures
from crosscheck.paper.figures import verdicts as figures_verdicts
from crosscheck.paper.figures.laws import figure_4, figure_5, limits, ratio_row
from crosscheck.paper.figures.plate import Shelf
from crosscheck.paper.figures.store import reduced
from crosscheck.paper.reductions import first_planets
from crosscheck.paper.scale import QUICK
from crosscheck.studies.study import Study, Variant

JUST = 1e-6
TIME = np.arange(30000) * 4e-5
ARM_M = 0.08592281


def test_every_figure_has_its_plate() -> None:
    assert tuple(range(4, 21)) == figures.NUMBERS
    assert set(figures.QUICK_NUMBERS) <= set(figures.NUMBERS)


@pytest.mark.parametrize(
    ("omega_t", "angle", "expected"),
    [
        (True, True, "holds"),
        (True, False, "only with omega_t"),
        (False, True, "only with angle"),
        (False, False, "does not hold"),
    ],
)
def test_words_for_the_two_laws(omega_t: bool, angle: bool, expected: str) -> None:
    assert figures_verdicts.by_law({"omega_t": omega_t, "angle": angle}) == expected


THRESHOLDS = {
    "accurate": (lambda x: figures_verdicts.accurate(x, 1.0), -figures_verdicts.ACCURATE),
    "same": (lambda x: figures_verdicts.same(x, 1.0), -figures_verdicts.SAME),
    "explains": (lambda x: figures_verdicts.explains(x, 1.0), figures_verdicts.EXPLAINS),
    "converges": (lambda x: figures_verdicts.converges(1.0, x, 1.0), -figures_verdicts.CONVERGED),
    "fluctuates": (figures_verdicts.fluctuates, figures_verdicts.ACCELERATION),
    "stands_out": (figures_verdicts.stands_out, figures_verdicts.LINE),
    "visible": (lambda x: figures_verdicts.visible(x, 1.0), figures_verdicts.TORQUE),
    "proportional": (figures_verdicts.proportional, -figures_verdicts.PROPORTIONAL),
    "continuous": (figures_verdicts.continuous, -figures_verdicts.PROMINENT),
    "accumulates": (lambda x: figures_verdicts.accumulates(1.0, x), figures_verdicts.ACCUMULATES),
    "overshoots": (lambda x: not figures_verdicts.restrained(x), figures_verdicts.OVERSHOOT),
}


@pytest.mark.parametrize("name", THRESHOLDS)
def test_thresholds_from_both_sides(name: str) -> None:
    """A threshold is positive where the verdict wants more, negative where it wants less."""
    decide, threshold = THRESHOLDS[name]
    sign = np.sign(threshold)
    assert decide(abs(threshold) * (1 + sign * JUST))
    assert not decide(abs(threshold) * (1 - sign * JUST))


def test_near_and_in_range() -> None:
    assert figures_verdicts.near(1.09, 1.0, 0.1)
    assert not figures_verdicts.near(1.11, 1.0, 0.1)
    assert figures_verdicts.near(None, 1.0, 0.1) is None
    assert figures_verdicts.in_range(49.0, 10.0, 40.0)
    assert not figures_verdicts.in_range(51.0, 10.0, 40.0)
    assert not figures_verdicts.in_range(7.0, 10.0, 40.0)


def test_trends() -> None:
    sizes = [1.0, 2.0, 3.0, 4.0]
    large = figures_verdicts.FORCE_N
    one_swap, two_swaps = [1.0, 3.0, 2.0, 4.0], [2.0, 1.0, 4.0, 3.0]
    assert figures_verdicts.rises(sizes, one_swap)
    assert not figures_verdicts.rises(sizes, two_swaps)
    assert not figures_verdicts.rises(sizes, [1.0] * 4)
    assert figures_verdicts.falls(sizes, one_swap[::-1])
    scaled = [value * large / 4 for value in one_swap]
    assert figures_verdicts.fluctuation_rises(sizes, scaled)
    assert not figures_verdicts.fluctuation_rises(sizes, [0.99 * value for value in scaled])
    assert figures_verdicts.fluctuation_falls(sizes, scaled[::-1])
    assert not figures_verdicts.fluctuation_falls(sizes, scaled)
    assert figures_verdicts.appears_at(sizes, [0.0, 0.9 * large, large, 2 * large]) == 3.0
    assert figures_verdicts.appears_at(sizes, [0.0] * 4) is None


def test_swing_ignores_the_slow_motion() -> None:
    slow = 100 * np.sin(2 * np.pi * TIME)
    fast = np.where(TIME > 0.9, 30 * np.sin(2 * np.pi * 1350 * TIME), 0)
    assert figures_measures.swing(TIME, slow + fast, 0.5, 1.2) == pytest.approx(30, rel=0.05)
    assert figures_measures.swing(TIME, slow, 0.5, 1.2) < 2


def test_side_changes_and_cycles() -> None:
    x = 60e-6 * np.cos(2 * np.pi * 2 * TIME)
    times = events.arrivals(TIME, x, 50e-6)
    assert times.size == 5
    assert times[0] == pytest.approx((np.pi - np.arccos(0.75)) / (4 * np.pi), abs=1e-4)
    assert events.arrivals(TIME, 0.5 * x, 50e-6).size == 0
    ripple = 5 * np.sin(2 * np.pi * 20 * TIME) + np.sin(2 * np.pi * 1700 * TIME)
    assert figures_measures.cycles(TIME, 52 + ripple, 52.0, 2.5) == pytest.approx(24, abs=1)


def test_impact() -> None:
    force = np.where(TIME < 0.35, 10.0, np.where((TIME > 0.36) & (TIME < 0.37), 0.0, -400.0))
    found = figures_measures.impact(TIME, force)
    assert found.contact_s == pytest.approx(0.35, abs=1e-4)
    assert found.peak_N == 400
    assert found.bouncing_s == pytest.approx(0.02, abs=2e-4)
    assert figures_measures.impact(TIME, np.ones_like(TIME)).contact_s is None


def test_line_of_a_tone_in_noise() -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(TIME.size)
    tone = 12 * np.sin(2 * np.pi * 1362 * TIME)
    run = xr.Dataset(
        {"theta_ddot": (("time", "joint"), np.column_stack([tone + noise, noise]))},
        {"time": TIME},
    )
    shoulder, elbow = (figures_measures.line(run, joint) for joint in (0, 1))
    assert shoulder.frequency_Hz == pytest.approx(1362, abs=1)
    assert shoulder.size_rad_per_s2 == pytest.approx(12, rel=0.15)
    assert not figures_verdicts.continuous(shoulder.prominence)
    assert figures_verdicts.continuous(elbow.prominence)


def test_drive_work_of_a_rigid_turn() -> None:
    """A constant torque on an angle: work is torque times angle, up to the energy's peak."""
    theta = np.column_stack([TIME**2, 0 * TIME])
    still = np.zeros((TIME.size, 2, 1))
    run = xr.Dataset(
        {
            "theta": (("time", "joint"), theta),
            "torque": (("time", "joint"), np.full_like(theta, 5.0)),
            "x_sp": (("time", "joint", "planet"), still),
            "x_pr": (("time", "joint", "planet"), still),
            "kinetic_energy": ("time", TIME),
        },
        {"time": TIME},
    )
    energy, work = figures_measures.energy_peak(run, (ARM_M, ARM_M))
    assert energy == TIME[-1]
    assert work == pytest.approx(5 * TIME[-1] ** 2)


@pytest.mark.parametrize("contact_ratio", [1.2, 1.5, 1.7])
def test_limits_give_the_fundamental_its_size(contact_ratio: float) -> None:
    low, high = limits(1e8, 2e7, contact_ratio)
    ratio, phase, swing, mean = ratio_row(contact_ratio, 1e8, 2e7)
    assert (ratio, swing) == (contact_ratio, high - low)
    assert mean == pytest.approx(1e8)
    assert (phase == 0) is (contact_ratio == 1.5)
    if contact_ratio == 1.5:
        assert swing == pytest.approx(np.pi * 2e7 / 2)


def test_drawn_laws_are_deterministic_and_hold(tmp_path: Path) -> None:
    shelf = Shelf(Study(tmp_path), QUICK)
    for draw in (figure_4, figure_5):
        plate = draw(shelf)
        assert plate.html() == draw(shelf).html()
        assert set(plate.verdicts.values()) == {"holds"}
        assert plate.svg.startswith("<svg")


def test_reduction_keeps_windows_and_extrema() -> None:
    generator = np.random.default_rng(3)
    data = generator.standard_normal((TIME.size, 2, 3))
    whole = xr.Dataset({"F_sp": (("time", "joint", "planet"), data)}, {"time": TIME})
    run = first_planets(whole)
    assert run.sizes["planet"] == 1
    small = reduced(run, {"third": (0.8, 0.85)}, bin_s=0.01)
    assert small.sizes["time"] < run.sizes["time"] / 5
    inside = small.sel(time=slice(0.8, 0.85 - 1e-9))
    assert inside.sizes["time"] == run.sel(time=slice(0.8, 0.85 - 1e-9)).sizes["time"]
    for begin in (0.0, 0.33, 1.19):
        part = slice(begin, begin + 0.01 - 1e-9)
        whole, kept = (r["F_sp"].sel(time=part).isel(planet=0) for r in (run, small))
        assert (kept.max("time") == whole.max("time")).all()
        assert (kept.min("time") == whole.min("time")).all()
    assert json.loads(small.attrs["windows_s"]) == {"third": [0.8, 0.85]}


def test_shelf_reads_a_run_once(tmp_path: Path) -> None:
    study = Study(tmp_path)
    shelf = Shelf(study, QUICK)
    variant = Variant("constant-torque", duration_s=1e-3)
    first = shelf.runs([variant], 8)[variant]
    assert shelf.runs([variant], 9)[variant] is first
    assert first.sizes["planet"] == 1
    assert (study.made, study.found) == (1, 0)


@pytest.mark.slow
def test_quick_chapter(tmp_path: Path) -> None:
    study = Study(tmp_path, 2)
    chapter = figures.chapter(study, QUICK)
    assert [record["id"] for record in chapter.records] == [
        f"figure-{number}" for number in figures.QUICK_NUMBERS
    ]
    json.dumps(chapter.records, allow_nan=False)
    assert re.findall(r'<h3 id="figure-(\d+)"', chapter.html) == [
        str(number) for number in figures.QUICK_NUMBERS
    ]
    assert figures.chapter(study, QUICK) == chapter
    verdicts = {record["id"]: record["verdicts"] for record in chapter.records}
    assert verdicts["figure-14"]["third fluctuation"] == "only with omega_t"
    assert verdicts["figure-6"]["the deviation comes from the mesh"] == "does not hold"
