"""`crosscheck paper`: all chapters on one page, and the numbers behind them."""

from __future__ import annotations

import importlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from crosscheck import file_types
from crosscheck.audit.claims.measured import MEASURED
from crosscheck.audit.claims.statements import SENTENCES
from crosscheck.audit.claims.study_plan import AuditContext
from crosscheck.audit.errata.errata_texts import list_sections
from crosscheck.audit.errata.sheet import build_sheet
from crosscheck.audit.experiments.paper_conditions import LABELLED
from crosscheck.audit.experiments.samples import FULL, Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.judging.sentences import load_sentences
from crosscheck.audit.page.chapter import CITATION, EXTENT_READ, AuditChapter
from crosscheck.file_types import PAPER_PAGE
from crosscheck.models.directories import cache_folder
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.output import require_files, write_files, write_text
from crosscheck.provenance import record_provenance
from crosscheck.report import rendering
from crosscheck.report.formatting import format_count
from crosscheck.report.plots.figures import fix_links
from crosscheck.report.records import format_json
from crosscheck.runner.progress import show_progress

SCHEMA_VERSION = 5
PAGE, CLAIMS, ERRATA = "paper.html", "claims.json", "errata.html"
FILES = {PAGE: file_types.PAPER_PAGE, CLAIMS: file_types.CLAIMS, ERRATA: file_types.PAPER_PAGE}
# Lengths in a drawing, in points: two decimals are a thousandth of what a reader sees.
_LENGTH, _FINER = re.compile(r' (?:d|x|y)="[^"]*"'), re.compile(r"(?<=\.\d\d)\d+")
# In reading order; each module has a function build_chapter(context) -> AuditChapter.
CHAPTERS = ("findings.chapter", "errata.sheet", "figures.chapter", "claims.chapter")


def write_paper(study: Study, out: Path, scale: Scale = FULL) -> list[AuditChapter]:
    """Write paper.html, claims.json and errata.html. Raises InputError and Diverged."""
    context = AuditContext(study, scale)
    modules = (importlib.import_module(f"crosscheck.audit.{name}") for name in CHAPTERS)
    made = [module.build_chapter(context) for module in modules]
    sheet = build_sheet(list_sections(LABELLED, context.errata), context.effect_s)
    contents = {
        out / PAGE: render_page(made, record_study(study)),
        out / CLAIMS: format_records(made, study),
        out / ERRATA: render_page([sheet], record_study(study)),
    }
    write_files(contents)
    return made


def write_figures(
    study: Study, numbers: Sequence[int], out: Path, scale: Scale = FULL
) -> list[AuditChapter]:
    """Write paper.html with these figures alone."""
    figures = importlib.import_module("crosscheck.audit.figures.chapter")
    drawn = figures.draw_figures(AuditContext(study, scale), sorted(set(numbers)))
    html = "\n".join(figure.to_html() for figure in drawn)
    made = [AuditChapter(figures.ID, "Figures", html)]
    write_text(out / PAGE, render_page(made, record_study(study)))
    return made


def render_page(made: Sequence[AuditChapter], provenance: Mapping[str, object]) -> str:
    """The self-contained page of chapters as html, with where they come from."""
    page = rendering.render_page(
        "paper", citation=CITATION, extent_read=EXTENT_READ, chapters=made, provenance=provenance
    )
    return _LENGTH.sub(lambda lengths: _FINER.sub("", lengths[0]), fix_links(page))


def format_records(made: Sequence[AuditChapter], study: Study) -> str:
    """All chapters' records, and what they name, as JSON, the same for the same inputs.

    numbers: what the experiments measure, by the names in the ids of quantities. Only the
    provenance differs.
    """
    document = {
        "schema_version": SCHEMA_VERSION,
        "paper": {"citation": CITATION, "read": EXTENT_READ},
        "chapters": {chapter.id: chapter.records for chapter in made},
        "numbers": {name: number._asdict() for name, number in MEASURED.items()},
        "sentences": load_sentences(SENTENCES),
        "provenance": record_study(study),
    }
    return format_json(document)


def record_study(study: Study) -> dict[str, object]:
    """The provenance of a study's page."""
    cache = {"simulations_made": study.computed_count, "simulations_from_cache": study.cached_count}
    record = record_provenance(load_arm("paper-labelled"), 0, False)
    return record.model_dump(mode="json") | cache


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
    with show_progress("reproducing the paper") as progress:
        study = Study(cache_folder(), jobs, progress)
        if figures:
            made = write_figures(study, figures, out, scale)
        else:
            made = write_paper(study, out, scale)
    for chapter in made:
        if chapter.records:
            print(f"{chapter.title}: {format_count(len(chapter.records), 'record')}")
    count = format_count(study.computed_count, "simulation")
    print(f"wrote {out / PAGE}; {count} made, {study.cached_count} from the cache")
