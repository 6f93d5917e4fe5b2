"""The argument's text stands beside the verdicts that a full run computed."""

import re

from crosscheck.provenance import ROOT

FOLDER = ROOT / "docs" / "case-study"
QUOTED = re.compile(r"^`(verdict/[\w-]+)`: \*\*(.+?)\*\*", flags=re.M)
COMPUTED = re.compile(r"^\| `(verdict/[\w-]+)` \| .* \| (.+?) \|$", flags=re.M)


def test_every_verdict_is_quoted_once_and_has_not_turned():
    quoted = QUOTED.findall((FOLDER / "argument.md").read_text(encoding="utf-8"))
    computed = COMPUTED.findall((FOLDER / "results.md").read_text(encoding="utf-8"))
    assert sorted(quoted) == sorted(computed)
    assert len(computed) > 10
