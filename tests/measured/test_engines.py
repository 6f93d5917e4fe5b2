"""Engines that disagree on a record's torques: the first line says so, and nothing is judged."""

import json
import re

import jsonschema
import numpy as np
import pytest

from crosscheck.analytic.model import RigidModel
from crosscheck.models.pinocchio.rigid import PinocchioCoupled, PinocchioLinks
from crosscheck.provenance import ROOT
from crosscheck.recordings.compare import EngineDisagreement, compare
from crosscheck.recordings.output import comparison_json, comparison_page, describe_comparison
from tests.measured.records import level, record_of

SCHEMA = json.loads((ROOT / "crosscheck/schema/measured.schema.json").read_text())


@pytest.fixture(scope="module")
def record(labelled):
    return record_of(level(labelled, "coupled"), rows=600)


def scaled(share):
    return lambda torques: (1 + share) * torques


def one_row(torques):
    torques[411, 1] += 1e-6  # of torques of 100 N m
    return torques


def raising(torques):
    raise ZeroDivisionError("no such luck")


def harm(patch, owner, change):
    right = owner.inverse_dynamics
    patch.setattr(owner, "inverse_dynamics", lambda *state: change(right(*state)))


WRONG = {
    "Pinocchio off by a tenth": (PinocchioLinks, scaled(0.1), "pinocchio:links stands alone"),
    "analytic off by 0.1 %": (RigidModel, scaled(1e-3), "analytic:links stands alone"),
    "one row of one level": (PinocchioCoupled, one_row, "pinocchio:coupled stands alone"),
    "no numbers": (PinocchioCoupled, scaled(np.nan), "BadAnswer: torques is not finite"),
    "another shape": (
        PinocchioCoupled,
        lambda torques: torques[:-1],
        "BadAnswer: torques has shape",
    ),
    "raises": (PinocchioCoupled, raising, "ZeroDivisionError: no such luck"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_engines_that_disagree_judge_nothing(record, labelled, monkeypatch, wrong):
    owner, change, said = WRONG[wrong]
    harm(monkeypatch, owner, change)
    found = compare(record, labelled, None, {}, lambda *doing: None)
    assert isinstance(found, EngineDisagreement)
    told = list(describe_comparison(found))
    assert told[0].startswith("The engines d")
    assert told[0].endswith("Nothing is said about the recording.")
    assert any(said in line for line in told[: told.index("")])
    data = json.loads(comparison_json(found))
    jsonschema.validate(data, SCHEMA)
    assert data["answer"] == told[: told.index("")]
    assert not data["engines_agree"]
    assert "levels" not in data
    page = comparison_page(found)
    # The model that was asked stands first, and what it is compared with behind it.
    rows = re.findall(r"<tr><td>(.*?)</td><td>(.*?)</td>", page)
    assert rows == [(each.right, each.left) for each in found.engines]
    for word in ("payload", "fits", "noise"):
        assert word not in page.partition("<main>")[2]
        assert word not in "".join(told)


def test_both_wrong_is_said(record, labelled, monkeypatch):
    for owner, change in ((RigidModel, scaled(0.1)), (PinocchioLinks, scaled(-0.1))):
        harm(monkeypatch, owner, change)
    found = compare(record, labelled, None, {}, lambda *doing: None)
    assert "both differ from first principles" in "".join(describe_comparison(found))


def test_the_command_fails_in_its_first_line(crosscheck, monkeypatch):
    harm(monkeypatch, PinocchioLinks, scaled(0.1))
    answer = crosscheck("compare", ROOT / "examples/recordings/payload.csv", "paper-labelled")
    assert answer.code == 1
    assert answer.out.startswith("The engines do not agree on the arm's torques: pinocchio:")
    assert "fits" not in answer.out
