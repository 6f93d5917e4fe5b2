"""The benchmark's yardsticks compute what they say; how fast they are is no test's business."""

import json
import shutil
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from benchmarks.suite import c_reference
from benchmarks.suite.c_reference import LANES, ScalarRun, VectorRun
from benchmarks.suite.cases import build_long_run, build_pd_run
from benchmarks.suite.machine import describe_machine
from benchmarks.suite.refined_solution import solve_refined
from benchmarks.suite.report import read, write
from benchmarks.suite.rows import Row, absent_row
from benchmarks.suite.single import largest_difference, simulate_states
from crosscheck.models.trajectory import recorded_times
from tools.site import format_benchmark

SCHEMA = Path(__file__).parents[2] / "benchmarks" / "results.schema.json"
COMPILED = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
# 2000 steps of some hundred roundings each; another order of them agrees to 1e-14 of the size.
ROUNDING = 1e-12


@COMPILED
@pytest.mark.parametrize(("joints", "counted"), [(4, "lumped"), (2, "free")])
def test_c_references_run_as_the_model_does(joints, counted, monkeypatch):
    quickly = ("-O0", *c_reference.FLAGS[1:])  # the same text, compiled in a part of the time
    monkeypatch.setattr(c_reference, "FLAGS", quickly)
    model = build_long_run(joints, counted, 2000)
    own = simulate_states(model)
    scalar, vectors = ScalarRun(model), VectorRun([model] * LANES)
    scalar.run()
    vectors.run()
    assert largest_difference(model, scalar.states()[0], own) < ROUNDING
    assert largest_difference(model, vectors.states(LANES - 1)[0], own) < ROUNDING
    assert np.abs(own - own[0]).max() > 0


@pytest.mark.slow
def test_refined_solution_keeps_order_eight_through_contact_changes():
    """5 ms with contact changes: halving the step gains more than order 4 could, 16 times."""
    model = build_pd_run(0.005)
    grid = recorded_times(model.scenario)[:51]
    rough, better, best = (solve_refined(model, grid, step) for step in (1e-4, 5e-5, 2.5e-5))
    assert best.changes > 0
    errors = [largest_difference(model, run.q, best.q) for run in (rough, better)]
    assert errors[0] > 30 * errors[1]


def test_results_follow_their_schema_and_the_docs_show_them(tmp_path):
    rows = [Row("a", "b", "c", 1.0, "s", "d", 2.0, 1.0, 0.1), absent_row("a", "b", "no compiler")]
    here = describe_machine(1)
    assert "make bench" in format_benchmark(tmp_path / "results.json")
    write(rows, here, tmp_path)
    content = json.loads((tmp_path / "results.json").read_text())
    jsonschema.validate(content, json.loads(SCHEMA.read_text()))
    (first, second), measured_on = read(tmp_path / "results.json")
    assert (first, measured_on) == (rows[0], here)
    assert np.isnan(second.value)
    page = format_benchmark(tmp_path / "results.json")
    assert "| b | c | 2 | d | 1 | **not reached** | 1 | s | 10% |" in page
    assert "| b | not measured: no compiler |" in page
    assert all(fact in page for fact in (here.made, here.revision, here.processor))
