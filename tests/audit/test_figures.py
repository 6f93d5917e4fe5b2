"""The figures' chapter: what is drawn is what the claims were asked, and measures of known runs."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.backlash import dead_zone_tanh
from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.experiments.bands import BandsQuestion, shoulder_signal
from crosscheck.audit.experiments.experiments import (
    BACK,
    BACKLASH,
    CONSTANT,
    ERROR,
    PD,
    build_question,
)
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    LABELLED,
    LAWS,
    PRINTED,
    Condition,
)
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant, simulate
from crosscheck.audit.figures import chapter as figures
from crosscheck.audit.figures.figure_data import (
    LOW_ZETA,
    FigureData,
    make_condition,
    make_start_variant,
)
from crosscheck.audit.figures.law_figures import draw_figure_14, static_numbers
from crosscheck.audit.figures.laws import (
    draw_figure_4,
    draw_figure_5,
    ratio_row,
    stiffness_limits,
    tanh_sharpness,
)
from crosscheck.audit.figures.paper_figure import find_figure_claims
from crosscheck.audit.figures.sweeps import energy_peak
from crosscheck.audit.figures.trajectory_reduction import reduce_run, select_stored_variants
from crosscheck.audit.measures.reading import select_first_planets
from crosscheck.audit.measures.run_signals import extract_signals
from crosscheck.audit.page.context import AuditContext
from crosscheck.models.loading import load_arm
from crosscheck.studies.members.starts import perturb_start
from tests.loops import require_items

pytestmark = pytest.mark.slow

TIME = np.arange(30000) * 4e-5
BRIEF = Scale(quick=True, longest_s=0.002, most_starts=2)


def shelf_in(folder: Path, scale: Scale = BRIEF) -> FigureData:
    return FigureData(AuditContext(Study(folder), scale))


def test_every_figure_has_its_plate():
    assert tuple(range(4, 21)) == figures.NUMBERS
    assert set(figures.QUICK_NUMBERS) <= set(figures.NUMBERS)
    assert {claim.figure for claim in CLAIMS} - {None} <= set(figures.NUMBERS)


@pytest.mark.parametrize("source", [PD, CONSTANT, BACKLASH(5), ERROR(1.6), BACK(100)], ids=str)
def test_what_is_drawn_is_a_start_of_what_the_claims_were_asked(source):
    cell = Condition(PRINTED, LOW_ZETA)
    asked = perturb_start(build_question(source, cell, (3,)).variant.case(), 3)
    shown = make_start_variant(source, cell, 3, 7).case()
    scenario = shown.scenario.model_copy(update={"record_every": asked.scenario.record_every})
    assert shown._replace(scenario=scenario) == asked


def test_all_starts_lie_in_the_band():
    variant = replace(make_start_variant(PD, Condition(PRINTED, LOW_ZETA), None), duration_s=5e-3)
    seeds = (4, 5, 6)
    between = BandsQuestion(variant, seeds, 20).answer()
    assert (between.starts, len(between.time)) == (3, 20)
    runs = [extract_signals(simulate(replace(variant, seed=seed))) for seed in seeds]
    for name, band in between.bands.items():
        values = np.array([shoulder_signal(run, name) for run in runs])
        assert max(band.high) == pytest.approx(values.max(), rel=1e-9)
        assert min(band.low) == pytest.approx(values.min(), rel=1e-9)


@pytest.mark.parametrize("number", [4, 8, 14])
def test_beside_a_figure_stand_its_claims_as_they_were_judged(kept, number):
    shelf = shelf_in(kept, replace(BRIEF, longest_s=0.03))
    zeta = figures.ZETAS.get(number, figures.ZETA)
    found = find_figure_claims(shelf, number, zeta)
    assert [row.claim for row in found] == [c for c in CLAIMS if c.figure == number]
    for row in found:
        judged = shelf.context.judged_claims[row.claim.id]
        assert row.verdict == judged.verdict
        own = {a.place.law: a for a in judged.answers if _at(a.place, zeta, row.choice)}
        assert row.answers == own
        assert len(row.cells) == len(LAWS)
    assert any(row.answers for row in found)


def _at(place, zeta: float, choice: str) -> bool:
    if (place.arm, place.choice) != (LABELLED, choice):
        return False
    return place.law is None or (
        place.zeta == zeta and place.model == make_condition(place.law, zeta).model
    )


def test_a_figure_alone_asks_for_no_more_than_its_claims(tmp_path):
    """Fig. 4: what needs no run, and the PD run, which Eq. 5 could make diverge, by three laws."""
    study = Study(tmp_path)
    found = find_figure_claims(
        FigureData(AuditContext(study, BRIEF), has_verdicts=False), 4, figures.ZETA
    )
    assert {row.verdict for row in found} == {None}
    assert study.computed_count == 1 + len(LAWS)


def test_what_a_figure_alone_is_told_is_what_the_page_is_told(kept):
    material = AuditContext(Study(kept), BRIEF)
    page, alone = (FigureData(material, has_verdicts=whole) for whole in (True, False))
    both = zip(
        find_figure_claims(page, 16, LOW_ZETA), find_figure_claims(alone, 16, LOW_ZETA), strict=True
    )
    for own, same in require_items(both):
        assert own.answers == same.answers


def test_drive_work_of_a_rigid_turn():
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
        {"arm": load_arm(LABELLED).model_dump_json()},
    )
    energy, work = energy_peak(run)
    assert energy == TIME[-1]
    assert work == pytest.approx(5 * TIME[-1] ** 2)


def test_statics_of_a_pressed_mesh():
    """physics.md: under 100 N m x_sp lies near 52 um."""
    run = extract_signals(simulate(Variant("constant-torque", duration_s=1e-3)))
    assert static_numbers(run)["static_um"] == pytest.approx(52, abs=0.1)


@pytest.mark.parametrize("contact_ratio", [1.2, 1.5, 1.7])
def test_limits_give_the_fundamental_its_size(contact_ratio):
    low, high = stiffness_limits(1e8, 2e7, contact_ratio)
    row = ratio_row(contact_ratio, 1e8, 2e7)
    assert row.swing_N_per_m == high - low
    assert row.mean_N_per_m == pytest.approx(1e8)
    assert (row.phase_deg == 0) is (contact_ratio == 1.5)
    if contact_ratio == 1.5:
        assert row.swing_N_per_m == pytest.approx(np.pi * 2e7 / 2)


def test_eq6_pulls_where_nothing_touches():
    b, sigma = 50e-6, 2e5
    x = np.linspace(-3 * b, 3 * b, 3001)
    row = tanh_sharpness(x, b, sigma)
    inside = (x > 0) & (x < b)
    assert row.pull_m == -dead_zone_tanh(x[inside], b, sigma).min() > 0
    assert row.gap_m * sigma == pytest.approx(0.139, abs=1e-3)  # physics.md


def test_drawn_laws_are_deterministic(kept):
    shelf = shelf_in(kept)
    for draw in (draw_figure_4, draw_figure_5):
        plate = draw(shelf)
        assert plate.to_html([]) == draw(shelf).to_html([])
        assert all(svg.startswith("<svg") for svg, _ in plate.drawings)
    assert draw_figure_5(shelf).numbers["eq8_is_the_fundamental"] is True


def test_a_figure_says_how_many_starts_are_severe(kept):
    plate = draw_figure_14(shelf_in(kept))
    assert plate.numbers["severe"] == {name: [0, 0] for name in plate.numbers["severe"]}
    assert len(plate.numbers["severe"]) == len(LAWS)


def test_reduction_keeps_windows_and_extrema():
    generator = np.random.default_rng(3)
    data = generator.standard_normal((TIME.size, 2, 3))
    whole = xr.Dataset({"F_sp": (("time", "joint", "planet"), data)}, {"time": TIME})
    run = select_first_planets(whole)
    assert run.sizes["planet"] == 1
    small = reduce_run(run, {"third": (0.8, 0.85)}, bin_s=0.01)
    assert small.sizes["time"] < run.sizes["time"] / 5
    inside = small.sel(time=slice(0.8, 0.85 - 1e-9))
    assert inside.sizes["time"] == run.sel(time=slice(0.8, 0.85 - 1e-9)).sizes["time"]
    for begin in (0.0, 0.33, 1.19):
        part = slice(begin, begin + 0.01 - 1e-9)
        whole, kept = (r["F_sp"].sel(time=part).isel(planet=0) for r in (run, small))
        assert (kept.max("time") == whole.max("time")).all()
        assert (kept.min("time") == whole.min("time")).all()
    assert json.loads(small.attrs["windows_s"]) == {"third": [0.8, 0.85]}


def test_stored_runs_have_free_planets_and_the_scales_first_start():
    runs = select_stored_variants(Scale(first_seed=17)).items()
    geared = ((name, run) for name, run in runs if run.model == PhysicalModel.name)
    for name, variant in require_items(geared):
        assert (variant.seed, variant.planets) == (17, "free"), name


def test_shelf_reads_a_run_once(tmp_path):
    shelf = shelf_in(tmp_path)
    variant = make_start_variant(CONSTANT, Condition(INTEGRAL, LOW_ZETA), 1)
    first = shelf.load_courses({"one": variant}, 8)["one"]
    assert shelf.load_courses({"one": variant}, 9)["one"] is first
    assert (shelf.context.study.computed_count, shelf.context.study.cached_count) == (1, 0)
