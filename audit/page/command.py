"""What the command `paper` does, once the command line is parsed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from crosscheck.audit.experiments.scale import FULL
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.page.report import FILES, PAGE, write_figures, write_paper
from crosscheck.file_types import PAPER_PAGE
from crosscheck.models.directories import cache_folder
from crosscheck.models.errors import InputError
from crosscheck.output import require_files
from crosscheck.runner.progress import progress_bar

FIGURES = tuple(range(4, 21))


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
