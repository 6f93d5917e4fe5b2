"""Every number of a cross-check's views, read back and worked out again from the records.

The records are values at states, trajectories and findings of a small run; here they meet numpy
alone. A few findings are made anew on either side of their tolerance, so that each verdict occurs.
"""

import base64
import html
import io
import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stdout
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr
from jinja2 import BytecodeCache
from jinja2.bccache import Bucket
from matplotlib.figure import Figure

from crosscheck import findings as finding_makers
from crosscheck.findings import Agreement, Finding
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.loading import Case, load_arm, load_scenario
from crosscheck.planning import arms
from crosscheck.planning.arms import plan_experiment_comparisons
from crosscheck.planning.comparison import Results, collect_tasks, judge_comparisons
from crosscheck.planning.plan import CrossCheckRequest, Experiment
from crosscheck.provenance import record_provenance
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report import answers, junit, rendering, terminal
from crosscheck.report import html as html_view
from crosscheck.report.plots import figures, signals
from crosscheck.report.plots.charts import Charts, Pictures
from crosscheck.run import CrossCheck, cases_by_run, runs_by_key
from crosscheck.runner.tasks import Evaluation, RunKey
from crosscheck.view import scene
from crosscheck.view.trajectory_file import Run
from tests.faults.robot_views import robot_report_numbers
from tests.judged import plan_states

ARM, STATES, SEED = "probe", 3, 0
STATE_FAMILIES, RUN_FAMILIES = ("states", "form-states"), ("same-step", "form", "deviation")
LEAD, SECOND, PRINTED = "analytic:physical", "exudyn:tree", "analytic:printed"
ENGINES = ("pinocchio:gears", "exudyn:tree", "exudyn:bodies")
START = {
    "theta_rad": [0.3, -0.8],
    "theta_dot_rad_per_s": [0.6, -0.9],
    "sun_planet_offset_m": [2e-6, 5e-6],
    "planet_ring_offset_m": [-3e-6, 4e-6],
}
WORST = ("failed", "differ", "unfinished", "unresolved", "agree")
WORDS = {"mass matrix": "mass_matrix", "acceleration": "acceleration", "joint angle": "theta"}
WORDS |= {"mesh force": "F_sp"}
UNITS = {"m": 1.0, "mm": 1e-3, "µm": 1e-6}


class Records(NamedTuple):
    """What the small run left: answers by model and quantity, runs, findings, pictures."""

    arm: Arm
    results: Results
    values: dict[tuple[str, str], np.ndarray]
    runs: dict[str, xr.Dataset]
    findings: list[Finding]
    result: CrossCheck
    pictures: Pictures


def moving_scenario() -> Scenario:
    """2 ms of PD control from a start in motion."""
    grid = {"duration_s": 2e-3, "step_s": 1e-5, "record_every": 5, "start": START}
    own = load_scenario("pd").model_dump()
    return Scenario.model_validate({**own, **grid})


@lru_cache
def records() -> Records:
    """The records of the probe arm, whose numbers are all unequal; made once."""
    arm = printed_arm()
    asked = [c for c in plan_states(arm, STATES, SEED) if of_views(c.about.key)]
    own = plan_experiment_comparisons(Experiment("pd", Case(arm, moving_scenario(), laws(arm))))
    asked += [c for c in own if c.about.key.family in RUN_FAMILIES]
    charts, outcomes = Charts(), dict[Any, Any]()
    for task in collect_tasks(asked):
        outcomes[task.key] = task.perform()
        charts.show(task.key, outcomes[task.key])
    results = Results(outcomes)
    values = {
        (key.model, key.quantity): outcome
        for key, outcome in outcomes.items()
        if isinstance(key, Evaluation)
    }
    runs = {k.model: r for k, r in runs_by_key(results).items() if k == RunKey("pd", k.model)}
    found = list(judge_comparisons(asked, results))
    result = CrossCheck(
        CrossCheckRequest(arm, True, SEED),
        Agreement(found),
        cases_by_run(asked),
        runs_by_key(results),
    )
    return Records(arm, results, values, runs, found, result, charts.build_pictures())


def printed_arm() -> Arm:
    """The probe arm as the paper's equations cover it: three planets, no gravity, no friction."""
    own = load_arm(ARM)
    alike = {"planet_count": 3, "friction_N_m_s_per_rad": 0.0}
    joints = []
    for joint in own.joints:
        sun = joint.sun_mesh.model_copy(update={"static_error_m": 3e-6})
        ring = joint.ring_mesh.model_copy(update={"static_error_m": -2e-6, "backlash_m": 7e-5})
        joints.append(joint.model_copy(update={**alike, "sun_mesh": sun, "ring_mesh": ring}))
    return own.model_copy(update={"joints": tuple(joints), "gravity_m_per_s2": (0.0, 0.0)})


