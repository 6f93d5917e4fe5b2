"""The sheet's sections: what is computed, and what a careful reader finds in the text itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from pydantic import TypeAdapter

from crosscheck.audit.errata.erratum import Erratum
from crosscheck.audit.measures.undefined import JsonObject, to_json
from crosscheck.audit.page.columns import Columns, format_cells
from crosscheck.models.files import read_toml

NOTES = Path(__file__).with_name("texts") / "notes.toml"
NOTATION = {
    "where": ("where", ""),
    "printed": ("printed", ""),
    "derived": ("should read", ""),
    "remark": ("remark", ""),
}
STATEMENT = NOTATION | {"denies": ("against claim", "")}
EQUATION = STATEMENT | {
    "size": ("size", ".3g"),
    "unit": ("unit", ""),
    "relative": ("over its own size", ".3g"),
    "constant_torque_theta_rad": ("effect under 100 N m: angle [rad]", ".2g"),
    "constant_torque_force_N": ("mesh force [N]", ".2g"),
    "pd_theta_rad": ("effect under PD control: angle [rad]", ".2g"),
    "pd_impulse_N_s": ("impulse of a mesh [N s]", ".2g"),
}
CONTRADICTION = {
    "first": ("here", ""),
    "first_says": ("it says", ""),
    "second": ("there", ""),
    "second_says": ("it says", ""),
}
GAP = {
    "quantity": ("not given in the text", ""),
    "needed_for": ("needed for", ""),
    "here": ("here", ""),
}


class Notes(NamedTuple):
    """What is found by reading: entries, two places that cannot both be right, what is not given.

    Contradictions and gaps: what stands in the columns of those names.
    """

    entries: tuple[Erratum, ...]
    contradictions: tuple[dict[str, str], ...]
    gaps: tuple[dict[str, str], ...]


@cache
def load_notes() -> Notes:
    """The notes of notes.toml."""
    return TypeAdapter(Notes).validate_python(read_toml(NOTES))


class SheetSection(NamedTuple):
    """A heading of the sheet, with the table of its records."""

    heading: str
    columns: Columns
    records: Sequence[Mapping[str, object]]

    def list_rows(self, draw_formula: Callable[[str], str] | None = None) -> list[list[str]]:
        """The rows; where a record has the TeX of a cell, that is drawn if asked."""
        return [
            [
                draw_formula(str(tex))
                if draw_formula and (tex := record.get(f"{name}_tex"))
                else text
                for name, text in zip(self.columns, format_cells(self.columns, record), strict=True)
            ]
            for record in self.records
        ]


def list_sections(arm: str, errata: Sequence[Erratum]) -> list[SheetSection]:
    """The sheet's sections: the errors of equations, here for an arm, and all that is read."""
    noted = load_notes()
    statements, notation = (
        [build_record(arm, entry) for entry in noted.entries if entry.kind == kind]
        for kind in ("statement", "notation")
    )
    equations = [build_record(arm, entry) for entry in errata]
    return [
        SheetSection("Errors of equations", EQUATION, equations),
        SheetSection("Statements and data without support", STATEMENT, statements),
        SheetSection("Where the text contradicts itself", CONTRADICTION, noted.contradictions),
        SheetSection("Notation that misleads", NOTATION, notation),
        SheetSection("What the text does not give", GAP, noted.gaps),
    ]


def build_record(arm: str, erratum: Erratum) -> JsonObject:
    """An erratum with its size and effects for an arm, as JSON."""
    torque, pd = (erratum.effects.get(name) for name in ("constant-torque", "pd"))
    return to_json(
        {
            "id": f"erratum/{arm}/{erratum.id}",
            "class": erratum.kind,
            "printed_tex": erratum.printed_tex,
            "derived_tex": erratum.derived_tex,
            "constant_torque_impulse_N_s": torque and torque.impulse_N_s,
            "pd_force_N": pd and pd.mesh_force_N,
            "where": erratum.where,
            "printed": erratum.printed,
            "derived": erratum.derived,
            "remark": erratum.remark,
            "denies": ", ".join(erratum.denies),
            "size": erratum.size,
            "unit": erratum.unit,
            "relative": erratum.relative,
            "constant_torque_theta_rad": torque and torque.theta_rad,
            "constant_torque_force_N": torque and torque.mesh_force_N,
            "pd_theta_rad": pd and pd.theta_rad,
            "pd_impulse_N_s": pd and pd.impulse_N_s,
        }
    )
