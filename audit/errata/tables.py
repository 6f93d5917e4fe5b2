"""The sheet's columns: slips, contradictions, gaps, for the page, for Markdown and for JSON."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

from markupsafe import Markup

from audit.errata.erratum import Effect, Slip
from audit.errata.notes import Contradiction, Gap
from audit.errata.typeset import formula_svg
from audit.page.columns import Column, Columns


@dataclass(frozen=True)
class ArmSlip:
    """A slip, its size and its effects those of an arm."""

    arm: str
    slip: Slip


@dataclass(frozen=True)
class FormulaColumn(Column[ArmSlip]):
    """Words, or a formula where there is one."""

    tex: Callable[[ArmSlip], str] = lambda row: ""

    def html(self, row: ArmSlip) -> str:
        return _drawn(self.tex(row)) if self.tex(row) else self.text(row)

    def markdown(self, row: ArmSlip) -> str:
        return f"${self.tex(row)}$" if self.tex(row) else super().markdown(row)


@lru_cache
def _drawn(tex: str) -> Markup:
    return Markup(formula_svg(tex))  # by this package's own typesetter


def _effect(scenario: str, part: Callable[[Effect], float]) -> Callable[[ArmSlip], float | None]:
    def of(row: ArmSlip) -> float | None:
        effect = row.slip.effects.get(scenario)
        return None if effect is None else part(effect)

    return of


SLIPS = Columns[ArmSlip](
    lambda row: f"erratum/{row.arm}/{row.slip.erratum.id}",
    (
        Column("where", "where", lambda row: row.slip.erratum.where),
        Column("kind", None, lambda row: row.slip.erratum.kind),
        FormulaColumn(
            "printed",
            "printed",
            lambda row: row.slip.erratum.printed,
            tex=lambda row: row.slip.erratum.printed_tex,
        ),
        FormulaColumn(
            "derived",
            "should read",
            lambda row: row.slip.erratum.derived,
            tex=lambda row: row.slip.erratum.derived_tex,
        ),
        Column("remark", "remark", lambda row: row.slip.erratum.remark),
        Column("size", "size", lambda row: row.slip.erratum.size),
        Column("unit", "in", lambda row: row.slip.erratum.unit),
        Column("relative", "over its own size", lambda row: row.slip.erratum.relative),
        Column("printed_tex", None, lambda row: row.slip.erratum.printed_tex),
        Column("derived_tex", None, lambda row: row.slip.erratum.derived_tex),
        Column(
            "constant_torque_theta_rad",
            "effect under 100 N m: angle [rad]",
            _effect("constant-torque", lambda effect: effect.theta_rad),
            ".2g",
        ),
        Column(
            "constant_torque_force_N",
            "force [N]",
            _effect("constant-torque", lambda effect: effect.mesh_force_N),
            ".2g",
        ),
        Column(
            "pd_theta_rad",
            "effect under PD control: angle [rad]",
            _effect("pd", lambda effect: effect.theta_rad),
            ".2g",
        ),
        Column("pd_force_N", "force [N]", _effect("pd", lambda effect: effect.mesh_force_N), ".2g"),
    ),
)
CONTRADICTIONS = Columns[Contradiction](
    lambda row: f"contradiction/{row.id}",
    (
        Column("first", "here", lambda row: row.first),
        Column("first_says", "it says", lambda row: row.first_says),
        Column("second", "there", lambda row: row.second),
        Column("second_says", "it says", lambda row: row.second_says),
    ),
)
GAPS = Columns[Gap](
    lambda row: f"gap/{row.id}",
    (
        Column("quantity", "not given", lambda row: row.quantity),
        Column("needed_for", "needed for", lambda row: row.needed_for),
        Column("here", "here", lambda row: row.here),
    ),
)