def laws(arm: Arm) -> Switches:
    """The usual switches."""
    return usual_switches(arm)


def of_views(key: Any) -> bool:
    """Whether a comparison of states is among those that the views show here."""
    where = (f"{ARM}/geared", *(f"{ARM}/{level}" for level in RIGID_LEVELS))
    return key.family in STATE_FAMILIES and key.case in where


def agreement_of(made: Records) -> Agreement:
    """The small run's Agreement, its entries worked out now, with checks of every verdict."""
    engines = [f for f in made.findings if f.kind == "check" and {f.left, f.right} < {*ENGINES}]
    first, second, third, fourth = engines[:4]
    checked = finding_makers.make_check
    beyond = checked(first.about, measured=3.3e-9, tolerance=2.2e-12, basis="made anew")
    within = checked(second.about, measured=1.1e-13, tolerance=2.2e-12, basis="made anew")
    unresolved = checked(
        third.about, measured=1e-13, tolerance=4.4e-12, basis="made anew", resolved=False
    )
    anew = {first: beyond, second: within, third: unresolved}
    anew[fourth] = finding_makers.make_failed_check(fourth.about, "made anew")
    by_id = {old.id: new for old, new in anew.items()}
    found = [by_id.get(f.id, f) for f in made.findings]
    models = arms.sample_arm(made.arm, STATES, SEED)
    entries = tuple(arms.compute_entry_differences(made.arm, models, made.results))
    return Agreement(found, record_provenance(made.arm, SEED, True), entries=entries)


class Views(NamedTuple):
    """The views of one Agreement."""

    agreement: Agreement
    terminal: str
    json: dict[str, Any]
    page: str
    junit: str


def views_of(made: Records) -> Views:
    """Terminal, JSON, page and JUnit."""
    agreement, out = agreement_of(made), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out):
        patch.setenv("COLUMNS", "250")
        terminal.print_answers(agreement, made.arm)
    data = json.loads(answers.format_agreement_json(agreement, made.arm))
    result = CrossCheck(made.result.request, agreement, made.result.cases, made.result.runs)
    with fresh_templates():
        page = html_view.render_report_page(result, made.pictures)
    return Views(agreement, out.getvalue(), data, page, junit.format_junit(agreement))


class CompiledTexts(BytecodeCache):
    """Code of templates by name and text: filters are looked up when it runs."""

    def __init__(self) -> None:
        self.kept: dict[str, bytes] = {}

    def load_bytecode(self, bucket: Bucket) -> None:
        """Fill the bucket with what is kept of its text."""
        if bucket.key + bucket.checksum in self.kept:
            bucket.bytecode_from_string(self.kept[bucket.key + bucket.checksum])

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep the bucket's code."""
        self.kept[bucket.key + bucket.checksum] = bucket.bytecode_to_string()


COMPILED_TEXTS = CompiledTexts()


@contextmanager
def fresh_templates() -> Iterator[None]:
    """Templates that have the filters as they are, and leave none behind."""
    forget = getattr(rendering.load_templates, "cache_clear", lambda: None)
    forget()
    rendering.load_templates().bytecode_cache = COMPILED_TEXTS
    yield
    forget()


def report_numbers(seen: object = None) -> str:
    """Whether every number of the report's views is that of the records."""
    return "differ" if any(report_problems()) else "agree"


def report_problems() -> Iterator[str]:
    """What in the views of the report is not as the records have it."""
    made = records()
    views = views_of(made)
    yield from finding_problems(views)
    yield from matrix_problems(views)
    yield from map_problems(views, made)
    yield from answer_problems(views, made)
    yield from level_problems(views, made)


def cells_of(row: str) -> list[str]:
    """The texts of a table row's cells."""
    inside = re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, flags=re.S)
    return [html.unescape(re.sub(r"<[^>]*>", " ", cell)).strip() for cell in inside]


def rows_of(text: str) -> list[list[str]]:
    """The rows of the tables in a piece of a page."""
    return [cells_of(row) for row in re.findall(r"<tr>(.*?)</tr>", text, flags=re.S)]


def heads_of(text: str) -> list[list[str]]:
    """The rows of a piece of a page that head columns."""
    return rows_of("".join(re.findall(r"<tr>(?:<th>[^<]*</th>)+</tr>", text)))


