"""What the command `errata` does, once the command line is parsed."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from crosscheck.audit.errata.errata_texts import format_sections, list_sections
from crosscheck.audit.errata.finder import EFFECT_S, SCHEMA_VERSION, simulate_errata
from crosscheck.file_types import ERRATA, PAPER_PAGE
from crosscheck.models.loading import load_arm
from crosscheck.output import require_files, write_files
from crosscheck.report.records import format_json

ERRATA_PAGE = "errata.html"


def run_errata_command(
    arm_name: str, json_file: Path | None, out: Path | None, whole: bool
) -> None:
    """Print the errata of an arm; write them as JSON and as a sheet if asked. Raises InputError.

    whole: whether statements and notation are printed too. What sets the sheet is imported only
    where one is written: it takes longer than half of the search for errata.
    """
    arm = load_arm(arm_name)
    sheet_file = None if out is None else out / ERRATA_PAGE
    require_files((json_file, ERRATA), (sheet_file, PAPER_PAGE))
    with Console(stderr=True).status("errata") as status:
        errata = simulate_errata(arm, lambda row: status.update(f"effect of {row}"))
    sections = list_sections(arm.name, errata)
    for line in format_sections(sections, whole):
        print(line)
    if json_file is None and sheet_file is None:
        return
    from crosscheck.audit.errata.sheet import build_sheet
    from crosscheck.audit.page.report import render_chapters
    from crosscheck.provenance import record_provenance

    record = record_provenance(arm, 0, False).model_dump(mode="json")
    contents: dict[Path, str | bytes] = {}
    if json_file is not None:
        document = {
            "schema_version": SCHEMA_VERSION,
            "errata": [row for section in sections for row in section.records],
            "provenance": record,
        }
        contents[json_file] = format_json(document)
    if sheet_file is not None:
        contents[sheet_file] = render_chapters([build_sheet(sections, EFFECT_S)], record)
    write_files(contents)
    if sheet_file is not None:
        print(f"wrote {sheet_file}")
