"""The claims as a table of the report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from crosscheck.paper.claims.judged import Group, Judged
from crosscheck.paper.claims.rule import DEFAULT_ZETA, LAWS
from crosscheck.paper.undefined import UNDEFINED, shown

VERDICTS = (
    "holds",
    "only with omega_t",
    "depends",
    "does not hold",
    UNDEFINED,
    "not simulated",
)
COLOURS = {"holds": "agree", "does not hold": "differ", "only with omega_t": "differ"}
NONE = "\N{EN DASH}"
INTRODUCTION = """<p>Which of the paper's statements survive? A statement is judged in cells: a
phase law (<code>omega_t</code>, the paper's own, with the ring rate of Eq. 13; <code>angle</code>,
its integral, with the corrected rate), a reading of Table I (labelled, swapped) and a damping ratio
zeta, of which the paper says nothing. The value decides against the threshold beside it. <em>holds
</em>: in every <code>angle</code> cell; <em>only with omega_t</em>: in some cell of the paper's law
and in none of <code>angle</code>; <em>does not hold</em>: in none; <em>depends on</em>: what the
paper leaves open. Values: default (zeta {default:g}, first choice of a free parameter), in brackets
the range over damping and free parameter, then in how many cells the statement is true. A cell is
<em>undefined</em>, neither true nor false, where what the statement is about does not happen in the
run or the run diverges: it is counted, and the verdict is that of the other cells; <em>undefined
</em> as a verdict: no <code>angle</code> cell is left. <em>not simulated</em>: left to the full
report.</p>"""


COVERAGE = """<p><strong>{count} statements.</strong> Damping ratios: {zetas}; ablations, sweeps of
backlash and tooth error and the run back and forth at fewer of them. What <code>angle</code> still
shows after 0.5 s, up to {third} rad/s² where the damping is lowest, owes at most {due}
rad/s² to the tooth error: a statement about &quot;the third fluctuation&quot; may there be true of
another one, which the chapter on the controller examines.</p>"""


class Left(NamedTuple):
    """What is left under `angle`: the largest third fluctuation, and its part due to tooth error.

    Both in rad/s^2.
    """

    third: float
    due_to_error: float


def table_html(found: Sequence[Judged], zetas: Sequence[float], left: Left) -> str:
    """The rule, the count of verdicts by section, and every claim's row."""
    sections = tuple(dict.fromkeys(one.claim.section for one in found))
    sweep = ", ".join(f"{zeta:g}" for zeta in zetas)
    third, due = shown(left.third), shown(left.due_to_error)
    parts = [
        INTRODUCTION.format(default=DEFAULT_ZETA),
        COVERAGE.format(count=len(found), zetas=sweep, third=third, due=due),
        _counts(sections, found),
        *(_section(section, found) for section in sections),
    ]
    return "\n".join(parts)


def _counts(sections: Sequence[str], found: Sequence[Judged]) -> str:
    """How many of each section's statements have which verdict."""
    counts = Counter((one.claim.section, one.verdict.verdict) for one in found)
    shown = [name for name in VERDICTS if any(counts[section, name] for section in sections)]
    rows = [[section, *(counts[section, name] for name in shown)] for section in sections]
    rows.append(["all", *(sum(counts[s, name] for s in sections) for name in shown)])
    lines = "".join(
        "<tr>" + "".join(f'<td class="n">{cell}</td>' for cell in row) + "</tr>" for row in rows
    )
    titles = "".join(f"<th>{name}</th>" for name in ("section", *shown))
    return f'<div class="wide"><table><tr>{titles}</tr>{lines}</table></div>'


def _section(section: str, found: Sequence[Judged]) -> str:
    title = section if section == "Abstract" else f"Section {section}"
    head = ("no.", "statement", "decided by", "threshold", *LAWS, "verdict", "figure")
    rows = [_row(one) for one in found if one.claim.section == section]
    lines = "\n".join(rows)
    titles = "".join(f"<th>{name}</th>" for name in head)
    return (
        f"<h3>{escape(title)}</h3>\n"
        f'<div class="wide"><table><tr>{titles}</tr>\n{lines}\n</table></div>'
    )


def _row(one: Judged) -> str:
    claim = one.claim
    colour = COLOURS.get(one.verdict.verdict, "unresolved")
    unit = "" if claim.unit == "1" else f" [{claim.unit}]"
    columns = [
        f"<td>{one.name}</td>",
        f"<td>{escape(claim.statement)}</td>",
        f"<td>{escape(claim.quantity + unit)}</td>",
        f"<td>{escape(str(claim.decide))}</td>",
        *(f'<td class="n">{_law(one, law)}</td>' for law in LAWS),
        f'<td class="{colour}">{escape(_verdict(one))}</td>',
        f"<td>{_link(claim.figure)}</td>",
    ]
    return f'<tr id="claim-{one.name}">' + "".join(columns) + "</tr>"


def _verdict(one: Judged) -> str:
    """In words, with how many cells have no say in it."""
    verdict, depends_on, undefined = one.verdict
    words = f"depends on {', '.join(depends_on)}" if depends_on else verdict
    return f"{words} ({undefined} of {one.cells} undefined)" if undefined else words


def _law(one: Judged, law: str) -> str:
    """Each reading under one law."""
    lines = [_reading(group) for group in one.groups if group.place.phase == law]
    return "<br>".join(lines) or NONE


def _reading(group: Group) -> str:
    """Default, range where there is one, counts of yes, undefined."""
    default, low, high = (_number(v) for v in (group.default, group.least, group.greatest))
    span = "" if low == high == default else f" [{low}, {high}]"
    undefined = f", {group.undefined} undefined" if group.undefined else ""
    reading = group.place.reading.removeprefix("paper-")
    return f"{reading}: {default}{span}; {group.yes}/{group.cells}{undefined}"


def _number(value: float | None) -> str:
    return NONE if value is None else f"{value:.3g}"


def _link(figure: int | None) -> str:
    return NONE if figure is None else f'<a href="#figure-{figure}">{figure}</a>'
