"""The argument's text stands beside the verdicts that a full run computed."""

import re
from collections import Counter

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.provenance import ROOT

FOLDER = ROOT / "docs" / "case-study"
ARGUMENT, RESULTS = (
    (FOLDER / f"{name}.md").read_text(encoding="utf-8") for name in ("argument", "results")
)
QUOTED = re.compile(r"^`(verdict/[\w-]+)`: \*\*(.+?)\*\*", flags=re.M)
COMPUTED = re.compile(r"^\| `(verdict/[\w-]+)` \| .* \| (.+?) \|$", flags=re.M)


def test_every_verdict_is_quoted_once_and_has_not_turned():
    computed = COMPUTED.findall(RESULTS)
    assert sorted(QUOTED.findall(ARGUMENT)) == sorted(computed)
    assert len(computed) > 10


def test_the_counts_of_the_results_are_those_of_their_rows():
    """Each was written by one run, or edited since: a claim that is retired takes its row along."""
    rows = re.findall(r"^\| ([\w.]+-\d\d) \| .* \| ([^|]+) \| ([^|]+) \|$", RESULTS, flags=re.M)
    assert sorted(row[0] for row in rows) == sorted(claim.id for claim in CLAIMS)
    counts = re.findall(r"^\| ([a-z ]+) \| (\d+) \| (\d+) \|$", RESULTS, flags=re.M)
    for column in (1, 2):
        told = {row[0]: int(row[column]) for row in counts if row[column] != "0"}
        assert told == Counter(row[column].partition(" (")[0] for row in rows)
    close = re.search(r"^(\d+) of (\d+) verdicts that runs decide [^:]*: ([^:]*)\.", RESULTS, re.M)
    assert close is not None
    assert int(close[1]) == len(close[3].split(", "))
    assert int(close[2]) == sum(not claim.static for claim in CLAIMS)
