"""Every number of a robot's report, read back and worked out again from its findings.

The findings are those of a short cross-check of three joints, one of them made to differ.
"""

import html
import io
import re
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from crosscheck.findings import Agreement
from crosscheck.models.robot.file import load_robot
from crosscheck.planning.comparison import Results, collect_tasks, judge_comparisons
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.planning.robots import plan_robot
from crosscheck.provenance import record_provenance
from crosscheck.report import html as html_view
from crosscheck.report import rendering, terminal
from crosscheck.report.plots.charts import Pictures
from crosscheck.run import CrossCheck

ROBOT, WRONG = "sliding", 3e-9
FAMILIES = ("states", "same-step", "deviation")  # that the page's tables are of
COLUMNS = ("mass_matrix", "forward_dynamics", "tip", "run")
UNITS_M = {"m": 1.0, "mm": 1e-3, "\u00b5m": 1e-6}


@lru_cache(maxsize=1)
def check_robot() -> CrossCheck:
    """The cross-check, whose first comparison of mass matrices is made to differ."""
    request = CrossCheckRequest(load_robot(ROBOT), quick=True)
    plan = plan_robot(request)
    asked = [each for each in plan.comparisons if each.about.key.family in FAMILIES]
    results = Results({task.key: task.perform() for task in collect_tasks(asked)})
    findings = list(judge_comparisons(asked, results))
    place = next(n for n, f in enumerate(findings) if f.quantity == "mass_matrix" and f.tolerance)
    findings[place] = replace(findings[place], measured=WRONG, verdict="differ")
    record = record_provenance(request.mechanism, 0, True)
    entries = tuple(plan.compute_entries(results))
    return CrossCheck(request, Agreement(findings, record, entries=entries), {}, {})


def robot_report_numbers(seen: object = None) -> str:
    """Whether every number of the robot's report is that of its findings."""
    return "differ" if any(find_problems()) else "agree"


def find_problems() -> Iterator[str]:
    """What on the page, or in the terminal, is not as the findings have it."""
    result, out = check_robot(), io.StringIO()
    forget = getattr(rendering.load_templates, "cache_clear", lambda: None)
    forget()  # a template may be planted
    page = html_view.render_report_page(result, Pictures({}))
    forget()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out):
        patch.setenv("COLUMNS", "250")
        terminal.print_report_summary(result.agreement, result.mechanism)
    findings = result.agreement.findings
    checks = [f for f in findings if f.kind == "check"]
    passed = [f for f in checks if f.measured <= f.tolerance]
    if f'<p class="word">{len(passed)} of {len(checks)}</p>' not in page:
        yield "how many checks agree"
    sentence = re.search(r'class="answer"><strong>(.*?)</strong>', page)
    lines = out.getvalue().splitlines()
    said = f"{len(checks) - len(passed)} of {len(checks)} checks do not agree"
    if {lines[0], lines[-1]} != {html.unescape(sentence[1])} or said not in lines[0]:
        yield f"verdict: {lines[0]}, {sentence[1]}"
    tables = [rows_of(each) for each in re.findall(r"<table[^>]*>(.*?)</table>", page, re.S)]
    tables = [rows for rows in tables if rows]
    models = next(rows for rows in tables if rows[0][0] == "model")
    yield from model_problems(models[1:], findings)
    levels = [rows[1:] for rows in tables if rows[0][0] == "level"]
    yield from deviation_problems([row for rows in levels for row in rows], findings, page)
    yield from entry_problems(next(rows for rows in tables if len(rows) == len(rows[0])), result)


def rows_of(table: str) -> list[list[str]]:
    """The texts of a table's cells."""
    return [
        [
            html.unescape(re.sub("<[^>]*>", " ", cell)).strip()
            for cell in re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.S)
        ]
        for row in re.findall(r"<tr>(.*?)</tr>", table, re.S)
    ]


def model_problems(rows, findings) -> Iterator[str]:
    """Of each model: the largest differences from other engines', and the worst verdict."""
    for row in rows:
        name = row[0].split()[0]
        own = [f for f in findings if f.kind == "check" and name in (f.left, f.right) and f.right]
        between = [f for f in own if f.left.split(":")[0] != f.right.split(":")[0]]
        agrees = all(f.measured <= f.tolerance for f in between)
        if row[1] != ("agree" if agrees else "differ"):
            yield f"{name}: {row[1]}"
        for shown, quantity in zip(row[2:], COLUMNS, strict=False):
            sizes = [f.measured for f in between if f.quantity == quantity]
            if not np.isclose(
                float(shown.split()[0]), float(f"{max(sizes):.1g}"), rtol=1e-9, atol=0
            ):
                yield f"{name}, {quantity}: {shown} for {max(sizes)}"


def deviation_problems(rows, findings, page) -> Iterator[str]:
    """Of each level: how far it is from the finest, and the largest tip on the first screen."""
    deviations = [f for f in findings if f.about.key.family == "deviation"]
    shown = [float(value.split()[0]) for row in rows for value in row[1:]]
    wanted = [f.measured for f in deviations]
    if not np.allclose(shown, wanted, rtol=0.06, atol=0):
        yield f"deviations: {shown} for {wanted}"
    tips = [f.measured for f in deviations if f.quantity == "tip"]
    value, unit = re.search(r'<p class="word">(\S+) (\S?m)</p>', page).groups()
    if not np.isclose(float(value) * UNITS_M[unit], tips[0], rtol=6e-3, atol=0):
        yield f"tip: {value} {unit} for {tips[0]}"


def entry_problems(rows, result) -> Iterator[str]:
    """The mass matrix entry by entry: the engines agree on it."""
    names = result.mechanism.coordinate_names
    if rows[0][1:] != names or [row[0] for row in rows[1:]] != names:
        yield "names of the map"
    entries = result.agreement.entries[-1]
    ticks = np.asarray(entries.relative) <= entries.tolerance
    if [[cell == "\N{CHECK MARK}" for cell in row[1:]] for row in rows[1:]] != ticks.tolist():
        yield "ticks of the map"
