"""The case study as an article for ReScience C: ``python -m tools.write_article RUN OUT``.

Reads claims.json and paper.html of RUN, a full `crosscheck paper`, and docs/case-study/argument.md;
writes what the journal's template takes: content.tex, metadata.yaml, bibliography.bib and drawings.
No number is written by hand: all are of the run's records, or of the argument.
"""

from __future__ import annotations

import html
import json
import re
import shutil
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from crosscheck.audit.page.chapter import TITLE
from crosscheck.models.errors import InputError
from crosscheck.provenance import ROOT
from tools import case_study

ARGUMENT = ROOT / "docs" / "case-study" / "argument.md"
REFERENCES = ROOT / "docs" / "references.bib"
CELL = r"<t[hd].*?>(.*?)</t[hd]>"
TAGS = {"b": "textbf", "i": "emph", "code": "texttt"}
GREEK = {"θ": "theta", "ζ": "zeta", "φ": "varphi", "ω": "omega", "π": "pi", "√": "surd"}
# What is no letter of the journal's fonts, or a command of LaTeX, in text.
SYMBOLS = {letter: rf"$\{name}$" for letter, name in GREEK.items()} | {
    **{mark: f"$_{number}$" for number, mark in enumerate("₀₁₂₃₄₅₆₇₈₉")},
    **{mark: f"\\{mark}" for mark in "&%#_$"},
    "²": "$^2$",
    "\N{MINUS SIGN}": "$-$",
    "µ": r"\textmu{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
}


def write_article(run: Path, out: Path) -> None:
    """Write the sources of the article on a run. Raises InputError if the argument quotes another.

    The drawings are SVG; content.tex asks for them as PDF.
    """
    result = json.loads((run / "claims.json").read_text(encoding="utf-8"))
    page = (run / "paper.html").read_text(encoding="utf-8")
    chapters, made = result["chapters"], result["provenance"]
    claims, findings = chapters["claims"], chapters["findings"]
    arguments = read_arguments(ARGUMENT, {each["id"]: each.get("verdict") for each in findings})
    (out / "figures").mkdir(parents=True, exist_ok=True)
    titled = enumerate(zip(case_study.split_findings(page), arguments, strict=True), 1)
    given = {
        "title": TITLE,
        "citation": result["paper"]["citation"],
        "made": f"{made['created'][:10]}, revision {made['revision']}, {made['machine']}",
        "read": escape(result["paper"]["read"]),
        "findings": [
            convert_finding(title, body, out / "figures" / f"finding-{number}.svg")
            | {"argument": argument}
            for number, ((title, body), argument) in titled
        ],
        "errata": convert_table(
            case_study.format_errata(chapters["errata"]), (0.13, 0.24, 0.24, 0.11, 0.11)
        ),
        "claim_count": len(claims),
        "counts": "; ".join(
            ": ".join(row[::2]) for row in split_table(case_study.format_counts(claims))[1:]
        ),
        "count_table": convert_table(case_study.format_counts(claims), (0.28, 0.28, 0.28)),
        "close": escape(case_study.describe_close_verdicts(claims)),
        "verdicts": convert_table(case_study.format_verdicts(findings), (0.25, 0.45, 0.14)),
    }
    templates = Environment(
        loader=FileSystemLoader(Path(__file__).with_name("article")),
        undefined=StrictUndefined,
        variable_start_string="<<",
        variable_end_string=">>",
        block_start_string="<%",
        block_end_string="%>",
        comment_start_string="<#",
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    for name in ("content.tex", "metadata.yaml"):
        (out / name).write_text(templates.get_template(name).render(given), encoding="utf-8")
    shutil.copy(REFERENCES, out / "bibliography.bib")


def read_arguments(file: Path, answers: Mapping[str, str | None]) -> list[str]:
    """The argument of every finding as LaTeX; answers: the computed ones, by the quoted names."""
    text = file.read_text(encoding="utf-8")
    for name, quoted in re.findall(r"`(verdict/[\w-]+)`: \*\*(.*?)\*\*", text):
        if answers.get(name) != quoted:
            raise InputError(str(file), name, quoted, f"the run says {answers.get(name)}")
    text = re.sub(r"^`verdict/.*\n", "", text, flags=re.M)
    text = re.sub(r" \(\[[^\]]*\]\([^)]*\)\)", "", text)  # a link that no sentence needs
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"`([^`]*)`", r"<code>\1</code>", text)
    return [convert_html(section) for section in re.split(r"^## .*$", text, flags=re.M)[1:]]


def convert_finding(title: str, body: str, file: Path) -> dict[str, str]:
    """Title, text and caption of a finding as LaTeX; its drawing, if any, is written to a file."""
    drawn = re.search(
        r"<figure.*?(<svg.*?</svg>)\s*<figcaption>(.*?)</figcaption></figure>", body, re.S
    )
    if drawn:
        file.write_text(drawn[1], encoding="utf-8")
        body = body.replace(drawn[0], "")
    return {
        "title": convert_html(title.partition(". ")[2]),
        "text": convert_html(body),
        "drawing": file.stem if drawn else "",
        "caption": convert_html(drawn[2]) if drawn else "",
    }


def convert_html(fragment: str) -> str:
    """A fragment of the page as LaTeX: paragraphs, words set apart, and tables."""
    tex = ""
    for piece in re.split(r"(<table.*?</table>|<[^>]*>)", fragment, flags=re.S):
        tag = re.match(r"<(/?)(\w+)", piece)
        if tag is None:
            tex += escape(html.unescape(piece))
        elif tag[2] == "table":
            lines = piece.split("</tr>")[:-1]
            rows = [list(map(convert_html, re.findall(CELL, line))) for line in lines]
            tex += format_table(rows, [0.84 / len(rows[0])] * len(rows[0]))
        elif tag[2] == "p":
            tex += "\n\n"
        elif tag[2] in TAGS:
            tex += "}" if tag[1] else rf"\{TAGS[tag[2]]}{{"
    quoted = re.sub(r'"([^"]*)"', r"``\1''", tex)
    return re.sub(r"\n\s*\n", "\n\n", quoted).strip()


def convert_table(markdown: str, widths: Sequence[float]) -> str:
    """The first columns of a table of the docs, as many as there are widths, as LaTeX."""
    return format_table(([escape(cell) for cell in row] for row in split_table(markdown)), widths)


def split_table(markdown: str) -> list[list[str]]:
    """The cells of a table of the docs, its heads first."""
    rows = [line.strip("| ").split(" | ") for line in markdown.strip().splitlines()]
    return [[cell.strip("`") for cell in row] for row in (rows[0], *rows[2:])]


def format_table(rows: Iterable[Sequence[str]], widths: Sequence[float]) -> str:
    """Cells as LaTeX, heads first; widths: of columns, as parts of the line's."""
    columns = "".join(rf"p{{{width:.2f}\linewidth}}" for width in widths)
    heads, *lines = [" & ".join(row[: len(widths)]) + r" \\" for row in rows]
    body = "\n".join([heads, r"\hline", *lines])
    return f"{{\\small\\noindent\\begin{{tabular}}{{{columns}}}\n{body}\n\\end{{tabular}}}}"


def escape(text: str) -> str:
    """Text with its formulas between dollars as LaTeX."""
    pieces = re.split(r"(\$[^$]+\$)", text)
    return "".join(
        piece if piece.startswith("$") else "".join(SYMBOLS.get(letter, letter) for letter in piece)
        for piece in pieces
    )


if __name__ == "__main__":
    try:
        write_article(Path(sys.argv[1]), Path(sys.argv[2]))
    except InputError as error:
        sys.exit(f"write_article: {error}")