def group_problems(listed: str, agreement: Agreement) -> Iterator[str]:
    """Of the groups of findings: which are open, and the order in each."""
    by_id = {finding.id: finding for finding in agreement.findings}
    listed_ids = []
    for fold, inside in re.findall(r"<details( open)?>(.*?)</details>", listed, re.S):
        found = [by_id[row[0].split()[0]] for row in rows_of(inside) if row[-1] != "verdict"]
        listed_ids += [finding.id for finding in found]
        failed = [f for f in found if f.kind == "check" and f.verdict != "agree"]
        if bool(fold) != bool(failed) or found[: len(failed)] != [f for f in found if f in failed]:
            yield f"{found[0].id}: failures are not shown first"
        shares = [f.measured / f.tolerance for f in found if f.verdict == "agree" and f.tolerance]
        if shares != sorted(shares, reverse=True):
            yield f"{found[0].id}: not the tightest first"
    if sorted(listed_ids) != sorted(by_id):
        yield "the groups do not hold every finding once"


def is_rounded(text: str, value: float, digits: int) -> bool:
    """Whether a text has a value's digits."""
    try:
        return bool(np.isclose(float(text), float(f"{value:.{digits}g}"), rtol=1e-12, atol=0))
    except ValueError:
        return False


def verdict_of(measured: float | None, tolerance: float | None, note: str) -> str:
    """The verdict that measured and tolerance demand."""
    if measured is None:
        return "failed"
    return "measured" if tolerance is None else "agree" if measured <= tolerance else "differ"


def finding_problems(views: Views) -> Iterator[str]:
    """Of the page's, JSON's and JUnit's findings, one by one."""
    listed = views.page.partition("by pair of models</h3>")[2].partition("<h2")[0]
    rows = {row[0].split()[0]: row for row in rows_of(listed) if row[-1] != "verdict"}
    yield from group_problems(listed, views.agreement)
    columns = ["check, and where its tolerance comes from", "measured", "tolerance", "share"]
    if any(head != [*columns, "verdict"] for head in heads_of(listed)) or not heads_of(listed):
        yield f"findings under {heads_of(listed)}"
    records_json = {each["id"]: each for each in views.json["findings"]}
    messages = dict(re.findall(r'name="([^"]*)" time="0">.*?message="([^"]*)"', views.junit, re.S))
    for f in views.agreement.findings:
        row, data = rows[f.id], records_json[f.id]
        expected = verdict_of(f.measured, f.tolerance, f.note)
        expected = "unresolved" if f.verdict == "unresolved" and expected == "agree" else expected
        if {row[4], data["verdict"], f.verdict} != {expected}:
            yield f"{f.id}: verdict {row[4]}, {data['verdict']}, {f.verdict}; is {expected}"
        number, _, unit = row[1].partition(" ")
        for text, name in ((number, "measured"), (row[2], "tolerance")):
            value = getattr(f, name)
            if data[name] != value or (text != "" if value is None and f.unit == "1" else False):
                yield f"{f.id}: JSON's {name}"
            if value is not None and not is_rounded(text, value, 3):
                yield f"{f.id}: {name} {text}, is {value}"
        written = f.unit.replace(" s-1", "/s").replace(" s-2", "/s²")
        if f.measured is not None and unit != ("" if f.unit == "1" else written):
            yield f"{f.id}: unit {unit}"
        if " ".join(row[0].split()[1:]) != " ".join(f"{f.basis} {f.note}".split()):
            yield f"{f.id}: reason {row[0]}"
        if f.measured is not None and f.tolerance:
            share = f.measured / f.tolerance
            number, unit = row[3].split()
            if not is_rounded(number, share * {"%": 100, "times": 1}[unit], 2):
                yield f"{f.id}: share {row[3]}, is {share}"
    red = [f for f in views.agreement.findings if f.verdict in WORST[:4]]
    if Counter(views.terminal.count(f" {f.id}: ") for f in red) != {1: len(red)}:
        yield "the terminal's list of disagreements"
    for f in red:
        said = f"measured {f.measured:.3g}, allowed {f.tolerance:.3g}" if f.tolerance else f.note
        if f.verdict == "unresolved":
            said = f"the uncertainty itself, {f.tolerance:.3g}"
        if said not in views.terminal.partition(f" {f.id}: ")[2].partition("\n")[0]:
            yield f"{f.id}: not in the terminal as {said}"
    failures = re.findall(r'<testsuites tests="(\d+)" failures="(\d+)" errors="(\d+)"', views.junit)
    checks = [f for f in views.agreement.findings if f.kind == "check"]
    errors = sum(f.verdict == "failed" for f in checks)
    if failures != [(str(len(checks)), str(len(red) - errors), str(errors))]:
        yield f"JUnit counts {failures}"
    if sum(f"{f.verdict}: " in " ".join(messages.values()) for f in red) != len(red):
        yield "JUnit's messages"


