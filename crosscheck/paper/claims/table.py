"""The claims as a table of the report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import Any

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


def table_html(
    records: Sequence[dict[str, Any]], zetas: Sequence[float], left: tuple[float, float]
) -> str:
    """The rule, the count of verdicts by section, and every claim's row.

    left: the largest third fluctuation [rad/s^2] under `angle`, and its part due to tooth error.
    """
    sections = tuple(dict.fromkeys(record["section"] for record in records))
    sweep = ", ".join(f"{zeta:g}" for zeta in zetas)
    parts = [
        INTRODUCTION.format(default=DEFAULT_ZETA),
        COVERAGE.format(count=len(records), zetas=sweep, third=shown(left[0]), due=shown(left[1])),
        _counts(sections, records),
        *(_section(section, records) for section in sections),
    ]
    return "\n".join(parts)


def _counts(sections: Sequence[str], records: Sequence[dict[str, Any]]) -> str:
    """How many of each section's statements have which verdict."""
    counts = Counter((record["section"], record["verdict"]) for record in records)
    shown = [name for name in VERDICTS if any(counts[section, name] for section in sections)]
    rows = [[section, *(counts[section, name] for name in shown)] for section in sections]
    rows.append(["all", *(sum(counts[s, name] for s in sections) for name in shown)])
    lines = "".join(
        "<tr>" + "".join(f'<td class="n">{cell}</td>' for cell in row) + "</tr>" for row in rows
    )
    titles = "".join(f"<th>{name}</th>" for name in ("section", *shown))
    return f'<div class="wide"><table><tr>{titles}</tr>{lines}</table></div>'


def _section(section: str, records: Sequence[dict[str, Any]]) -> str:
    title = section if section == "Abstract" else f"Section {section}"
    head = ("no.", "statement", "decided by", "threshold", *LAWS, "verdict", "figure")
    rows = [_row(record) for record in records if record["section"] == section]
    lines = "\n".join(rows)
    titles = "".join(f"<th>{name}</th>" for name in head)
    return (
        f"<h3>{escape(title)}</h3>\n"
        f'<div class="wide"><table><tr>{titles}</tr>\n{lines}\n</table></div>'
    )


def _row(record: dict[str, Any]) -> str:
    colour = COLOURS.get(record["verdict"], "unresolved")
    unit = "" if record["unit"] == "1" else f" [{record['unit']}]"
    columns = [
        f"<td>{record['id']}</td>",
        f"<td>{escape(record['statement'])}</td>",
        f"<td>{escape(record['quantity'] + unit)}</td>",
        f"<td>{escape(record['threshold'])}</td>",
        *(f'<td class="n">{_law(record, law)}</td>' for law in LAWS),
        f'<td class="{colour}">{escape(_verdict(record))}</td>',
        f"<td>{_link(record['figure'])}</td>",
    ]
    return f'<tr id="claim-{record["id"]}">' + "".join(columns) + "</tr>"


def _verdict(record: dict[str, Any]) -> str:
    """In words, with how many cells have no say in it."""
    on = ", ".join(record["depends_on"])
    verdict = f"depends on {on}" if on else record["verdict"]
    cells = sum(group["cells"] for group in record["values"].values())
    undefined = record["undefined"]
    return f"{verdict} ({undefined} of {cells} undefined)" if undefined else str(verdict)


def _law(record: dict[str, Any], law: str) -> str:
    """Each reading under one law: default, range where there is one, counts of yes, undefined."""
    lines = []
    for name, group in record["values"].items():
        if name.startswith(f"{law}, "):
            reading = name.removeprefix(f"{law}, paper-")
            low, high = _number(group["min"]), _number(group["max"])
            span = "" if low == high == _number(group["default"]) else f" [{low}, {high}]"
            count = f"{group['yes']}/{group['cells']}"
            if group["undefined"]:
                count += f", {group['undefined']} undefined"
            lines.append(f"{reading}: {_number(group['default'])}{span}; {count}")
    return "<br>".join(lines) or NONE


def _number(value: float | None) -> str:
    return NONE if value is None else f"{value:.3g}"


def _link(figure: int | None) -> str:
    return NONE if figure is None else f'<a href="#figure-{figure}">{figure}</a>'
