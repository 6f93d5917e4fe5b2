"""What the paper's commands do, once the command line is parsed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from crosscheck.audit.errata.errata_texts import add_errata_texts
from crosscheck.audit.errata.erratum import CLASSES
from crosscheck.audit.errata.finder import EFFECT_S, SCHEMA_VERSION, simulate_errata
from crosscheck.audit.errata.lines import format_errata
from crosscheck.audit.errata.sheet import WHOLE, ArmErratum, build_errata_sheet, format_markdown
from crosscheck.audit.experiments.scale import FULL
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.page.report import ERRATA as ERRATA_SHEET
from crosscheck.audit.page.report import (
    FILES,
    PAGE,
    render_chapters,
    write_figures,
    write_paper,
)
from crosscheck.file_types import ERRATA, PAPER_PAGE, SHEET
from crosscheck.models.directories import cache_folder
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.output import require_files, write_files
from crosscheck.provenance import record_provenance
from crosscheck.runner.progress import progress_bar

FIGURES = tuple(range(4, 21))
ERRATA_PAGE = "errata.html"


def run_errata_command(
    arm_name: str, json_file: Path | None, out: Path | None, whole: bool
) -> None:
    """Print the errata of an arm; write them as JSON and as a sheet if asked. Raises InputError.

    whole: whether statements and notation are printed too.
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
    record = record_provenance(arm, 0, False).model_dump(mode="json")
    contents: dict[Path, str | bytes] = {}
    if json_file is not None:
        document = {
            "schema_version": SCHEMA_VERSION,
            "errata": WHOLE.json(ArmErratum(arm.name, erratum) for erratum in errata),
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


def run_paper_command(figures: list[int], out: Path, jobs: int, first_seed: int = 1) -> None:
    """Write the paper's page, or some of its figures alone. Raises InputError."""
    if first_seed < 0:
        raise InputError("--first-seed", "", first_seed, "must be 0 or more")
    unknown = [number for number in figures if number not in FIGURES]
    if unknown:
        raise InputError("--figure", "", unknown[0], f"must be {FIGURES[0]} to {FIGURES[-1]}")
    scale = replace(FULL, first_seed=first_seed)
    files = {PAGE: PAPER_PAGE} if figures else FILES
    require_files(*((out / name, kind) for name, kind in files.items()))
    with progress_bar() as progress:
        study = Study(cache_folder(), jobs, progress)
        if figures:
            made = write_figures(study, figures, out, scale)
        else:
            made = write_paper(study, out, scale)
    for chapter in made:
        print(f"{chapter.title}: {len(chapter.records)} records")
    print(
        f"wrote {out / PAGE}; {study.computed_count} simulations made, {study.cached_count} from"
        " the cache"
    )
