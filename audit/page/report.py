"""`crosscheck paper`: all chapters on one page, and the numbers behind them."""

from __future__ import annotations

import importlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from crosscheck import kinds
from crosscheck.audit.claims.sentences.table import load_sentences
from crosscheck.audit.errata.sheet import ErrataSheet, markdown
from crosscheck.audit.experiments.scale import FULL, Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.figures.store import stored_runs, trajectories
from crosscheck.audit.measures.undefined import UNDEFINED
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.models.errors import Diverged
from crosscheck.models.loading import load_arm
from crosscheck.models.trajectory import netcdf
from crosscheck.output import write_files, write_text
from crosscheck.provenance import provenance
from crosscheck.report import rendering
from crosscheck.report.fragments import paragraph
from crosscheck.report.plots.figures import sound_links

SCHEMA_VERSION = 3
PAGE, CLAIMS, ERRATA = "paper.html", "claims.json", "errata.md"
# In reading order; each module has a function chapter(material) -> AuditChapter.
CHAPTERS = (
    "front.chapter",
    "front.words",
    "phase.chapter",
    "hypotheses.ladder",
    "hypotheses.accumulation",
    "hypotheses.planet_spin",
    "hypotheses.floating_base",
    "hypotheses.controller",
    "planets.chapter",
    "hypotheses.damping_fit",
    "figures.chapter",
    "claims.chapter",
    "errata.sheet",
)


def paper_files(out: Path, scale: Scale = FULL) -> dict[Path, kinds.Kind]:
    """The files that ``write_paper`` writes, each with its kind."""
    own = {PAGE: kinds.PAPER_PAGE, CLAIMS: kinds.CLAIMS, ERRATA: kinds.SHEET}
    runs = {f"{name}.nc": kinds.TRAJECTORY for name in stored_runs(scale)}
    return {out / name: kind for name, kind in {**own, **runs}.items()}


def _chapter(material: Material, name: str) -> AuditChapter:
    """A chapter of CHAPTERS; one that says so if a run that it cannot do without diverges."""
    module = importlib.import_module(f"crosscheck.audit.{name}")
    try:
        made: AuditChapter = module.chapter(material)
    except Diverged as error:
        said = f"Undefined: a run that this chapter rests on has no result ({error})."
        record = {"id": module.ID, "verdict": UNDEFINED}
        return AuditChapter(module.ID, module.TITLE, paragraph(said), [record], said)
    return made


def write_paper(study: Study, out: Path, scale: Scale = FULL) -> list[AuditChapter]:
    """Write paper.html, claims.json, errata.md and the figures' trajectories. Raises InputError."""
    material = Material(study, scale)
    made = [_chapter(material, name) for name in CHAPTERS]
    errata = [one for chapter in made if isinstance(chapter, ErrataSheet) for one in chapter.found]
    contents: dict[Path, str | bytes] = {
        out / f"{name}.nc": netcdf(run) for name, run in trajectories(study, scale).items()
    }
    contents[out / PAGE] = page(made, study)
    contents[out / CLAIMS] = records_json(made, study)
    contents[out / ERRATA] = markdown(errata)
    write_files(contents)
    return made


def write_figures(
    study: Study, numbers: Sequence[int], out: Path, scale: Scale = FULL
) -> list[AuditChapter]:
    """Write paper.html with these figures alone."""
    figures = importlib.import_module("crosscheck.audit.figures.chapter")
    html = figures.alone(Material(study, scale), sorted(set(numbers)))
    made = [AuditChapter(figures.ID, "Figures", html)]
    write_text(out / PAGE, page(made, study))
    return made


def page(made: Sequence[AuditChapter], study: Study) -> str:
    """The self-contained page of a study as html."""
    return page_of(made, _provenance(study))


def page_of(made: Sequence[AuditChapter], provenance: Mapping[str, object]) -> str:
    """The self-contained page of chapters as html, with where they come from."""
    return sound_links(rendering.page("paper", chapters=made, provenance=provenance))


def records_json(made: Sequence[AuditChapter], study: Study) -> str:
    """All chapters' records and the paper's sentences as JSON, the same for the same inputs.

    Only the provenance differs.
    """
    document = {
        "schema_version": SCHEMA_VERSION,
        "chapters": {chapter.id: chapter.records for chapter in made},
        "sentences": [asdict(sentence) for sentence in load_sentences()],
        "provenance": _provenance(study),
    }
    return json.dumps(document, indent=1, allow_nan=False, default=_plain) + "\n"


def _plain(value: object) -> object:
    """A NumPy scalar as Python's own. Raises TypeError for anything else."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"not JSON: {value!r}")


def _provenance(study: Study) -> dict[str, object]:
    cache = {"simulations_made": study.made, "simulations_from_cache": study.found}
    own = provenance(load_arm("paper-labelled"), 0, False)
    return own.model_dump(mode="json") | cache
