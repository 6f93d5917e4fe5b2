"""The errata sheet: what one could send to the authors, as a chapter and as Markdown."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from html import escape
from typing import Any

from crosscheck.paper.errata.finder import EFFECT_S, errata_records
from crosscheck.paper.errata.referee import CONTRADICTIONS, GAPS
from crosscheck.paper.errata.typeset import formula_svg
from crosscheck.paper.scale import Scale
from crosscheck.report.chapter import Chapter
from crosscheck.studies.study import Study
from models.loading import load_arm

ID, TITLE = "errata", "Errata sheet"
ARMS = ("paper-labelled", "paper-swapped")
QUICK_S = 0.05
INTRODUCTION = (
    "Each slip was found by a program that derives the same quantity from the paper's own premises"
    " or from first principles. The effect is the largest change of a joint angle and of a mesh"
    " force per planet when this one slip is put right and everything else stays. What the phase of"
    " Eqs. 8 and 14 does later in a run and with less damping has a chapter of its own."
)


@dataclass(frozen=True)
class Errata:
    """The errata of a built-in arm, their effects simulated for so long."""

    arm: str
    duration_s: float

    @property
    def inputs(self) -> str:
        return "\n".join([repr(self), load_arm(self.arm).model_dump_json()])

    @property
    def cost(self) -> float:
        return 10 * self.duration_s

    def answer(self) -> list[dict[str, Any]]:
        found = errata_records(load_arm(self.arm), lambda where: None, self.duration_s)
        return [{"id": f"erratum/{self.arm}/{record['where']}", **record} for record in found]


def chapter(study: Study, scale: Scale) -> Chapter:
    """The errata sheet for both readings of Table I (the quick one for the first alone)."""
    arms = ARMS[:1] if scale.quick else ARMS
    duration = scale.seconds(QUICK_S if scale.quick else EFFECT_S)
    found = study.answers([Errata(name, duration) for name in arms], "errata sheet")
    records = [record for errata in found for record in errata]
    html = [f"<p>{INTRODUCTION} Runs of {duration:g} s, arm {ARMS[0]}.</p>", _table(found[0])]
    html += [_readings(records)] if not scale.quick else []
    html += [_contradictions(), _gaps()]
    outcome = f"{len(found[0])} slips, {len(CONTRADICTIONS)} contradictions, {len(GAPS)} gaps."
    return Chapter(ID, TITLE, "\n".join(html), records, outcome)


def _table(records: list[dict[str, Any]]) -> str:
    rows = "".join(_row(record) for record in records)
    head = "<tr><th>where</th><th>printed</th><th>should read</th><th>size</th><th>effect</th></tr>"
    return f'<h3>Slips</h3><div class="wide"><table>{head}{rows}</table></div>'


def _row(record: dict[str, Any]) -> str:
    cells = (
        escape(record["where"]),
        _formula(record["printed_tex"], record["printed"]),
        f"{_formula(record['derived_tex'], record['derived'])} {escape(record['remark'])}",
        _size(record),
        "<br>".join(escape(effect) for effect in effects(record)),
    )
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


@lru_cache
def _formula(tex: str, text: str) -> str:
    """The typeset formula, or the words where there is none."""
    return formula_svg(tex) if tex else escape(text)


def _size(record: dict[str, Any]) -> str:
    if record["size"] is None:
        return ""
    relative = "" if record["relative"] is None else f" ({100 * record['relative']:.3g} %)"
    return escape(f"{record['size']:.3g} {record['unit']}{relative}")


def effects(record: dict[str, Any]) -> list[str]:
    """One line per scenario that was simulated."""
    return [
        f"{name}: {effect['theta_rad']:.3g} rad, {effect['mesh_force_N']:.3g} N"
        for name, effect in record["effects"].items()
    ]


def _readings(records: list[dict[str, Any]]) -> str:
    """Which slips exist under one reading of Table I alone."""
    by_arm = [
        {record["where"] for record in records if record["id"].startswith(f"erratum/{name}/")}
        for name in ARMS
    ]
    lines = [
        f"under {name} alone: {', '.join(sorted(own - other)) or 'none'}"
        for name, own, other in zip(ARMS, by_arm, reversed(by_arm), strict=True)
    ]
    return f"<p>Slips that depend on the reading of Table I: {escape('; '.join(lines))}.</p>"


def _contradictions() -> str:
    rows = "".join(
        f"<tr><td>{escape(c.first)}</td><td>{escape(c.first_says)}</td>"
        f"<td>{escape(c.second)}</td><td>{escape(c.second_says)}</td></tr>"
        for c in CONTRADICTIONS
    )
    head = "<tr><th>here</th><th>it says</th><th>there</th><th>it says</th></tr>"
    title = "<h3>Where the text contradicts itself</h3>"
    return f'{title}<div class="wide"><table>{head}{rows}</table></div>'


def _gaps() -> str:
    rows = "".join(
        f"<tr><td>{escape(g.quantity)}</td><td>{escape(g.needed_for)}</td>"
        f"<td>{escape(g.here)}</td></tr>"
        for g in GAPS
    )
    head = "<tr><th>not given</th><th>needed for</th><th>here</th></tr>"
    title = "<h3>What is missing to reproduce it</h3>"
    return f'{title}<div class="wide"><table>{head}{rows}</table></div>'


def markdown(records: list[dict[str, Any]]) -> str:
    """The sheet as Markdown, formulas as TeX; records as the chapter's."""
    lines = ["# Errata sheet", "", INTRODUCTION, ""]
    lines += ["| where | printed | should read | size | effect |", "|---|---|---|---|---|"]
    for record in records:
        if record["id"].startswith(f"erratum/{ARMS[0]}/"):
            formulas = [_markdown_formula(record, side) for side in ("printed", "derived")]
            formulas[1] = f"{formulas[1]} {record['remark']}".strip()
            cells = [record["where"], *formulas, _size(record), "; ".join(effects(record))]
            lines.append("| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |")
    lines += ["", "## Where the text contradicts itself", ""]
    lines += [f"- {c.first}: {c.first_says}. {c.second}: {c.second_says}." for c in CONTRADICTIONS]
    lines += ["", "## What is missing to reproduce it", ""]
    lines += [f"- {g.quantity} (for {g.needed_for}); here: {g.here}." for g in GAPS]
    return "\n".join(lines) + "\n"


def _markdown_formula(record: dict[str, Any], side: str) -> str:
    tex = record[f"{side}_tex"]
    return f"${tex}$" if tex else str(record[side])