def matrix_problems(views: Views) -> Iterator[str]:
    """Of the table of pairs in the terminal, and of the same on the page."""
    pairs: dict[tuple[str, str], list[Finding]] = {}
    for f in views.agreement.findings:
        family = f.about.key.family
        if f.about.key.right and (f.kind == "check" or family.startswith("form")):
            pairs.setdefault(tuple(sorted((f.left, f.right))), []).append(f)
    words = {"states": "at states", "form-states": "at states", "form": "over runs"}
    words |= {"same-step": "over runs"}
    flat = re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]*>", " ", views.page)))
    for (left, right), found in pairs.items():
        line = re.search(
            rf"^ *{left} +{right} +(\S+) +(no limit|\d+) +(.*?) *$", views.terminal, re.M
        )
        if line is None:
            yield f"{left}, {right}: not in the terminal"
            continue
        checks = [f for f in found if f.kind == "check"]
        expected = min((f.verdict for f in checks), key=WORST.index, default="differ")
        if (line[1], line[2]) != (expected, str(len(checks)) if checks else "no limit"):
            yield f"{left}, {right}: {line[1]}, {line[2]}; is {expected}, {len(checks)}"
        worst: dict[str, float] = {}
        for f in found:
            if f.about.key.family in words and f.relative is not None:
                family = words[f.about.key.family]
                worst[family] = max(worst.get(family, 0.0), f.relative)
        common = {w: min(16.0, max(0.0, -np.log10(max(v, 1e-16)))) for w, v in worst.items()}
        said = ", ".join(f"{value:.1f} {family}" for family, value in common.items())
        if line[3] != said:
            yield f"{left}, {right}: {line[3]}; is {said}"
        on_page = f"{expected} " + " ".join(f"{v:.1f} digits {w}" for w, v in common.items())
        if on_page not in flat:
            yield f"{left}, {right}: the page has no {on_page}"


def entry_table(made: Records, model: str, quantity: str = "mass_matrix") -> np.ndarray:
    """Largest difference of M's entries from any engine, over the root of M_ii M_jj."""
    own = made.values[model, quantity]
    size = np.sqrt(np.diagonal(own, axis1=1, axis2=2))
    size = size[:, :, None] * size[:, None, :]
    apart = [np.abs(own - made.values[engine, quantity]) / size for engine in ENGINES]
    return np.max(apart, axis=(0, 1))


def cell_text(value: float, tolerance: float) -> str:
    """What a cell of a map must show."""
    return "✓" if value <= tolerance else f"{float(f'{100 * value:.2g}'):.15g} %"


def map_problems(views: Views, made: Records) -> Iterator[str]:
    """Of the picture of M, printed beside corrected, in page and JSON; of the list beside it."""
    tables = re.findall(r'<table class="heat.*?</table>', views.page, flags=re.S)
    told = views.json["answers"]["equations"]["entries"]
    names = tuple(told[0]["coordinates"])
    if names != ("x_sp1", "x_pr1", "theta_1", "x_sp2", "x_pr2", "theta_2"):
        yield f"coordinates {names}"
    if len(tables) != 2:
        yield f"{len(tables)} maps"
    wrong: dict[str, float] = {}
    for model, title, table in zip(
        (PRINTED, LEAD), ("as printed", "corrected"), tables, strict=False
    ):
        expected, allowed = entry_table(made, model), 1000 * np.finfo(float).eps
        rows = rows_of(table)
        if f"mass matrix, {title}" not in table or rows[0][1:] != list(names):
            yield f"{title}: names of the columns"
        if [row[0] for row in rows[1:]] != list(names):
            yield f"{title}: names of the rows"
        texts = [[cell_text(value, allowed) for value in row] for row in expected]
        if [row[1:] for row in rows[1:]] != texts:
            yield f"{title}: cells {rows[1:]}; are {texts}"
        (data,) = (
            each for each in told if (each["model"], each["quantity"]) == (model, "mass_matrix")
        )
        if not np.allclose(data["relative"], expected, rtol=1e-9, atol=0):
            yield f"{title}: JSON's entries"
        if data["engines"] != list(ENGINES) or not np.isclose(data["tolerance"], allowed):
            yield f"{title}: JSON's engines or tolerance"
        if model == PRINTED:
            for i, j in np.argwhere(expected > allowed):
                if i <= j:
                    name = f"M[{names[i]}, {names[j]}]"
                    wrong[name] = max(expected[i, j], expected[j, i])
        elif (expected > allowed).any():
            yield "the corrected equations differ"
    ordered = sorted(wrong.items(), key=lambda item: -item[1])
    largest, share = ordered[0]
    said = (
        f"The printed equations are wrong in {len(wrong)} places (largest {largest},"
        f" {cell_text(share, 0)}); "
    )
    checks = [f for f in views.agreement.findings if f.kind == "check"]
    red = [f for f in checks if verdict_of(f.measured, f.tolerance, "") != "agree"]
    red += [f for f in checks if f.verdict == "unresolved"]
    said += f"{len(red)} of {len(checks)} checks do not agree ("
    lines = views.terminal.strip().splitlines()
    places = (lines[0], lines[-1], views.json["answers"]["verdict"])
    on_page = re.search(r'class="answer"><strong>(.*?)</strong>', views.page)
    for place in (*places, html.unescape(on_page[1]) if on_page else ""):
        if not place.startswith(said) or place != places[0]:
            yield f"verdict: {place}; is {said}"


