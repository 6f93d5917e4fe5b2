"""The pages in a real browser: no error, no request, every control works, in both themes."""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr

from crosscheck.checks.sampled import Subjects
from crosscheck.cli.view import view_page
from crosscheck.cost.output import cost_page
from crosscheck.cost.shortcuts import QUICK, compute_costs
from crosscheck.findings import Agreement
from crosscheck.identification.output import comparison_page
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import Case, load_scenario
from crosscheck.models.robot.file import load_robot
from crosscheck.models.trajectory import encode_netcdf
from crosscheck.planning import arms
from crosscheck.planning.checks import plan_checks
from crosscheck.planning.comparison import collect_tasks, judge_comparisons
from crosscheck.planning.plan import CrossCheckRequest, Experiment
from crosscheck.provenance import record_provenance
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.html import render_report_page
from crosscheck.report.trials.output import render_trial_page
from crosscheck.run import CrossCheck, cases_by_run, run_tasks, runs_by_key
from crosscheck.runner.progress_update import ignore_progress
from crosscheck.runner.tasks import RunKey
from crosscheck.runner.workers import Workers
from crosscheck.view.trajectory_file import read_run
from tests.arms import PAPER
from tests.loops import require_items
from tests.measured.records import compared, level, record_of
from tests.trial.trial_views import kept_arm
from tests.views.agreements import make_agreement, render_page

pytestmark = pytest.mark.system

NAMES = ("chromium", "chromium-browser", "google-chrome")
INSTALL = "no browser: apt-get install -y chromium"
DRAWING = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
REFERENCE, ENGINE, PRINTED = "analytic:physical", "exudyn:tree", "analytic:printed"
DURATION_S = 0.02
FAMILIES = ("same-step", "form", "deviation")
HOSTILE = '</script><img src="nowhere" onerror="fail()"><b>'  # would ask for a file, and fail
LOOKS = {"light": 390, "dark": 1280}
PAGES = ("report", "view", "compare", "cost", "trial")
SCREENS = ((1280, 900), (390, 844))
MOST_WORDS = 60  # of a page's answer; heat maps, drawings and the user's own lines are pictures
WORDS_IN_SIGHT = """() => {
  const first = document.querySelector(".first"), words = [];
  const walker = document.createTreeWalker(first, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode, parent = text.parentElement;
    if (parent.closest("script, style, svg, pre, .heat td, .heat th")) continue;
    const range = document.createRange();
    range.selectNodeContents(text);
    const places = [...range.getClientRects()].filter(r => r.width && r.height);
    if (parent.checkVisibility() && places.some(r => r.top < innerHeight && r.bottom > 0))
      words.push(...text.textContent.split(/\\s+/).filter(Boolean));
  }
  return words;
}"""
# A page goes on right below its answer: who sees blank paper there thinks that it ends [px].
SPACE_BELOW_ANSWER = """() => {
  const first = document.querySelector(".first"), end = first.lastElementChild;
  return first.nextElementSibling.getBoundingClientRect().top - end.getBoundingClientRect().bottom;
}"""
SMALLEST_LETTERS = """() => Math.min(...[...document.querySelectorAll(".scheme text")].map(
  text => parseFloat(getComputedStyle(text).fontSize) * text.getScreenCTM().a))"""
LEGIBLE_PX = 11
AXE = Path(__file__).with_name("axe.min.js")
# Of what passes axe would write a selector of every element, which takes longer than the rules.
WRONG_ALONE = {"resultTypes": ["violations"], "selectors": False}


