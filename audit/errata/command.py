"""What the command `errata` does, once the command line is parsed."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console

from crosscheck.audit.errata.errata_texts import add_errata_texts
from crosscheck.audit.errata.erratum import CLASSES
from crosscheck.audit.errata.finder import EFFECT_S, SCHEMA_VERSION, simulate_errata
from crosscheck.audit.errata.lines import format_errata
from crosscheck.file_types import ERRATA, PAPER_PAGE, SHEET
from crosscheck.models.loading import load_arm
from crosscheck.output import require_files, write_files

ERRATA_SHEET, ERRATA_PAGE = "errata.md", "errata.html"


def run_errata_command(
    arm_name: str, json_file: Path | None, out: Path | None, whole: bool
) -> None:
    """Print the errata of an arm; write them as JSON and as a sheet if asked. Raises InputError.

    whole: whether statements and notation are printed too. What sets the sheet is imported only
    where one is written: it takes longer than half of the search for errata.
    """
    arm = load_arm(arm_name)
    sheets = {} if out is None else {out / ERRATA_SHEET: SHEET, out / ERRATA_PAGE: PAPER_PAGE}
    require_files((json_file, ERRATA), *sheets.items())
    with Console(stderr=True).status("errata") as status:
        errata = add_errata_texts(
            simulate_errata(arm, lambda row: status.update(f"effect of {row}"))
        )
    for line in format_errata(errata, arm.name, CLASSES if whole else CLASSES[:1]):
        print(line)
    if json_file is None and out is None:
        return
    from crosscheck.audit.errata.sheet import build_errata_sheet, build_record, format_markdown
    from crosscheck.audit.page.report import render_chapters
    from crosscheck.provenance import record_provenance

    record = record_provenance(arm, 0, False).model_dump(mode="json")
    contents: dict[Path, str | bytes] = {}
    if json_file is not None:
        document = {
            "schema_version": SCHEMA_VERSION,
            "errata": [build_record(arm.name, erratum) for erratum in errata],
            "provenance": record,
        }
        contents[json_file] = json.dumps(document, indent=1, allow_nan=False) + "\n"
    if out is not None:
        sheet = build_errata_sheet({arm.name: errata}, EFFECT_S)
        contents |= dict(
            zip(sheets, (format_markdown(errata), render_chapters([sheet], record)), strict=True)
        )
    write_files(contents)
    if out is not None:
        print(f"wrote {' and '.join(map(str, sheets))}")