def others_of(model: str) -> str:
    """The package of a model."""
    return model.partition(":")[0]


def largest_apart(made: Records, model: str, quantity: str) -> float:
    """The largest difference of a model from any engine, from values and trajectories."""
    if quantity == "mass_matrix":
        return float(entry_table(made, model).max())
    if quantity == "acceleration":
        own = made.values[model, quantity]
        size = np.sqrt((own**2).mean(axis=0))
        apart = [np.abs(own - made.values[engine, quantity]) / size for engine in ENGINES]
        return float(np.max(apart))
    one, other = (made.runs[name][quantity].values for name in (model, SECOND))
    return float(np.nanmax(np.abs(one - other)))


def is_amount(text: str, value: float) -> bool:
    """Whether a text has a difference in per cent, with a unit, or as a tiny number."""
    number, _, unit = text.partition(" ")
    if unit == "%":
        return is_rounded(number, 100 * value, 2)
    return is_rounded(number, value, 2 if unit else 1)


def answer_problems(views: Views, made: Records) -> Iterator[str]:
    """Of the answers to the three questions, in words and in the first table."""
    section = views.page.partition('<h2 id="equations">')[2].partition("</table>")[0]
    rows = {row[0].split()[0]: row for row in rows_of(section) if row and row[0]}
    for model in (PRINTED, "analytic:energies", LEAD):
        row = rows[model]
        for column, quantity in enumerate(WORDS.values(), 2):
            expected = largest_apart(made, model, quantity)
            if not is_amount(row[column], expected):
                yield f"{model}, {quantity}: {row[column]}; is {expected}"
        if model != LEAD and row[1] != "differ":
            yield f"{model}: {row[1]}"
    for each in views.json["answers"]["equations"]["models"]:
        for difference in each["differences"]:
            if others_of(each["model"]) == "analytic" and each["model"] in (PRINTED, LEAD):
                expected = largest_apart(made, each["model"], difference["quantity"])
                if not np.isclose(difference["measured"], expected, rtol=1e-9, atol=0):
                    yield f"JSON, {each['model']}, {difference['quantity']}"
    text = views.json["answers"]["equations"]["answer"]
    first = text.partition("The paper's equations of motion")[2]
    for amount, word in re.findall(rf"([\d.e-]+ ?\S*) in ({'|'.join(WORDS)})", first):
        if not is_amount(amount, largest_apart(made, PRINTED, WORDS[word])):
            yield f"answer 1: {amount} in {word}"
    clean = [
        f.relative
        for f in views.agreement.findings
        if (f.kind, f.about.key.family) == ("check", "states") and "analytic" in f.left
    ]
    digits = re.search(r"to (\d+) digits", text)
    least = min(-np.log10(max(relative or 0.0, 1e-16)) for relative in clean)
    if digits is None or int(digits[1]) != int(least):
        yield f"digits {digits[1]}; are {least}"
    yield from count_problems(views)


