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
from pathlib import Path
from typing import Any

from tools.site import format_table

PAGE = Path(__file__).parents[1] / "docs" / "case-study" / "results.md"
COLUMNS = {"as_modelled": "as modelled in the paper", "as_the_gears_are": "as the gears are"}
HEAD = """\
# Results of the audit

{citation} {read}

Made by `python -m tools.case_study` from `crosscheck paper` of {date}, revision {revision},
{machine}. Its page has the figures, its `claims.json` every number behind a verdict;
[the argument](argument.md) gives the reasons.

*As modelled in the paper* runs Eqs. 21 and 22 entry for entry, with lumped planets and the paper's
law of the mesh phase, beside the rigid arm to which these equations tend; *as the gears are* has
equations of motion from the energies of all bodies, free planets and the integral of the mesh
frequency. A setting says *yes* unless its starts show, with 95 % confidence, that the statement
would be true in fewer than nine of ten: of 32 starts from 25 on. A claim *holds* if every setting,
both readings of Table I at every damping ratio, says yes. *Depends* means that some settings give
yes and others no, *bistable* that single starts decide. Settings follow from the chosen
damping ratios and are no sample of anything.
"""


def build_page(folder: Path) -> str:
    """The page as Markdown, of a folder of `crosscheck paper`."""
    result = json.loads((folder / "claims.json").read_text(encoding="utf-8"))
    html = (folder / "paper.html").read_text(encoding="utf-8")
    made, chapters = result["provenance"], result["chapters"]
    head = HEAD.format(
        citation=result["paper"]["citation"],
        read=result["paper"]["read"],
        date=made["created"][:10],
        revision=made["revision"],
        machine=made["machine"],
    )
    parts = [head, "## Six findings\n", *extract_findings(html)]
    parts += ["## Computed verdicts\n", format_verdicts(chapters["findings"])]
    parts += ["## Errors in the printed equations\n", format_errata(chapters["errata"])]
    parts += [
        "## Every claim\n",
        format_counts(chapters["claims"]),
        describe_close_verdicts(chapters["claims"]),
    ]
    for section in dict.fromkeys(each["section"] for each in chapters["claims"]):
        rows = [each for each in chapters["claims"] if each["section"] == section]
        parts += [
            f"### {_section(section)}\n",
            format_table(["claim", "statement", *COLUMNS.values()], map(format_row, rows)),
        ]
    return "\n".join(parts).replace("&#39;", "'")


def extract_findings(html: str) -> Iterator[str]:
    """The articles of the page's first screen without figures and links."""
    for title, body in split_findings(html):
        plain = re.sub(r"<figure.*?</figure>|</?a\b[^>]*>", "", body, flags=re.S)
        yield f"### {title}\n\n{' '.join(plain.split())}\n"


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
            format_effect(each),
            each["remark"],
        ]
        for each in equation_errata
    )
    return format_table(["where", "printed", "right", "effect on a run", "remark"], cells)


def format_formula(each: dict[str, Any], side: str) -> str:
    """A side of an erratum; its words where it is no formula."""
    tex = each.get(f"{side}_tex")
    if not tex:
        return str(each[side])
    # Docutils sets the index of an accented letter below it, unless they are parted.
    return "$" + re.sub(r"(\\d+ot\{[^}]*\})_", r"\1{}_", tex) + "$"


def format_effect(each: dict[str, Any]) -> str:
    """On angle and mesh force under constant torque and under PD control."""
    phrases = []
    for run, words in (("constant-torque", "constant torque"), ("pd", "PD control")):
        if effect := each["effects"].get(run):
            angle, force = effect["theta_rad"], effect["mesh_force_N"]
            phrases.append(f"{words}: {angle:.1e} rad, {float(f'{force:.2g}'):g} N")
    return "; ".join(phrases)


def format_counts(claims: list[dict[str, Any]]) -> str:
    """How many claims have each verdict in each column."""
    verdict_counts = {
        key: Counter(format_verdict(each, key).split(" (")[0] for each in claims) for key in COLUMNS
    }
    verdict_names = sorted({kind for column in verdict_counts.values() for kind in column})
    cells = ([kind, *(str(verdict_counts[key][kind]) for key in COLUMNS)] for kind in verdict_names)
    return format_table(["verdict", *COLUMNS.values()], cells)


def format_verdict(claim: dict[str, Any], column: str) -> str:
    """In words, with the counts of settings where they do not all say the same."""
    model_verdict = claim["models"].get(column)
    if model_verdict is None:  # decided without a run
        return str(claim["verdict"])
    by = model_verdict["counts"]
    mixed = [f"{by[kind]} {kind}" for kind in by if by[kind]]
    return (
        f"{model_verdict['verdict']} ({', '.join(mixed)})"
        if len(mixed) > 1
        else str(model_verdict["verdict"])
    )


def describe_close_verdicts(claims: list[dict[str, Any]]) -> str:
    """Which claims other limits judge otherwise."""
    simulated = [each for each in claims if not each["static"]]
    close = [each["id"] for each in simulated if each["turns_within_a_quarter"]]
    return (
        f"{len(close)} of {len(simulated)} verdicts that runs decide turn within 25 % of their"
        f" limit: {', '.join(close) or 'none'}.\n"
    )


def format_row(claim: dict[str, Any]) -> list[str]:
    """Of the table of claims; a statement with its reading, where there could be another."""
    reading = f" *Read as: {claim['reading']}.*" if claim["reading"] else ""
    columns = (format_verdict(claim, column) for column in COLUMNS)
    return [claim["id"], claim["statement"] + reading, *columns]


def _section(name: str) -> str:
    return name if not name[:1].isdigit() else f"Section {name}"


if __name__ == "__main__":
    PAGE.write_text(build_page(Path(sys.argv[1])), encoding="utf-8")
