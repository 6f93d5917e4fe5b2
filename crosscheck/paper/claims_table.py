"""The claims as a table of the report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import Any

from crosscheck.paper.claims_rule import DEFAULT_ZETA, LAWS

VERDICTS = ("holds", "only with omega_t", "depends", "does not hold", "not simulated")
COLOURS = {"holds": "agree", "does not hold": "differ", "only with omega_t": "differ"}
NONE = "\N{EN DASH}"
INTRODUCTION = """<p>Which of the paper's statements survive? A statement is judged in cells: a
phase law (<code>omega_t</code>, the paper's own, with the ring rate of Eq. 13; <code>angle</code>,
its integral, with the corrected rate), a reading of Table I (labelled, swapped) and a damping ratio
zeta, of which the paper says nothing. The value decides against the threshold beside it. <em>holds
</em>: in every <code>angle</code> cell; <em>only with omega_t</em>: in some cell of the paper's law
and in none of <code>angle</code>; <em>does not hold</em>: in none; <em>depends on</em>: what the
paper leaves open. Values: default (zeta {default:g}, first choice of a free parameter), in brackets
the range over damping and free parameter, then in how many cells the statement is true.</p>"""


def table_html(records: Sequence[dict[str, Any]], zetas: Sequence[float]) -> str:
    counts = Counter(record["verdict"] for record in records)
    tally = ", ".join(f"{name}: {counts[name]}" for name in VERDICTS if counts[name])
    sweep = ", ".join(f"{zeta:g}" for zeta in zetas)
    return "\n".join(
        [
            INTRODUCTION.format(default=DEFAULT_ZETA),
            f"<p><strong>{len(records)} statements. {escape(tally)}.</strong>"
            f" Damping ratios: {sweep}; sweeps of backlash and tooth error, and the run back and"
            " forth, at fewer of them (see the records).</p>",
            *(
                _section(section, records)
                for section in dict.fromkeys(r["section"] for r in records)
            ),
        ]
    )


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
    on = ", ".join(record["depends_on"])
    shown = f"depends on {on}" if on else record["verdict"]
    unit = "" if record["unit"] == "1" else f" [{record['unit']}]"
    columns = [
        f"<td>{record['id']}</td>",
        f"<td>{escape(record['statement'])}</td>",
        f"<td>{escape(record['quantity'] + unit)}</td>",
        f"<td>{escape(record['threshold'])}</td>",
        *(f'<td class="n">{_law(record, law)}</td>' for law in LAWS),
        f'<td class="{COLOURS.get(record["verdict"], "unresolved")}">{escape(shown)}</td>',
        f"<td>{_link(record['figure'])}</td>",
    ]
    return f'<tr id="claim-{record["id"]}">' + "".join(columns) + "</tr>"


def _law(record: dict[str, Any], law: str) -> str:
    """Default, range and count of each reading under one law."""
    lines = []
    for name, group in record["values"].items():
        if name.startswith(f"{law}, "):
            reading = name.removeprefix(f"{law}, paper-")
            span = f"[{_number(group['min'])}, {_number(group['max'])}]"
            lines.append(
                f"{reading}: {_number(group['default'])} {span} {group['yes']}/{group['cells']}"
            )
    return "<br>".join(lines) or NONE


def _number(value: float | None) -> str:
    return NONE if value is None else f"{value:.3g}"


def _link(figure: int | None) -> str:
    return NONE if figure is None else f'<a href="#figure-{figure}">{figure}</a>'
