"""What is published of a full run says one thing: argument, findings, claims, sheet and README.

It is read as a reader has it, in words; nothing is run.
"""

import re
from collections import Counter

import pytest

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.errata.errata_texts import load_notes
from crosscheck.audit.errata.finder import find_errata
from crosscheck.provenance import ROOT
from tests.loops import require_items

FOLDER = ROOT / "docs" / "case-study"
ARGUMENT, RESULTS = (
    (FOLDER / f"{name}.md").read_text(encoding="utf-8") for name in ("argument", "results")
)
QUOTED = re.compile(r"^`(verdict/[\w-]+)`: \*\*(.+?)\*\*", flags=re.M)
ROWS = re.findall(r"^\| ([\w.]+-\d\d) \| .* \| ([^|]+) \| ([^|]+) \|$", RESULTS, flags=re.M)
FINDINGS = dict(re.findall(r"^### (\d)\. .*\n\n.*?<b>(.*)$", RESULTS, flags=re.M))
COMPUTED = re.compile(r"^\| `(verdict/[\w-]+)` \| .* \| (.+?) \|$", flags=re.M)


def test_every_verdict_is_quoted_once_and_has_not_turned():
    computed = COMPUTED.findall(RESULTS)
    assert sorted(QUOTED.findall(ARGUMENT)) == sorted(computed)
    assert len(computed) > 10


def test_the_counts_of_the_results_are_those_of_their_rows():
    """Each was written by one run, or edited since: a claim that is retired takes its row along."""
    assert sorted(row[0] for row in ROWS) == sorted(claim.id for claim in CLAIMS)
    counts = re.findall(r"^\| ([a-z ]+) \| (\d+) \| (\d+) \|$", RESULTS, flags=re.M)
    for column in (1, 2):
        told = {row[0]: int(row[column]) for row in counts if row[column] != "0"}
        assert told == Counter(row[column].partition(" (")[0] for row in ROWS)
    close = re.search(r"^(\d+) of (\d+) verdicts that runs decide [^:]*: ([^:]*)\.", RESULTS, re.M)
    assert close is not None
    assert int(close[1]) == len(close[3].split(", "))
    assert int(close[2]) == sum(not claim.static for claim in CLAIMS)


# A finding's answer, and what claims say of the same thing: as modelled, and as the gears are.
SAID_TWICE = [
    ("1", "No", "2.4-02", "does not hold", "does not hold"),  # M follows from the energies
    ("2", "Yes", "2.3-02", "does not hold", "does not hold"),  # omega_e t is the phase
    ("3", "No", "Abstract-02", "depends", "does not hold"),  # the tooth error's severe fluctuation
    ("3", "No", "5-04", "depends", "does not hold"),
    ("4", "No baseline", "3.1-01", "does not hold", "does not hold"),  # 0.02 rad
    ("4", "No baseline", "3.1-04", "does not hold", "does not hold"),  # 30 mm
    ("5", "With the printed drive alone", "4.1-05", "depends", "depends"),  # it accumulates
    ("5", "With the printed drive alone", "4.1-07", "does not hold", "does not hold"),  # by itself
]


@pytest.mark.parametrize("said", SAID_TWICE, ids=lambda said: f"{said[0]}, {said[2]}")
def test_a_finding_and_a_claim_on_one_thing_turn_together(said):
    number, answer, claim, *verdicts = said
    (row,) = (row for row in ROWS if row[0] == claim)
    assert FINDINGS[number].startswith(f"{answer}")
    assert [verdict.partition(" (")[0] for verdict in row[1:]] == verdicts


def test_no_claim_holds_that_the_sheet_denies(labelled):
    """Neither of what the program finds nor of what is found by reading."""
    verdicts = {row[0]: row[1:] for row in ROWS}
    sheet = [*find_errata(labelled), *load_notes().entries]
    for entry in require_items(entry for entry in sheet if entry.denies):
        for claim in entry.denies:
            assert not [said for said in verdicts[claim] if said.startswith("holds")], entry.id
    places = re.findall(r"^\| (Eqs?\. .*?) \| ", RESULTS, flags=re.M)
    assert sorted(places) == sorted(e.where for e in sheet if e.kind == "equation")


def test_the_readme_has_the_numbers_of_the_findings():
    """The largest of the mesh forces, and how many errors of equations there are."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (told,) = re.findall(r"printed equations agree with the engines\? \| (.*) \|", readme)
    numbers = re.findall(r"\d[\d.]* (?:%|N)", told)
    assert len(numbers) == 3
    assert all(f" {number}" in FINDINGS["1"] for number in numbers)
    assert "| nine, each" in readme
    assert len(re.findall(r"^\| Eqs?\. ", RESULTS, flags=re.M)) == 9
