"""The sheet's sections: what is computed, and what a careful reader finds in the text itself."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import NamedTuple

from pydantic import TypeAdapter

from crosscheck.audit.claims.statements import quote_claim
from crosscheck.audit.errata.erratum import Erratum
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.models.files import read_toml
from crosscheck.report.formatting import format_rounded

NOTES = Path(__file__).with_name("texts") / "notes.toml"
NONE = "-"


class SectionText(NamedTuple):
    """A section of the sheet: its heading, and its columns' titles by field."""

    heading: str
    columns: dict[str, str]


class Notes(NamedTuple):
    """What is found by reading: entries, two places that cannot both be right, what is not given.

    Contradictions and gaps: what stands in the columns of those names. sections: by kind of record.
    """

    sections: dict[str, SectionText]
    entries: tuple[Erratum, ...]
    contradictions: tuple[dict[str, str], ...]
    gaps: tuple[dict[str, str], ...]


@cache
def load_notes() -> Notes:
    """The notes of notes.toml."""
    return TypeAdapter(Notes).validate_python(read_toml(NOTES))


class SheetSection(NamedTuple):
    """A heading of the sheet, with the table of its records; columns: titles by field."""

    heading: str
    columns: Mapping[str, str]
    records: Sequence[Mapping[str, object]]

    def list_rows(self, draw_formula: Callable[[str], str] | None = None) -> list[list[str]]:
        """The rows; where a record has the TeX of a cell, that is drawn if asked."""
        rows = []
        for record in self.records:
            row = [NONE if record[name] is None else str(record[name]) for name in self.columns]
            if draw_formula:
                formulas = [str(record.get(f"{name}_tex") or "") for name in self.columns]
                row = [
                    draw_formula(tex) if tex else text
                    for tex, text in zip(formulas, row, strict=True)
                ]
            rows.append(row)
        return rows


def list_sections(arm: str, errata: Sequence[Erratum]) -> list[SheetSection]:
    """The sheet's sections: the errors of equations, here for an arm, and all that is read."""
    noted = load_notes()
    records: dict[str, Sequence[Mapping[str, object]]] = {
        "equation": [build_record(arm, entry) for entry in errata],
        "contradiction": noted.contradictions,
        "gap": noted.gaps,
    }
    for kind in ("statement", "notation"):
        records[kind] = [build_record(arm, entry) for entry in noted.entries if entry.kind == kind]
    return [SheetSection(*text, records[kind]) for kind, text in noted.sections.items()]


def build_record(arm: str, erratum: Erratum) -> JsonObject:
    """An erratum with its size and effects for an arm, as JSON, in numbers and in words."""
    sizes = {} if erratum.size is None else {erratum.unit: erratum.size, **erratum.others}
    texts = [f"{format_rounded(size, 3)} {unit}" for unit, size in sizes.items()]
    return {
        "id": f"erratum/{arm}/{erratum.id}",
        "class": erratum.kind,
        "where": erratum.where,
        "printed": erratum.printed,
        "derived": erratum.derived,
        "printed_tex": erratum.printed_tex,
        "derived_tex": erratum.derived_tex,
        "remark": erratum.remark,
        "denies": ", ".join(erratum.denies),
        "denied_claims": "; ".join(map(quote_claim, erratum.denies)),
        "size": erratum.size,
        "unit": erratum.unit,
        "other_sizes": dict(erratum.others),
        "size_in_words": "; ".join(texts),
        "effects": {name: asdict(effect) for name, effect in erratum.effects.items()},
        "constant_torque": _describe_effect(erratum, "constant-torque"),
        "pd": _describe_effect(erratum, "pd"),
    }


def _describe_effect(erratum: Erratum, scenario: str) -> str | None:
    """The effect in a scenario in words; None if it was not run."""
    effect = erratum.effects.get(scenario)
    if effect is None:
        return None
    return (
        f"angle {effect.theta_rad:.2g} rad, force {format_rounded(effect.mesh_force_N, 2)} N,"
        f" impulse {effect.impulse_N_s:.2g} N s"
    )


WIDTH = 79


def format_sections(sections: Sequence[SheetSection], whole: bool) -> Iterator[str]:
    """The lines of all sections, or of the first; how many entries the others then have."""
    for section in sections if whole else sections[:1]:
        yield f"{section.heading}: {len(section.records)}"
        for row in section.list_rows():
            (_, first), *rest = zip(section.columns.values(), row, strict=True)
            yield ""
            yield from _wrap(first, "")
            for title, text in rest:
                if text not in ("", NONE):
                    yield from _wrap(f"{title}: {text}", "  ")
        yield ""
    if not whole:
        counts = "; ".join(f"{each.heading}: {len(each.records)}" for each in sections[1:])
        yield from _wrap(
            f"{counts} (--all prints these too; crosscheck paper lists the claims)", ""
        )


def _wrap(text: str, indent: str) -> list[str]:
    """A text wrapped between words; a word that is longer than a line stays whole."""
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=2 * indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
