"""Another paper as a folder of data: the acrobot of docs/how-to/audit-a-paper.md."""

import json
import math
import shutil
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
    try_transcript,
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
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.result import Trial
from tests.loops import require_items

ACROBOT = ROOT / "examples" / "acrobot"
GUIDE = ROOT / "docs" / "how-to" / "audit-a-paper.md"

ARM_STUDY = """
schema_version = 1
name = "push"
arm = "paper-labelled"
scenario = "constant-torque"
settings = { "scenario.duration_s" = 0.001 }
starts = { count = 2 }
axes = [{ kind = "list", path = "scenario.drive.torque_N_m", name = "torque", values = [1, 100] }]
quantities = [{ kind = "peak", signal = "theta_dot", joint = 1, name = "rate" }]
"""
ARM_PAPER = """
title = "A push"
equations = "plain_functions.py:model"
sentences = [{ section = "1", number = 1, begins = "It turns", claims = ["1-01", "1-02"] }]
experiments = { light = { "arm.payload_mass_kg" = 0.0 } }

[[claims]]
id = "1-01"
statement = "It turns."
measure = "rate"
above = 1e-4
because = "the least that is seen"
reading = "at every torque"

[[claims]]
id = "1-02"
statement = "Without the payload it turns faster."
measure = "rate"
experiment = "light"
over = "plain"
above = 1.0
because = "faster"
"""


@pytest.fixture(scope="module")
def audit() -> PaperAudit:
    return audit_paper(read_folder(ACROBOT, run_code=True))


def test_every_claim_has_its_verdict_at_both_steps(audit):
    assert {one.claim.id: one.verdict.kind for one in audit.judgements} == {
        "14.3-01": VerdictKind.FAILS,
        "14.3-02": VerdictKind.HOLDS,
        "14.3-03": VerdictKind.HOLDS,
    }
    assert {len(one.answers) for one in audit.judgements} == {2}


def _judged_in(audit: PaperAudit, text: ClaimText, value: float) -> VerdictKind:
    """The verdict where a claim's number is this, in a world planted so."""
    (claim,) = (one.claim for one in audit.judgements if one.claim.id == text.id)
    planted = {text.over: 1.0, text.experiment: value}
    results = ConditionResults(
        {
            MeasuredExperiment(name): Sample({text.measure: np.full(4, number)}, np.zeros(4, bool))
            for name, number in planted.items()
            if name is not None
        }
    )
    return verdict(evaluate_claim(claim, [(StudySetting({}), results)])).kind


def test_a_planted_world_turns_every_verdict_of_the_paper(audit):
    for text in require_items(audit.paper.claims):
        ends = [end for end in (text.above, text.below) if math.isfinite(end)]
        kinds = {_judged_in(audit, text, end * by) for end in ends for by in (0.99, 1.01)}
        assert kinds == {VerdictKind.HOLDS, VerdictKind.FAILS}, text.id


