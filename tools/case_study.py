"""The page of the docs with the audit's results: ``python -m tools.case_study paper-report``.

Reads claims.json and paper.html of a full `crosscheck paper` and writes
docs/case-study/results.md.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

from tools.site import format_table

PAGE = Path(__file__).parents[1] / "docs" / "case-study" / "results.md"
COLUMNS = {"as_modelled": "as modelled in the paper", "as_the_gears_are": "as the gears are"}
# The verdict in a row: where the event occurs in some settings only, the counts say so.
WORDS = {"does not hold": "fails", "holds where defined": "holds"}
# What a finding has on the command's page alone.
OF_THE_PAGE = r"<figure.*?</figure>|</?(?:a|p)\b[^>]*>| class=\"\w+\""
HEAD = """\
# Results of the audit

{citation} Only its text was read: [its figures were not seen](paper.md).

Made by `python -m tools.case_study` from `crosscheck paper` of {date}, revision {revision},
{machine}. The command's page has the figures, its `claims.json` every number behind a verdict;
[the argument](argument.md) gives the reasons.
"""
LEGEND = """\
[How a claim is judged](paper.md#how-a-claim-is-judged) has the two models and the verdicts. Italics
say how a statement was read. Of two verdicts the first is *as modelled*, the second *as the gears
are*; one is for both. Counts are of settings: yes/no/bistable, with a fourth of those in which the
event does not occur; a claim that fails or holds with a fourth count does so where it occurs.
"""


def build_page(folder: Path) -> str:
    """The page as Markdown, of a folder of `crosscheck paper`."""
    result = json.loads((folder / "claims.json").read_text(encoding="utf-8"))
    html = (folder / "paper.html").read_text(encoding="utf-8")
    made, chapters = result["provenance"], result["chapters"]
    head = HEAD.format(
        citation=result["paper"]["citation"],
        date=made["created"][:10],
        revision=made["revision"],
        machine=made["machine"],
    )
    claims = chapters["claims"]
    parts = [head, "## Six findings\n", *extract_findings(html)]
    parts += ["## Computed verdicts\n", format_verdicts(chapters["findings"])]
    parts += ["## Errors in the printed equations\n", format_errata(chapters["errata"])]
    parts += ["## Every claim\n", LEGEND, format_counts(claims), describe_close_verdicts(claims)]
    for section, listed in groupby(claims, key=itemgetter("section")):
        parts += [f"### {_section(section)}\n", *map(format_claim, listed), ""]
    return "\n".join(parts).replace("&#39;", "'")


def extract_findings(html: str) -> Iterator[str]:
    """The articles of the page's first screen without figures, links and classes."""
    for title, body in split_findings(html):
        plain = re.sub(OF_THE_PAGE, "", body, flags=re.S)
        text = re.sub(r"\s*(<table.*?</table>)\s*", r"\n\n\1\n\n", " ".join(plain.split()))
        yield f"### {title}\n\n{text}\n"


def split_findings(html: str) -> list[tuple[str, str]]:
    """Title, with its number, and html of every finding of the page."""
    article = r'<article class="finding">\s*<h3[^>]*>(.*?)</h3>(.*?)</article>'
    return re.findall(article, html, flags=re.S)


def format_verdicts(findings: list[dict[str, Any]]) -> str:
    """The verdicts that the findings rest on, each by the name that the case study quotes."""
    rows = (
        [f"`{each['id']}`", each["question"], each["verdict"]]
        for each in findings
        if each["id"].startswith("verdict/")
    )
    return format_table(["name", "question", "computed answer"], rows)


def format_errata(rows: list[dict[str, Any]]) -> str:
    """Those of class equation, the labelled reading."""
    equation_errata = [
        each for each in rows if each.get("class") == "equation" and "labelled" in each["id"]
    ]
    cells = (
        [
            each["where"],
            format_formula(each, "printed"),
            format_formula(each, "derived"),
            format_effect(each, "constant-torque"),
            format_effect(each, "pd"),
            each["remark"],
        ]
        for each in equation_errata
    )
    heads = ["where", "printed", "right", "effect, constant torque", "effect, PD control", "remark"]
    return format_table(heads, cells)


def format_formula(each: dict[str, Any], side: str) -> str:
    """A side of an erratum; its words where it is no formula."""
    tex = each.get(f"{side}_tex")
    if not tex:
        return str(each[side])
    # Docutils sets the index of an accented letter below it, unless they are parted.
    return "$" + re.sub(r"(\\d+ot\{[^}]*\})_", r"\1{}_", tex) + "$"


def format_effect(each: dict[str, Any], run: str) -> str:
    """On angle and mesh force of a run."""
    effect = each["effects"].get(run)
    if not effect:
        return ""
    force = float(f"{effect['mesh_force_N']:.2g}")
    return f"{effect['theta_rad']:.1e} rad, {force:g} N"


def format_counts(claims: list[dict[str, Any]]) -> str:
    """How many claims have each verdict in each column."""
    verdict_counts = {
        key: Counter(select_verdict(each, key)["verdict"] for each in claims) for key in COLUMNS
    }
    verdict_names = sorted({kind for column in verdict_counts.values() for kind in column})
    cells = ([kind, *(str(verdict_counts[key][kind]) for key in COLUMNS)] for kind in verdict_names)
    return format_table(["verdict", *COLUMNS.values()], cells)


def select_verdict(claim: dict[str, Any], column: str) -> dict[str, Any]:
    """That of a column, or of the claim where it is decided without a run."""
    verdict: dict[str, Any] = claim["models"].get(column, claim)
    return verdict


def format_verdict(claim: dict[str, Any], column: str) -> str:
    """In one word, with the counts of settings where they do not all say the same."""
    verdict = select_verdict(claim, column)
    word = WORDS.get(verdict["verdict"], verdict["verdict"])
    if column not in claim["models"]:
        return word
    *counts, undefined = verdict["counts"].values()
    counts += [undefined] if undefined else []
    return f"{word} {'/'.join(map(str, counts))}" if len(list(filter(None, counts))) > 1 else word


def describe_close_verdicts(claims: list[dict[str, Any]]) -> str:
    """Which claims other limits judge otherwise."""
    simulated = [each for each in claims if not each["static"]]
    close = [each["id"] for each in simulated if each["turns_within_a_quarter"]]
    return (
        f"{len(close)} of {len(simulated)} verdicts that runs decide turn within 25 % of their"
        f" limit: {', '.join(close) or 'none'}.\n"
    )


def format_claim(claim: dict[str, Any]) -> str:
    """Name, statement with its reading, where there could be another, and verdicts."""
    reading = f" *{claim['reading']}*" if claim["reading"] else ""
    verdicts = dict.fromkeys(format_verdict(claim, column) for column in COLUMNS)
    return f"- {claim['id']}: {claim['statement']}{reading} **{'; '.join(verdicts)}**"


def _section(name: str) -> str:
    return name if not name[:1].isdigit() else f"Section {name}"


if __name__ == "__main__":
    PAGE.write_text(build_page(Path(sys.argv[1])), encoding="utf-8")