class Made(NamedTuple):
    """A folder with a page of each kind, and the reference run as its file holds it."""

    folder: Path
    run: xr.Dataset

    def address(self, page: str) -> str:
        """Of a page, on disk."""
        return (self.folder / f"{page}.html").as_uri()


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """The report of 20 ms of one experiment, and the page of its reference run."""
    scenario = load_scenario("pd").model_copy(update={"duration_s": DURATION_S})
    arm = PAPER.model_copy(update={"title": HOSTILE})
    wanted = CrossCheckRequest(arm, quick=True)
    of_runs = arms.plan_experiment_comparisons(Experiment("pd", Case(arm, scenario, switches())))
    asked = [each for each in of_runs if each.about.key.family in FAMILIES]
    models = list(arms.sample_arm(arm, arms.QUICK_COUNT, 0))
    of_states, _ = plan_checks(Subjects(arms=models))
    asked += [each for each in of_states if each.about.key.quantity == "mass_matrix"]
    with Workers(1) as workers:
        results = run_tasks(workers, collect_tasks(asked), ignore_progress)
    agreement = Agreement(
        list(judge_comparisons(asked, results)),
        record_provenance(arm, 0, True),
        entries=tuple(arms.compute_entry_differences(arm, models, results)),
    )
    checked = CrossCheck(wanted, agreement, cases_by_run(asked), runs_by_key(results))
    folder = tmp_path_factory.mktemp("pages")
    (folder / "report.html").write_text(render_report_page(checked), encoding="utf-8")
    robot = render_page("robot", make_agreement("robot", False, 1))
    (folder / "robot.html").write_text(robot, encoding="utf-8")
    record = record_of(level(arm, "coupled"), rows=1000)
    (folder / "compare.html").write_text(comparison_page(compared(record, arm)), encoding="utf-8")
    cost = compute_costs(load_robot("sliding"), 0, QUICK, lambda *doing: None)
    (folder / "cost.html").write_text(cost_page(cost), encoding="utf-8")
    (folder / "trial.html").write_text(render_trial_page(kept_arm()), encoding="utf-8")
    run = checked.runs[RunKey("pd", REFERENCE)]
    (folder / "run.nc").write_bytes(encode_netcdf(run))
    (folder / "view.html").write_text(view_page(read_run(folder / "run.nc")), encoding="utf-8")
    return Made(folder, xr.load_dataset(folder / "run.nc", engine="h5netcdf"))


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """The system's Chromium."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        assert "CI" not in os.environ, INSTALL
        pytest.skip(INSTALL)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=list(DRAWING))
        yield chromium
        chromium.close()


@pytest.fixture
def opened(browser: Any, made: Made) -> Iterator[Any]:
    """``opened(name, theme, width)``; nothing may be wrong with it at the end."""
    contexts, found = [], []

    def open_page(name: str, theme: str = "light", width: int = 1280, **more: Any) -> Any:
        size = {"width": width, "height": 900}
        context = browser.new_context(viewport=size, color_scheme=theme, **more)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda said: found.append(f"console: {said.text}"))
        page.on("pageerror", lambda error: found.append(f"error: {error}"))
        page.on("request", lambda asked: found.append(f"request: {asked.url}"))
        page.goto(made.address(name))
        return page

    yield open_page
    for context in contexts:
        context.close()
    own = ("request: file:", "request: blob:", "request: data:")
    assert [line for line in found if not line.startswith(own)] == []
    assert sum(line.startswith("request: file:") for line in found) == len(contexts)


def shown(page: Any, plot: int, line: int) -> np.ndarray:
    """(time, value) of what a plot shows of a line between its ends."""
    script = """([plot, line]) => {
      const u = document.getElementById("signals").plots()[plot];
      return [Array.from(u.data[0]), Array.from(u.data[line]), u.scales.x.min, u.scales.x.max];
    }"""
    time, values, low, high = page.evaluate(script, [plot, line])
    table = np.array([time, values])
    return table[:, (table[0] >= low - 1e-12) & (table[0] <= high + 1e-12)]


def test_a_zoom_to_a_millisecond_shows_the_files_peak(opened, made):
    """Of the start's impact: the largest mesh force of the run, as the NetCDF file has it."""
    page = opened("report")
    force = made.run["F_sp"].values[:, 0, 0]
    peak = int(np.abs(force).argmax())
    at = float(made.run["time"].values[peak])
    begin = max(at - 5e-4, 0.0)
    page.evaluate(
        "([a, b]) => document.getElementById('signals').zoom(a, b)", [begin, begin + 1e-3]
    )
    time, values = shown(page, 0, 1)
    assert time[0] == pytest.approx(begin, abs=1e-4)
    assert time[-1] == pytest.approx(begin + 1e-3, abs=1e-4)
    assert np.abs(values).max() == pytest.approx(abs(force[peak]), rel=1e-7)  # float32
    assert time[np.abs(values).argmax()] == pytest.approx(at, abs=1e-9)