def _bias_by_dalembert(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Bias and weights (2,) of two links of 1 kg and 1 m, from the accelerations of their centres.

    At rates that stay, those of rotation are 0 in the plane, whatever the moments of inertia.
    """
    angles, rates, up = np.cumsum(q), np.cumsum(v), np.array([0.0, 9.8])
    along = np.transpose([np.sin(angles), -np.cos(angles)])
    across = np.transpose([np.cos(angles), np.sin(angles)])
    first = -(rates[0] ** 2) * along[0]
    second = -(rates[1] ** 2) * along[1]
    upper, lower = up + first / 2, up + first + second / 2
    elbow = across[1] / 2 @ lower
    return np.array([across[0] / 2 @ upper + across[0] @ lower + elbow, elbow])


def test_the_missing_term_is_named_and_is_what_first_principles_ask(audit):
    assert isinstance(audit.trial, Trial)
    assert {entry.part for entry in audit.trial.diagnosis.entries} == {"bias", "acceleration"}
    assert any(line.startswith("bias[waist] of hands'^2: missing") for line in audit.lines)
    q, v = np.array([0.4, 0.9]), np.array([1.7, -2.3])
    printed = load_equations(f"{ACROBOT / 'equations.py'}:model", audit.trial.problem.robot)
    off = printed.bias(q, v) - _bias_by_dalembert(q, v)
    np.testing.assert_allclose(off, [0.0, -0.5 * np.sin(q[1]) * v[0] ** 2], atol=1e-13)


def test_an_experiment_runs_in_as_many_processes_as_are_asked_for(monkeypatch):
    given, jobs = read_folder(ACROBOT, run_code=True), list[int]()
    monkeypatch.setattr(
        paper_folder, "measure_study", lambda study, execution: jobs.append(execution.jobs)
    )
    paper_folder.run_experiment(given, {}, 3)
    assert jobs == [3]


def test_with_the_term_all_parts_agree(tmp_path):
    shutil.copytree(ACROBOT, tmp_path / "acrobot")
    file, end = tmp_path / "acrobot" / "equations.py", "+ phi_2, phi_2]"
    printed = file.read_text(encoding="utf-8")
    assert end in printed
    mended = printed.replace(end, end[:-1] + " + M2 * L1 * LC2 * v[0] ** 2 * sin(q[1])]")
    file.write_text(mended, encoding="utf-8")
    trial = try_transcript(read_folder(file.parent, run_code=True), jobs=1)
    assert trial.agreement.exit_code == 0
    assert {finding.verdict for finding in trial.agreement.findings} == {"agree"}


def test_a_paper_of_an_arm_is_audited_the_same_way(tmp_path):
    (tmp_path / "study.toml").write_text(ARM_STUDY, encoding="utf-8")
    (tmp_path / "paper.toml").write_text(ARM_PAPER, encoding="utf-8")
    shutil.copy(ROOT / "examples" / "plain_functions.py", tmp_path)
    audit = audit_paper(read_folder(tmp_path, run_code=True))
    turns, turns_faster = audit.judgements
    assert (turns.claim.reading, turns_faster.claim.reading) == ("at every torque", "")
    assert turns.verdict.kind == VerdictKind.DEPENDS
    assert turns.verdict.depends_on == ("torque",)
    assert [answer.starts for answer in turns.answers] == [2, 2]
    assert turns_faster.verdict.kind == VerdictKind.HOLDS
    assert audit.trial.agreement.exit_code == 0


def test_the_guide_shows_what_is_printed(audit):
    text = GUIDE.read_text(encoding="utf-8")
    assert [line for line in audit.lines if line not in text] == []


def test_the_command_writes_the_verdicts(audit, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(paper_folder, "audit_paper", lambda given, jobs: audit)
    for _ in range(2):  # its own file it may replace
        run_folder_command(ACROBOT, [], tmp_path, 1, True)
    written = json.loads((tmp_path / "verdicts.json").read_text(encoding="utf-8"))
    assert [claim["id"] for claim in written["claims"]] == ["14.3-01", "14.3-02", "14.3-03"]
    for claim, judgement in zip(written["claims"], audit.judgements, strict=True):
        said = [setting["quantiles"] for setting in claim["settings"]]
        assert said == [list(answer.quantiles) for answer in judgement.answers]
    assert written["equations"] == audit.lines[4:]
    (tmp_path / "verdicts.json").write_text("{}", encoding="utf-8")
    with pytest.raises(InputError, match=r"verdicts\.json"):
        run_folder_command(ACROBOT, [], tmp_path, 1, True)
    assert (tmp_path / "verdicts.json").read_text(encoding="utf-8") == "{}"
    assert "14.3-01: does not hold (2 no)" in capsys.readouterr().out


def test_code_runs_only_where_that_is_allowed(tmp_path):
    with pytest.raises(InputError, match="--run-code"):
        run_folder_command(ACROBOT, [], tmp_path / "report", 1, False)
    assert not (tmp_path / "report").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('id = "14.3-02"', 'id = "14.3-01"', "is the id of two"),
        ('claims = ["14.3-01"]', 'claims = ["9-09"]', "named by no sentence"),
        ('claims = ["14.3-01"]', "claims = []", "or else a reason for none"),
        ('claims = ["14.3-01"]', 'claims = ["14.3-01", "9-09"]', "is not a claim"),
        ('experiment = "pumped"', 'experiment = "pump"', "allowed: plain, pumped, spinning"),
        ("below = 1.0", "", "nothing is judged"),
        ('"bias", "acc', '"gravity_of_it", "acc', "is not a part; allowed: mass_matrix"),
        (
            'claims = ["14.3-01"]',
            'claims = ["14.3-01"], none = "both"',
            "or else a reason for none",
        ),
    ],
)
def test_what_does_not_fit_is_reported_in_one_line(tmp_path: Path, old, new, message):
    content = (ACROBOT / "paper.toml").read_text(encoding="utf-8")
    assert old in content
    file = tmp_path / "paper.toml"
    file.write_text(content.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=message) as raised:
        validate_record(PaperFile, read_toml(file), "paper.toml")
    assert "\n" not in str(raised.value)


def test_a_number_that_is_not_measured_is_reported(audit):
    with pytest.raises(InputError, match="measure = 'height': the study measures of one joint"):
        build_quantity(audit.paper.claims[2], Measures({}), Path("paper.toml"))