def count_problems(views: Views) -> Iterator[str]:
    """Of the counts of the third answer and the last lines."""
    checks = [f for f in views.agreement.findings if f.kind == "check"]
    good = sum(f.verdict == "agree" for f in checks)
    pairs = sum(bool(f.about.key.right) for f in checks)
    rest = len(views.agreement.findings) - len(checks)
    said = views.json["answers"]["trust"]["answer"]
    counted = r"^(\d+) of (\d+) checks agree"
    rest_of = r".*? (\d+) compare two .*? (\d+) compare one .*? (\d+) more"
    numbers = re.findall(counted + rest_of, said)
    expected = [tuple(map(str, (good, len(checks), pairs, len(checks) - pairs, rest)))]
    if numbers != expected:
        yield f"answer 3: {numbers}; is {expected}"
    if f"\n{good} of {len(checks)} checks agree\n" not in views.terminal:
        yield "the terminal's count"
    for name in ("equations", "rigid", "trust"):
        answer = views.json["answers"][name]["answer"]
        if answer not in html.unescape(views.page) or answer not in views.terminal:
            yield f"{name} is not the same in all views"


def tip_of(run: xr.Dataset, arm: Arm) -> np.ndarray:
    """Position of the tip (times,) [m], as a complex number."""
    absolute = np.cumsum(run["theta"].values, axis=1)
    return np.exp(1j * absolute) @ [link.length_m for link in arm.links]


def level_problems(views: Views, made: Records) -> Iterator[str]:
    """Of the rigid levels beside the geared arm."""
    geared, off = made.runs[LEAD], dict[str, list[float]]()
    for level in RIGID_LEVELS:
        run = made.runs[f"pinocchio:{level}"]
        apart = tip_of(run, made.arm) - tip_of(geared, made.arm)
        sizes = [float(np.abs(apart).max())]
        for joint in range(2):
            for quantity in ("theta", "theta_dot"):
                gap = run[quantity].values[:, joint] - geared[quantity].values[:, joint]
                sizes.append(float(np.abs(gap).max()))
        off[level] = sizes
    table = views.page.partition('<h2 id="levels">')[2].partition("</table>")[0]
    rows = {row[0]: row[1:] for row in rows_of(table) if row}
    for level, sizes in off.items():
        texts = rows.get(f"pinocchio:{level}", [])
        if len(texts) != len(sizes) or not all(
            is_rounded(text, size, 3) for text, size in zip(texts, sizes, strict=True)
        ):
            yield f"{level}: {texts}; are {sizes}"
    rigid = views.json["answers"]["rigid"]["answer"]
    ends = re.findall(r"([\d.e+-]+) (m|mm|µm) (?:with|at)", rigid)
    for (number, unit), level in zip(ends, (RIGID_LEVELS[0], RIGID_LEVELS[-1]), strict=False):
        if not is_rounded(number, off[level][0] / UNITS[unit], 3) or "e" in number:
            yield f"tip of {level}: {number} {unit}; is {off[level][0]} m"
    if len(ends) != 2:
        yield f"answer 2: {ends}"


def signal_numbers(seen: object = None) -> str:
    """Whether the numbers that the page's plots are given are those of the runs."""
    return "differ" if any(signal_problems()) else "agree"


def decoded(stretch: Any, name: str) -> np.ndarray:
    """The numbers of a line."""
    return np.frombuffer(base64.b64decode(stretch.data[name]), "<f4")


def first_planets(run: xr.Dataset, quantity: str, joint: int) -> np.ndarray:
    """A quantity of a joint, counted from 1, and planet 1, (times,)."""
    values = run[quantity].values
    return values[:, joint - 1, 0] if values.ndim == 3 else values[:, joint - 1]


def unlike_planets(run: xr.Dataset) -> xr.Dataset:
    """A run of planets that move alike, with the second's and the third's numbers twice and three
    times as large.
    """
    return run.map(lambda values: values * values["planet"] if "planet" in values.dims else values)