def test_ticks_of_time_differ_however_close_the_zoom(opened):
    page = opened("report")
    for wide in (1e-2, 1e-3, 1e-4, 2e-5):
        page.evaluate("w => document.getElementById('signals').zoom(0.003, 0.003 + w)", wide)
        page.wait_for_timeout(50)
        ticks = page.evaluate("document.getElementById('signals').plots()[0].axes[0]._values")
        assert len(ticks) > 2
        assert len(set(ticks)) == len(ticks)


def test_the_lower_plot_is_the_difference_on_the_same_axis(opened, made):
    page = opened("report")
    page.get_by_role("button", name="zoom in").click()
    (above, reference), (_, engine) = shown(page, 0, 1), shown(page, 0, 2)
    below, apart = shown(page, 1, 1)
    assert np.array_equal(above, below)
    size = np.abs(made.run["F_sp"].values).max()
    assert np.allclose(reference + apart, engine, rtol=0, atol=1e-6 * size)  # sums of float32


def test_models_signals_and_joints_can_be_chosen(opened):
    page = opened("report")
    boxes = page.locator("#models input")
    rigid = [f"pinocchio:{level}" for level in RIGID_LEVELS]
    expected = [REFERENCE, ENGINE, PRINTED, *rigid]
    assert [box.get_attribute("name") for box in boxes.all()] == expected
    assert [box.is_enabled() for box in boxes.all()] == [True] * 3 + [False] * 4  # no mesh forces
    boxes.nth(2).uncheck()
    last = "document.getElementById('signals').plots().map(u => u.series.at(-1).show)"
    assert page.evaluate(last) == [False, False]
    page.locator("#quantity").select_option("theta")
    assert page.evaluate(last) == [False, False]
    boxes.last.check()
    assert page.evaluate(last) == [True, True]
    assert "pinocchio:coupled differs by at most" in page.locator("#said").inner_text()
    page.locator("#joint").select_option("2")
    assert page.locator(".u-title").first.inner_text() == "theta of joint 2, pd"
    assert "joint angle" in page.locator("#said").inner_text()
    page.locator("#windows button").first.focus()
    before = page.locator("#span").inner_text()
    page.keyboard.press("Enter")
    assert page.locator("#span").inner_text() != before
    page.keyboard.press("Shift+Tab")  # on the last of the buttons before
    assert page.evaluate("document.activeElement.id") == "later"


def test_the_cursor_tells_value_and_unit(opened):
    page = opened("report")
    page.locator("#overlay .u-over").hover()
    legend = "document.querySelector('#overlay .u-legend').innerText"
    page.wait_for_function(f"{legend}.includes(' N')")
    text = page.evaluate(legend)
    assert text.count(" N") == 3
    assert " s" in text


def test_findings_are_filtered_by_words_and_outcome(opened):
    page = opened("report")
    total = len(page.locator("#findings details tr:has(td)").all())
    assert page.locator("#matches").inner_text() == f"{total} of {total} shown"
    assert not page.locator("#findings details tr:has(td)").first.is_visible()
    page.locator("#words").fill("theta tree")
    rows = [row for row in page.locator("#findings details tr:has(td)").all() if row.is_visible()]
    assert 0 < len(rows) < total
    assert all("theta" in row.inner_text() and "tree" in row.inner_text() for row in rows)
    assert page.locator("#matches").inner_text() == f"{len(rows)} of {total} shown"
    page.locator("#words").fill("")
    page.locator("#findings input[value=agree]").uncheck()
    count = page.locator("#findings label.agree").inner_text().split()[0]
    assert page.locator("#matches").inner_text() == f"{total - int(count)} of {total} shown"


def test_a_link_leads_to_each_finding_and_to_each_section_and_back(opened):
    page = opened("report")
    link = page.locator("#findings .findings a:not([id])").first
    link.click()
    assert page.locator(f"#findings details [id='{link.inner_text()}']").is_visible()
    places = [each.get_attribute("id") for each in page.locator("h2[id]").all()]
    links = [each.get_attribute("href") for each in page.locator("#contents a").all()]
    assert links == [f"#{place}" for place in places]
    assert page.locator(".back").count() == len(places)


