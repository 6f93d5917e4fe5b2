"""What a trial writes: JSON by its schema, of which annotations are made."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from crosscheck.report.trials.output import render_trial_page
from crosscheck.trial.source.source_edit import SourceAnswer, SourceSearch
from tests.processes import command_line
from tests.schemas import assert_follows
from tests.tool.supplied import model_file
from tests.trial.trial_views import kept_robot

SCHEMAS = Path(__file__).parents[2] / "crosscheck" / "schema"
SLIPPED = """
def slipped(arm):
    right, L1 = two_link(arm), arm.links[0].length_m
    def mass_matrix(q):
        found = np.array(right.mass_matrix(q))
        found[0, 0] += 0.5 * L1**2
        return found
    return replace(right, mass_matrix=mass_matrix)


def alone(arm):
    return Equations(mass_matrix=two_link(arm).mass_matrix)


def raising(arm):
    return replace(two_link(arm), mass_matrix=lambda q: 1 / 0)


def huge():
    return Equations(force=lambda q, torque: [1e308 * np.sin(q[0]), 0])
"""


def validated(file: Path) -> dict:
    content = json.loads(file.read_text())
    for name, part in (("trial", content), ("agreement", content["agreement"])):
        assert_follows(part, name)
    return content


@pytest.mark.parametrize(("name", "code"), [("alone", 0), ("raising", 1), ("huge", 1)])
def test_json_is_as_its_schema_says(crosscheck, tmp_path, name, code):
    model, target = f"{model_file(tmp_path, SLIPPED)}:{name}", tmp_path / "trial.json"
    assert crosscheck("trial", model, "--quick", "--jobs", 1, "--json", target).code == code
    content = validated(target)
    assert content["equations"] == f"mine.py:{name}"
    assert bool(content["tracebacks"]) == (name == "raising")
    unjudged = [line for line in content["scope"] if line.startswith("not judged")]
    assert ("ZeroDivisionError" in "".join(unjudged)) == (name == "raising")


def test_wrong_entries_are_annotated(crosscheck, tmp_path, source_search):
    model, target = f"{model_file(tmp_path, SLIPPED)}:slipped", tmp_path / "trial.json"
    answer = crosscheck("trial", model, "--quick", "--jobs", 1, "--json", target)
    content = validated(target)
    assert (answer.code, content["tracebacks"]) == (1, {})
    assert "M[theta_1, theta_1]" in [each["name"] for each in content["wrong"]]
    target.write_text(json.dumps(content | {"change": None}))
    words = ["tools/annotate_trial.py", target, tmp_path / "mine.py"]
    annotated = command_line(*words, python=(), cwd=SCHEMAS.parents[1])
    source = (tmp_path / "mine.py").read_text().splitlines()
    (line,) = {int(each) for each in re.findall(r"mine.py,line=(\d+)", annotated.stdout)}
    assert source[line - 1] == "    def mass_matrix(q):"
    assert source[line] == "        found = np.array(right.mass_matrix(q))"
    assert [each["line"] for each in content["change"]["edits"]] == [line + 2]
    remarks = [*content["causes"], *content["notes"]]
    assert len(annotated.stdout.splitlines()) == len(content["wrong"]) + len(remarks)
    edit = {"file": "mine.py", "line": line + 2, "old": "0.5 * L1**2", "new": ""}
    target.write_text(json.dumps(content | {"change": {"edits": [edit]}}))
    by_line = command_line(*words, python=(), cwd=SCHEMAS.parents[1]).stdout.splitlines()
    assert by_line[0].endswith(
        f"mine.py,line={line + 2},title=Wrong line::0.5 * L1**2 should be left out"
    )
    assert len(by_line) == 1 + len(remarks)
    words[1] = tmp_path / "none.json"
    nothing = command_line(*words, python=(), cwd=SCHEMAS.parents[1])
    assert (nothing.returncode, nothing.stderr) == (0, "")
    assert re.fullmatch(r"::error file=.*mine.py::.*judged nothing.*\n", nothing.stdout)


@pytest.mark.parametrize(("wrong", "rows"), [((), 1), (("M[j1, j2]",), 0)])
def test_a_row_without_a_cause_points_to_the_change_that_mends_it(wrong, rows):
    """One of two wrong entries has a cause of its own; wrong: those that the change leaves."""
    trial = replace(kept_robot(), search=SourceSearch(SourceAnswer((), wrong=wrong)))
    page = render_trial_page(trial)
    assert page.count("the change above") == rows
    assert "<details open><summary><code>" not in page
