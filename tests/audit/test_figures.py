"""The figures' chapter: what is drawn is what the claims were asked, and measures of known runs."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from crosscheck.analytic.paper.mesh_force import dead_zone_tanh
from crosscheck.analytic.paper.stiffness import square_wave_series
from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.study_plan import AuditContext
from crosscheck.audit.experiments.experiments import (
    BACK,
    BACKLASH,
    CONSTANT,
    ERROR,
    PD,
    build_question,
)
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, LAWS, PRINTED, Condition
from crosscheck.audit.experiments.samples import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant, perturb_start
from crosscheck.audit.figures import chapter as figures
from crosscheck.audit.figures.chapter import (
    draw_figure_4,
    draw_figure_5,
    stiffness_limits,
    tanh_sharpness,
)
from crosscheck.audit.figures.figure_data import (
    LOW_ZETA,
    FigureData,
    PaperFigure,
    make_condition,
    make_start_variant,
)
from crosscheck.audit.figures.plotting import Curve, Panel, draw_panels
from crosscheck.audit.figures.run_figures import braking_numbers, draw_figure_14, static_numbers
from crosscheck.audit.measures.run_signals import extract_signals
from crosscheck.models.errors import Diverged
from tests.audit.published import BRIEF
from tests.audit.runs import simulate

pytestmark = pytest.mark.slow


def shelf_in(folder: Path, scale: Scale = BRIEF) -> FigureData:
    return FigureData(AuditContext(Study(folder), scale))


def test_every_figure_has_its_plate_and_the_claims_about_it():
    assert tuple(range(4, 21)) == figures.NUMBERS
    named = {number: PaperFigure(number, []).claims for number in figures.NUMBERS}
    pairs = [(number, claim) for number, claims in named.items() for claim in claims]
    expected = [(claim.figure, claim.id) for claim in CLAIMS if claim.figure is not None]
    assert sorted(pairs) == sorted(expected)


@pytest.mark.parametrize("source", [PD, CONSTANT, BACKLASH(5), ERROR(1.6), BACK(100)], ids=str)
def test_what_is_drawn_is_a_start_of_what_the_claims_were_asked(source):
    cell = Condition(PRINTED, LOW_ZETA)
    asked = perturb_start(build_question(source, cell, (3,)).variant.case(), 3)
    shown = make_start_variant(source, cell, 3, 7).case()
    scenario = shown.scenario.model_copy(update={"record_every": asked.scenario.record_every})
    assert shown._replace(scenario=scenario) == asked


def test_numbers_beside_figures_are_the_shoulders():
    """physics.md: under 100 N m x_sp lies near 52 um, whatever the elbow bears."""
    apart = ("scenario.drive.torque_N_m=[100.0, -10.0]",)
    run = extract_signals(simulate(Variant("constant-torque", settings=apart, duration_s=1e-3)))
    assert static_numbers(run)["static_um"] == pytest.approx(52, abs=0.1)
    back = static_numbers(replace(run, theta_dot=-run.theta_dot))
    assert back == static_numbers(run)
    later = run.time > 5e-4
    turning = replace(run, torque=np.column_stack([1 - 2 * later, 2 * later - 1]))
    assert braking_numbers(turning)["brakes_s"] == run.time[later][0]


@pytest.mark.parametrize("contact_ratio", [1.2, 1.5, 1.7])
def test_limits_give_the_fundamental_its_size(contact_ratio):
    low, high = stiffness_limits(1e8, 2e7, contact_ratio)
    cycle = np.arange(360) / 360
    wave = square_wave_series(cycle, low, high, contact_ratio, 1)
    assert wave.mean() == pytest.approx(1e8)
    assert np.ptp(wave) / 2 == pytest.approx(2e7, rel=1e-3)  # a sample a degree
    if contact_ratio == 1.5:
        assert high - low == pytest.approx(np.pi * 2e7 / 2)


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
        assert plate.to_html() == draw(shelf).to_html()
        assert all(svg.startswith("<svg") for svg, _ in plate.drawings)
    both = [Curve([0.0, 1.0], [0.0, 1.0], "C0", name) for name in "ab"]
    drawn = [draw_panels(1.0, "x", [Panel(curves, {})]) for curves in (both, both[:1])]
    assert ["legend" in each for each in drawn] == [True, False]
    assert draw_figure_5(shelf).numbers["eq8_is_the_fundamental"] is True
    cells = re.findall(r"<td[^>]*>([^<]+)</td>", draw_figure_4(shelf).tables["sharpness"])
    for sigma, gap_um, product, pull_um in np.array(cells, dtype=float).reshape(-1, 4):
        assert gap_um * 1e-6 * sigma == pytest.approx(product, rel=1e-2)
        assert pull_um <= gap_um


def test_a_figure_says_how_many_starts_are_severe(kept):
    plate = draw_figure_14(shelf_in(kept))
    assert plate.numbers["severe"] == {name: [0, 0] for name in plate.numbers["severe"]}
    assert len(plate.numbers["severe"]) == len(LAWS)
    assert "b 50 µm, E 5 µm; k_m 1e+08 N/m, k_a 2e+07 N/m" in plate.to_html()


def test_a_figure_whose_run_diverges_says_so(tmp_path, monkeypatch):
    def diverge(data):
        raise Diverged("mine:run", 0.3)

    monkeypatch.setitem(figures.FIGURE_FUNCTIONS, 9, diverge)
    (plate,) = figures.draw_figures(shelf_in(tmp_path).context, [9])
    assert "mine:run: diverged at t = 0.3 s" in plate.to_html()


def test_a_figure_draws_the_start_of_its_seed(tmp_path, monkeypatch):
    shelf, drawn = shelf_in(tmp_path, replace(BRIEF, first_seed=7)), list[Variant]()

    def load(variants, _):
        drawn.extend(variants.values())
        return dict.fromkeys(variants)

    monkeypatch.setattr(shelf, "load_courses", load)
    shelf.courses_by_law(8, CONSTANT, PD)
    expected = {
        make_start_variant(each, make_condition(law), 7) for each in (CONSTANT, PD) for law in LAWS
    }
    assert set(drawn) == expected


@pytest.mark.parametrize(
    ("asked", "sampled"), [(ERROR(5), PD), (BACKLASH(50), PD), (ERROR(1.6), ERROR(1.6))], ids=str
)
def test_the_usual_member_of_a_sweep_is_the_pd_run(asked, sampled):
    context = SimpleNamespace(samples=lambda requests, name: {each: each for each in requests})
    requests = FigureData(context).samples_by_law(asked)
    assert list(requests) == list(LAWS)
    assert [request for _, request in requests.values()] == [sampled] * len(LAWS)


def test_shelf_reads_a_run_once(tmp_path):
    shelf = shelf_in(tmp_path)
    variant = make_start_variant(CONSTANT, Condition(INTEGRAL, LOW_ZETA), 1)
    first = shelf.load_courses({"one": variant}, 8)["one"]
    assert shelf.load_courses({"one": variant}, 9)["one"] is first
    assert first.time[-1] == pytest.approx(BRIEF.longest_s)
    assert (shelf.context.study.computed_count, shelf.context.study.cached_count) == (1, 0)


def test_the_chapter_of_figures_says_which_damping_they_have(monkeypatch):
    monkeypatch.setattr(figures, "draw_figures", lambda context, numbers: [])
    context = SimpleNamespace(scale=SimpleNamespace(first_seed=3))
    assert "Figures 8, 9, 11 to 14" in figures.build_chapter(context).html
