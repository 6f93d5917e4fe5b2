"""Another paper as a folder of data: the made-up note of docs/how-to/audit-a-paper.md."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from crosscheck.audit.judging import paper_folder
from crosscheck.audit.judging.paper_folder import (
    ClaimText,
    PaperAudit,
    PaperFile,
    StudySetting,
    audit_paper,
    build_quantity,
    read_folder,
    run_folder_command,
)
from crosscheck.audit.judging.quantities import (
    ConditionResults,
    MeasuredExperiment,
    Measures,
    Sample,
)
from crosscheck.audit.judging.rule import VerdictKind, evaluate_claim, verdict
from crosscheck.models.errors import InputError
from crosscheck.models.files import read_toml
from crosscheck.models.loading import validate_record
from crosscheck.provenance import ROOT
from tests.loops import require_items

NOTE = ROOT / "examples" / "made-up-note"
GUIDE = ROOT / "docs" / "how-to" / "audit-a-paper.md"


@pytest.fixture(scope="module")
def note() -> PaperAudit:
    return audit_paper(read_folder(NOTE, run_code=True))


def test_every_claim_of_the_note_has_its_verdict(note):
    verdicts = {one.claim.id: one.verdict for one in note.judgements}
    assert {name: verdict.kind for name, verdict in verdicts.items()} == {
        "2-01": VerdictKind.FAILS,
        "2-02": VerdictKind.HOLDS,
        "2-03": VerdictKind.DEPENDS,
        "3-01": VerdictKind.HOLDS,
    }
    assert verdicts["2-03"].depends_on == ("damping",)
    assert {len(one.answers) for one in note.judgements} == {6}  # three dampings, two of planets


def _judged_in(note: PaperAudit, text: ClaimText, value: float) -> VerdictKind:
    """The verdict where a claim's number is this, in a world planted so."""
    (claim,) = (one.claim for one in note.judgements if one.claim.id == text.id)
    planted = {text.over: 1.0, text.experiment: value}
    results = ConditionResults(
        {
            MeasuredExperiment(name): Sample({text.measure: np.full(4, number)}, np.zeros(4, bool))
            for name, number in planted.items()
            if name is not None
        }
    )
    return verdict(evaluate_claim(claim, [(StudySetting({}), results)])).kind


def test_a_planted_world_turns_every_verdict_of_the_note(note):
    for text in require_items(note.paper.claims):
        ends = [end for end in (text.above, text.below) if math.isfinite(end)]
        kinds = {_judged_in(note, text, end * by) for end in ends for by in (0.99, 1.01)}
        assert kinds == {VerdictKind.HOLDS, VerdictKind.FAILS}, text.id


def test_the_equation_with_the_slip_is_named_and_the_others_agree(note):
    assert note.trial is not None
    assert {wrong.place.part for wrong in note.trial.wrong_entries} == {"bias"}
    assert "times 0.5" in "\n".join(note.lines)


def test_the_guide_shows_the_note_and_what_is_said_of_it(note):
    text = GUIDE.read_text(encoding="utf-8")
    for sentence in require_items(note.paper.sentences):
        assert re.search(
            rf"^{sentence.section}\.{sentence.number} {re.escape(sentence.begins)}", text, re.M
        )
    assert [line for line in note.lines if line not in text] == []


def test_the_command_writes_the_verdicts(note, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(paper_folder, "audit_paper", lambda given, jobs: note)
    for _ in range(2):  # its own file it may replace
        run_folder_command(NOTE, [], tmp_path, 1, True)
    written = json.loads((tmp_path / "verdicts.json").read_text(encoding="utf-8"))
    assert [claim["id"] for claim in written["claims"]] == ["2-01", "2-02", "2-03", "3-01"]
    assert "2-03: depends on damping (4 yes, 2 no)" in capsys.readouterr().out


def test_code_runs_only_where_that_is_allowed(tmp_path):
    with pytest.raises(InputError, match="--run-code"):
        run_folder_command(NOTE, [], tmp_path / "report", 1, False)
    assert not (tmp_path / "report").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('id = "2-02"', 'id = "2-01"', "is the id of two"),
        ('claims = ["2-01"]', 'claims = ["9-09"]', "named by no sentence"),
        ('claims = ["2-01"]', 'claims = ["2-01", "9-09"]', "is no claim"),
        ('experiment = "exact teeth"', 'experiment = "exact"', "allowed: exact teeth, plain"),
        ("above = 44.0", "", "nothing is judged"),
        ('errata = ["bias"]', 'errata = ["gravity_of_it"]', "is no part; allowed: mass_matrix"),
        ('claims = ["3-01"]', 'claims = ["3-01"], none = "both"', "or else a reason for none"),
    ],
)
def test_what_does_not_fit_is_told_in_one_line(tmp_path: Path, old, new, message):
    content = (NOTE / "paper.toml").read_text(encoding="utf-8")
    assert old in content
    file = tmp_path / "paper.toml"
    file.write_text(content.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=message) as raised:
        validate_record(PaperFile, read_toml(file), "paper.toml")
    assert "\n" not in str(raised.value)


def test_a_number_that_is_not_measured_is_told(note):
    with pytest.raises(InputError, match="claim 2-01: measure = 'peak': the study measures"):
        build_quantity(note.paper.claims[0], Measures({}), Path("paper.toml"))
