"""The errata sheet: what one could send to the authors, as a chapter and as Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from html import escape

from crosscheck.paper.errata.erratum import Erratum, Slip
from crosscheck.paper.errata.finder import EFFECT_S, errata_records
from crosscheck.paper.errata.referee import CONTRADICTIONS, GAPS
from crosscheck.paper.errata.typeset import formula_svg
from crosscheck.paper.record import JsonObject, Record, read
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

    def answer(self) -> list[JsonObject]:
        found = errata_records(load_arm(self.arm), lambda where: None, self.duration_s)
        return [asdict(slip) for slip in found]


@dataclass(frozen=True)
class ArmSlip(Record):
    """A slip, its size and its effects those of an arm."""

    arm: str
    slip: Slip

    @property
    def id(self) -> str:
        return f"erratum/{self.arm}/{self.slip.erratum.where}"

    def to_dict(self) -> JsonObject:
        return {"id": self.id, **self.slip.to_dict()}


@dataclass(frozen=True)
class ErrataSheet(Chapter):
    """The chapter, with the slips in it that are those of the first arm."""

    slips: tuple[Slip, ...] = ()


def chapter(study: Study, scale: Scale) -> ErrataSheet:
    """The errata sheet for both readings of Table I (the quick one for the first alone)."""
    arms = ARMS[:1] if scale.quick else ARMS
    duration = scale.seconds(QUICK_S if scale.quick else EFFECT_S)
    answers = study.answers([Errata(name, duration) for name in arms], "errata sheet")
    found = dict(zip(arms, read(list[tuple[Slip, ...]], answers), strict=True))
    slips = found[ARMS[0]]
    html = [f"<p>{INTRODUCTION} Runs of {duration:g} s, arm {ARMS[0]}.</p>", _table(slips)]
    html += [_readings(found)] if not scale.quick else []
    html += [_contradictions(), _gaps()]
    records = [ArmSlip(arm, slip).to_dict() for arm, own in found.items() for slip in own]
    outcome = f"{len(slips)} slips, {len(CONTRADICTIONS)} contradictions, {len(GAPS)} gaps."
    return ErrataSheet(ID, TITLE, "\n".join(html), records, outcome, slips)


def _table(slips: Sequence[Slip]) -> str:
    rows = "".join(_row(slip) for slip in slips)
    head = "<tr><th>where</th><th>printed</th><th>should read</th><th>size</th><th>effect</th></tr>"
    return f'<h3>Slips</h3><div class="wide"><table>{head}{rows}</table></div>'


def _row(slip: Slip) -> str:
    erratum = slip.erratum
    cells = (
        escape(erratum.where),
        _formula(erratum.printed_tex, erratum.printed),
        f"{_formula(erratum.derived_tex, erratum.derived)} {escape(erratum.remark)}",
        escape(_size(erratum)),
        "<br>".join(escape(effect) for effect in effects(slip)),
    )
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


@lru_cache
def _formula(tex: str, text: str) -> str:
    """The typeset formula, or the words where there is none."""
    return formula_svg(tex) if tex else escape(text)


def _size(erratum: Erratum) -> str:
    if erratum.size is None:
        return ""
    relative = "" if erratum.relative is None else f" ({100 * erratum.relative:.3g} %)"
    return f"{erratum.size:.3g} {erratum.unit}{relative}"


def effects(slip: Slip) -> list[str]:
    """One line per scenario that was simulated."""
    return [
        f"{name}: {effect.theta_rad:.3g} rad, {effect.mesh_force_N:.3g} N"
        for name, effect in slip.effects.items()
    ]


def _readings(found: Mapping[str, Sequence[Slip]]) -> str:
    """Which slips exist under one reading of Table I alone."""
    by_arm = [{slip.erratum.where for slip in found[name]} for name in ARMS]
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


def markdown(slips: Sequence[Slip]) -> str:
    """The sheet as Markdown, formulas as TeX; the slips are the chapter's."""
    lines = ["# Errata sheet", "", INTRODUCTION, ""]
    lines += ["| where | printed | should read | size | effect |", "|---|---|---|---|---|"]
    lines += [f"| {' | '.join(_markdown_cells(slip))} |" for slip in slips]
    lines += ["", "## Where the text contradicts itself", ""]
    lines += [f"- {c.first}: {c.first_says}. {c.second}: {c.second_says}." for c in CONTRADICTIONS]
    lines += ["", "## What is missing to reproduce it", ""]
    lines += [f"- {g.quantity} (for {g.needed_for}); here: {g.here}." for g in GAPS]
    return "\n".join(lines) + "\n"


def _markdown_cells(slip: Slip) -> list[str]:
    erratum = slip.erratum
    derived = _markdown_formula(erratum.derived_tex, erratum.derived)
    cells = (
        erratum.where,
        _markdown_formula(erratum.printed_tex, erratum.printed),
        f"{derived} {erratum.remark}".strip(),
        _size(erratum),
        "; ".join(effects(slip)),
    )
    return [cell.replace("|", r"\|") for cell in cells]


def _markdown_formula(tex: str, text: str) -> str:
    return f"${tex}$" if tex else text