def signal_problems() -> Iterator[str]:
    """What in the plots' numbers is not as the runs have it."""
    models = (LEAD, SECOND, PRINTED, "pinocchio:links")
    made = {name: unlike_planets(records().runs[name]) for name in models}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(signals, "HALF_WINDOW_S", 2e-5)
        (found,) = signals.collect_signals(LEAD, {"pd": made})
    units = signals.format_signals([found])["quantities"]
    time = made[LEAD]["time"].values
    for line in found.lines:
        own = first_planets(made[line.model], line.quantity, line.joint)
        if line.model != LEAD:
            own = own - first_planets(made[LEAD], line.quantity, line.joint)
        stretch = found.whole[line.quantity]
        if not np.array_equal(decoded(stretch, line.name), own.astype("f4")):
            yield f"{line.name}: values"
        if line.peak != float(np.abs(own).max()):
            yield f"{line.name}: peak {line.peak}"
        times = stretch.start_s + stretch.step_s * np.arange(stretch.count)
        if stretch.count != time.size or not np.allclose(times, time, atol=1e-12):
            yield f"{line.name}: times"
    expected = {"theta": "rad", "theta_ddot": "rad/s²", "x_sp": "m", "F_sp": "N", "F_pr": "N"}
    if {name: each["unit"] for name, each in units.items()} != expected:
        yield f"units {units}"
    peaks = {joint: np.abs(first_planets(made[LEAD], "F_sp", joint)) for joint in (1, 2)}
    joint = max(peaks, key=lambda each: peaks[each].max())
    at = float(time[int(peaks[joint].argmax())])
    title = f"largest F_sp, joint {joint}"
    if not any(w.title == title and w.begin_s <= at <= w.end_s for w in found.windows):
        yield f"no window {title} at {at}"


def figure_numbers(seen: object = None) -> str:
    """Whether what the report's figures draw are the runs' numbers, in the units of their axes."""
    return "differ" if any(figure_problems()) else "agree"


def drawn_figures(made: Records) -> tuple[Figure, Figure]:
    """The figure of the run, and that of the rigid levels, before they become SVG."""
    kept: list[Figure] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "to_svg", lambda figure: kept.append(figure) or "")
        figures.draw_run_comparison(made.runs[LEAD], made.runs[SECOND])
        figures.draw_level_deviations(
            made.runs[LEAD], {level: made.runs[f"pinocchio:{level}"] for level in RIGID_LEVELS}
        )
    return kept[0], kept[1]


AXES = {  # of the run's figure: what is in a row, its label, and its unit's size
    "theta": ("joint angle [rad]", 1.0),
    "theta_ddot": ("acceleration [rad/s²]", 1.0),
    "x_sp": ("x_sp, planet 1 [µm]", 1e-6),
    "F_sp": ("F_sp, planet 1 [kN]", 1e3),
}


def figure_problems() -> Iterator[str]:
    """What in the figures is not as the runs have it."""
    made = records()
    made = made._replace(runs={name: unlike_planets(run) for name, run in made.runs.items()})
    run, levels = drawn_figures(made)
    time = made.runs[LEAD]["time"].values
    for row, (quantity, (label, unit)) in enumerate(AXES.items()):
        left, right = run.axes[2 * row : 2 * row + 2]
        if left.get_ylabel() != label:
            yield f"{quantity}: {left.get_ylabel()}"
        for joint in (1, 2):
            own = first_planets(made.runs[LEAD], quantity, joint)
            gap = np.abs(own - first_planets(made.runs[SECOND], quantity, joint))
            for axes, expected in ((left, own / unit), (right, np.maximum(gap, 1e-20))):
                yield from line_problems(axes, f"joint {joint}", time, expected)
    for joint, axes in enumerate(levels.axes, 1):
        if axes.get_title() != f"joint {joint}":
            yield f"levels: {axes.get_title()}"
        for level in RIGID_LEVELS:
            run_of_level = made.runs[f"pinocchio:{level}"]
            gap = first_planets(run_of_level, "theta", joint) - first_planets(
                made.runs[LEAD], "theta", joint
            )
            yield from line_problems(axes, level, time, np.maximum(np.abs(gap), 1e-12))


def line_problems(axes: Any, name: str, time: np.ndarray, expected: np.ndarray) -> Iterator[str]:
    """Whether a line of this name has these values."""
    lines = [line for line in axes.lines if line.get_label() == name]
    if len(lines) != 1:
        yield f"{axes.get_ylabel()}: {len(lines)} lines {name}"
        return
    if not np.array_equal(lines[0].get_xdata(), time):
        yield f"{axes.get_ylabel()}, {name}: times"
    if not np.allclose(lines[0].get_ydata(), expected, rtol=1e-12, atol=0):
        yield f"{axes.get_ylabel()}, {name}: values"


def view_numbers(seen: object = None) -> str:
    """Whether the numbers that `crosscheck view` shows are the run's and the arm's."""
    return "differ" if any(view_problems()) else "agree"


def unpacked(text: str) -> np.ndarray:
    """Numbers of a page."""
    return np.frombuffer(base64.b64decode(text), "<f4")


def view_problems() -> Iterator[str]:
    """What in a run's scene is not as the run has it, by either law of the mesh phase.

    Planets are unlike; every third record is shown.
    """
    for phase in ("angle", "omega_t"):
        yield from _view_problems(phase)