@pytest.mark.parametrize(
    ("name", "picture"),
    [
        ("report", ".heat"),
        ("robot", ".first svg"),
        ("trial", ".heat"),
        ("cost", ".first svg"),
        ("compare", ".first svg"),
    ],
)
def test_the_first_screen_answers_in_few_words(opened, name, picture):
    page = opened(name)
    for width, height in require_items(SCREENS):
        page.set_viewport_size({"width": width, "height": height})
        words = page.evaluate(WORDS_IN_SIGHT)
        answer = page.locator(".answer").first.inner_text().split()
        assert "".join(answer) in "".join(words)
        assert page.locator(picture).first.is_visible()
        assert len(words) <= MOST_WORDS, words
        assert name not in ("cost", "robot") or page.evaluate(SMALLEST_LETTERS) >= LEGIBLE_PX
    page.set_viewport_size({"width": 1280, "height": 1600})
    assert page.evaluate(SPACE_BELOW_ANSWER) < 100


def test_folds_open_and_paper_gets_the_still_picture(opened):
    page = opened("report")
    fold = page.locator("details").last
    fold.locator("summary").press("Enter")
    assert fold.evaluate("fold => fold.open")
    assert not page.locator(".still").is_visible()
    page.emulate_media(media="print")
    assert page.locator(".still").is_visible()
    assert not page.locator("#signals").is_visible()


def test_without_scripts_the_still_picture_stands_in(opened):
    page = opened("report", java_script_enabled=False)
    assert page.locator(".still").is_visible()
    assert not page.locator("#signals").is_visible()


def test_the_run_plays_and_the_mesh_opens(opened, made):
    page = opened("view")
    page.wait_for_function("window.view && window.view.drawn > 3")
    assert not page.locator("#no-webgl").is_visible()
    page.locator("#play").click()
    page.locator("#time").fill("100")
    page.wait_for_function("document.getElementById('now').textContent.startsWith('0.01000 s')")
    force, x = (float(made.run[name].values[100, 0, 0]) for name in ("F_sp", "x_sp"))
    text = page.locator("#gap").inner_text()
    mesh = PAPER.joints[0].sun_mesh
    phase = PAPER.joints[0].ring_teeth * float(made.run["theta"].values[100, 0])
    gap = x - mesh.tooth_error_m * np.sin(phase)
    assert f"e = {1e6 * gap:.2f} µm" in text
    assert f"{1e6 * (abs(gap) - mesh.backlash_m):.2f} µm beyond" in text or force == 0
    assert f"F = {float(f'{force:.4g}'):g} N" in text.replace(".0 N", " N")
    forces = made.run["F_sp"].values[:, 0, 0]
    words = page.locator("#charted").inner_text().replace(" N", "").split()
    value, low, most, begin, end = (
        float(words[place].strip(";")) for place in (-9, -8, -6, -4, -2)
    )
    assert value == pytest.approx(force, rel=1e-3)
    rounding = 1e-7 * float(forces.max())  # of the page's numbers of single precision
    ends = [forces.min(), forces.max()]
    assert [low, most] == pytest.approx(ends, rel=1e-3, abs=rounding)
    assert [begin, end] == [0, DURATION_S]
    page.locator("#strip").click(position={"x": 0, "y": 9})
    page.wait_for_function("document.getElementById('now').textContent.startsWith('0.00000 s')")
    before = page.locator("#arm").screenshot()
    page.locator("#arm").press("ArrowLeft")
    page.locator("#target").select_option("0")
    page.wait_for_function("!window.view.dirty")
    assert page.locator("#arm").screenshot() != before


@pytest.mark.parametrize("name", PAGES)
def test_no_page_scrolls_sideways_or_shuts_anyone_out(opened, name):
    """In both themes and widths, all that is folded opened; what axe-core finds."""
    for theme, width in require_items(LOOKS.items()):
        page = opened(name, theme, width, reduced_motion="reduce")
        page.evaluate("document.querySelectorAll('details').forEach(d => { d.open = true; })")
        wide = page.evaluate("document.documentElement.scrollWidth")
        assert wide <= width, (theme, width)
        page.add_script_tag(path=AXE)
        rules = {"runOnly": ["color-contrast"]} if theme == "dark" else {}
        found = page.evaluate("options => axe.run(document, options)", WRONG_ALONE | rules)
        violations = {
            each["id"]: [node["html"][:120] for node in each["nodes"][:3]]
            for each in found["violations"]
        }
        assert violations == {}, theme
