"""What the paper's commands do, once the command line is parsed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from crosscheck.audit.errata.finder import SCHEMA_VERSION, errata_records
from crosscheck.audit.errata.sheet import HEADINGS, WHOLE, ArmErratum, counted
from crosscheck.audit.errata.words import in_words
from crosscheck.audit.experiments.scale import FULL
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.page.report import PAGE, paper_files, write_figures, write_paper
from crosscheck.kinds import ERRATA, PAPER_PAGE, Kind
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.models.places import cache_folder
from crosscheck.output import require_file, require_files, write_text
from crosscheck.provenance import provenance
from crosscheck.runner.progress import progress_bar

FIGURES = tuple(range(4, 21))


def errata_command(arm_name: str, json_file: Path | None) -> None:
    """Print the errata of an arm as a table, and write them as JSON if asked. Raises InputError."""
    arm = load_arm(arm_name)
    if json_file is not None:
        require_file(json_file, ERRATA, "--json")
    with Console(stderr=True).status("errata") as status:
        found = in_words(errata_records(arm, lambda one: status.update(f"effect of {one}")))
    table = Table("where", "printed", "derived", "size", "effect: angle [rad], impulse [N s]")
    for erratum, effects in ((one.erratum, one.effects) for one in found):
        size = "" if erratum.size is None else f"{erratum.size:.3g} {erratum.unit}"
        derived = f"{erratum.derived} {erratum.remark}".strip()
        told = (f"{n}: {e.theta_rad:.2g}, {e.impulse_N_s:.2g}" for n, e in effects.items())
        table.add_row(erratum.where, erratum.printed, derived, size, "\n".join(told))
    Console().print(table)
    kinds = (f"{HEADINGS[kind]}: {count}" for kind, count in counted(found).by_class.items())
    print(f"{'; '.join(kinds)}; arm {arm.name}")
    if json_file is not None:
        document = {
            "schema_version": SCHEMA_VERSION,
            "errata": WHOLE.json(ArmErratum(arm.name, one) for one in found),
            "provenance": provenance(arm, 0, False).model_dump(mode="json"),
        }
        write_text(json_file, json.dumps(document, indent=1, allow_nan=False) + "\n")


def paper_command(figures: list[int], out: Path, jobs: int, first_seed: int = 1) -> None:
    """Write the paper's page, or some of its figures alone. Raises InputError."""
    if first_seed < 0:
        raise InputError("--first-seed", "", first_seed, "must be 0 or more")
    unknown = [number for number in figures if number not in FIGURES]
    if unknown:
        raise InputError("--figure", "", unknown[0], f"must be {FIGURES[0]} to {FIGURES[-1]}")
    scale = replace(FULL, first_seed=first_seed)
    files: dict[Path, Kind] = {out / PAGE: PAPER_PAGE} if figures else paper_files(out, scale)
    require_files(*files.items())
    with progress_bar() as told:
        study = Study(cache_folder(), jobs, told)
        if figures:
            made = write_figures(study, figures, out, scale)
        else:
            made = write_paper(study, out, scale)
    for chapter in made:
        print(f"{chapter.title}: {len(chapter.records)} records")
    print(f"wrote {out / PAGE}; {study.made} simulations made, {study.found} from the cache")
