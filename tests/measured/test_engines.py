"""Engines that disagree on a record's torques: the first line says so, and nothing is judged."""

import json
import re

import numpy as np
import pytest

from crosscheck.analytic.model import RigidModel
from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.identification.compare import RecordComparison, compare
from crosscheck.identification.mechanism import PlanarArm
from crosscheck.identification.output import comparison_json, comparison_page, describe_comparison
from crosscheck.models.pinocchio.arm import PinocchioCoupled, PinocchioLinks
from crosscheck.models.pinocchio.robot import PinocchioRobot
from crosscheck.provenance import ROOT
from crosscheck.recordings.record import Record
from tests.measured.records import level, record_of
from tests.schemas import assert_follows


@pytest.fixture(scope="module")
def record(labelled):
    return record_of(level(labelled, "coupled"), rows=600)


def ask(record: Record, arm) -> RecordComparison:
    return compare(PlanarArm(arm), [record], np.eye(2), lambda *doing: None)


def scaled(share):
    return lambda torques: (1 + share) * torques


def one_row(torques):
    torques[len(torques) // 2, 1] += 1e-6  # of torques of 100 N m
    return torques


def raising(torques):
    raise ZeroDivisionError("no such luck")


def harm(patch, owner, change):
    right = owner.inverse_dynamics
    patch.setattr(owner, "inverse_dynamics", lambda *state: change(right(*state)))


WRONG = {
    "Pinocchio's arm off by a tenth": (
        PinocchioLinks,
        scaled(0.1),
        "pinocchio:links (planar) stands alone",
    ),
    "analytic arm off by 0.1 %": (RigidModel, scaled(1e-3), "analytic:links (planar) stands alone"),
    "Pinocchio's robot off by 1e-8": (PinocchioRobot, scaled(1e-8), "torques: pinocchio:"),
    "the reference off by a tenth": (AnalyticRobot, scaled(0.1), "analytic:links stands alone"),
    "one row of one level": (PinocchioCoupled, one_row, "pinocchio:coupled (planar) stands alone"),
    "no numbers": (PinocchioCoupled, scaled(np.nan), "BadAnswer: torques is not finite"),
    "another shape": (
        PinocchioCoupled,
        lambda torques: torques[:-1],
        "BadAnswer: torques has shape",
    ),
    "raises": (PinocchioRobot, raising, "ZeroDivisionError: no such luck"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_engines_that_disagree_judge_nothing(record, labelled, monkeypatch, wrong):
    owner, change, text = WRONG[wrong]
    harm(monkeypatch, owner, change)
    comparison = ask(record, labelled)
    assert (comparison.engines_agree, comparison.sides) == (False, ())
    name, _, answer = "\n".join(describe_comparison(comparison)).partition(": ")
    assert name == "Arm paper-labelled"
    lines = answer.split("\n")
    assert lines[0].startswith("The engines d")
    assert lines[0].endswith("Nothing is said about the recording.")
    assert any(text in line for line in lines[: lines.index("")])
    data = json.loads(comparison_json(comparison))
    assert_follows(data, "measured")
    assert data["answer"] == lines[: lines.index("")]
    assert (data["engines_agree"], data["sides"]) == (False, [])
    page = comparison_page(comparison)
    # The model that was asked stands first, and what it is compared with behind it.
    rows = re.findall(r"<tr><td>(.*?)</td><td>(.*?)</td>", page)
    assert rows == [(each.right, each.left) for each in comparison.engines]
    for word in ("payload", "fits"):
        assert word not in page.partition("<main>")[2]
        assert word not in "".join(lines)


def test_the_command_fails_in_its_first_line(crosscheck, monkeypatch):
    harm(monkeypatch, PinocchioLinks, scaled(0.1))
    answer = crosscheck("compare", ROOT / "examples/recordings/payload.csv", "paper-labelled")
    assert answer.code == 1
    disagree = "The engines do not agree on the arm's torques: pinocchio:"
    assert answer.out.startswith(f"Arm paper-labelled: {disagree}")
    assert "fits" not in answer.out