def _view_problems(phase: str) -> Iterator[str]:
    made, every = records(), 3
    run, arm = unlike_planets(made.runs[LEAD]), made.arm
    names = ("theta", "theta_dot", "x_sp", "x_pr", "F_sp", "F_pr")
    signals_of, law = {name: run[name].values for name in names}, usual_switches(arm, phase=phase)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scene, "MOST_FRAMES", -(-run.sizes["time"] // every))
        shown = scene.build_scene(Run(LEAD, arm, run["time"].values, signals_of, law))
    time = run["time"].values[::every]
    frames = shown["start_s"] + shown["step_s"] * np.arange(shown["frames"])
    if shown["every"] != every or frames.size != time.size or not np.allclose(frames, time):
        yield f"times: {shown['step_s']} s, {shown['frames']} of one in {shown['every']}"
    for place, (joint, link) in enumerate(zip(shown["joints"], arm.links, strict=True)):
        if joint["length_m"] != link.length_m:
            yield f"length of link {place + 1}"
        yield from same_values(
            f"theta {place}", joint["theta"], run["theta"].values[::every, place]
        )
        gears, theta = arm.joints[place], run["theta"].values[::every, place]
        teeth_sum, module = gears.sun_teeth + gears.planet_teeth, gears.module_m
        drawn = {"carrier_m": teeth_sum / 2, "rim_m": gears.ring_teeth / 2 + 4, "face_m": 6}
        if any(not np.isclose(joint[name], module * by) for name, by in drawn.items()):
            yield f"sizes of stage {place + 1}"
        for name, count in (("sun", gears.sun_teeth), ("ring", gears.ring_teeth)):
            ends = np.hypot(*np.transpose(joint["outlines"][name]))
            # A tooth ends a module beyond its pitch circle, a ring's inside of it.
            end = ends.min() if name == "ring" else ends.max()
            far = count / 2 + (-1 if name == "ring" else 1)
            if not abs(end - module * far) <= 1.5e-6:
                yield f"outline of {name} {place + 1}: {end}, must be {module * far}"
        base = module / 2 * np.cos(np.radians(gears.pressure_angle_deg))
        x_sp, x_pr = (run[f"x_{side}"].values[::every, place] for side in ("sp", "pr"))
        rolled = base * teeth_sum * theta
        sun = (x_sp[:, 0] + x_pr[:, 0] + 2 * rolled) / (base * gears.sun_teeth)
        yield from same_values(f"sun {place}", joint["sun"], sun)
        for planet, own in enumerate(joint["planets"]):
            turned = -(x_pr[:, planet] + rolled) / (base * gears.planet_teeth)
            yield from same_values(f"planet {planet} of {place}", own, turned)
        for side, teeth in (("sun", gears.sun_mesh), ("ring", gears.ring_mesh)):
            mesh, own = joint["meshes"][side], teeth.planet_mesh(0)
            name = {"sun": "sp", "ring": "pr"}[side]
            x, force = (run[f"{q}_{name}"].values[::every, place, 0] for q in ("x", "F"))
            yield from same_values(f"force {side}", mesh["force"], force)
            # Every tooth of the ring passes a planet in a turn of the carrier; by Eq. 13 the sun's.
            printed = side == "ring" and law.ring_rate == "eq13"
            passing = gears.sun_teeth if printed else gears.ring_teeth
            rates = run["theta_dot"].values[::every, place]
            turned = passing * (theta if phase == "angle" else rates * time)
            wave = np.sin(turned + own.phase_rad + own.tooth_error_phase_rad)
            gap = x - own.static_error_m - own.tooth_error_m * wave
            yield from same_values(f"x - e, {side}", mesh["gap"], gap, 1e-12)
            if mesh["half_clearance_m"] != own.backlash_m:
                yield f"backlash, {side}"
            beyond = np.abs(gap) - own.backlash_m
            touches = np.where(beyond > 0, np.sign(gap), 0)
            if phase == "angle" and not np.array_equal(np.sign(force), touches):
                yield f"contact, {side}"


def same_values(name: str, text: str, expected: np.ndarray, atol: float = 0.0) -> Iterable[str]:
    """A problem if packed numbers are not these."""
    found = unpacked(text)
    same = found.shape == expected.shape and np.allclose(found, expected, rtol=2e-7, atol=atol)
    return () if same else (name,)


VIEW_CHECKS: dict[str, Any] = {
    "report": report_numbers,
    "signals": signal_numbers,
    "figures": figure_numbers,
    "view": view_numbers,
    "robot report": robot_report_numbers,
}
