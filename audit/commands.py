"""`crosscheck paper` and `crosscheck errata`: heavy imports wait until one is called."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from crosscheck.cli.app import ArmName, Jobs


def errata(
    arm: ArmName = "paper-labelled",
    json_file: Annotated[Path | None, typer.Option("--json", help="JSON file to write.")] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the typeset sheet, errata.html and errata.md."),
    ] = None,
    whole: Annotated[
        bool, typer.Option("--all", help="Print statements, contradictions, notation and gaps too.")
    ] = False,
) -> None:
    """Find the errors in the paper's equations, symbolically, and simulate their effects."""
    from crosscheck.audit.errata.command import run_errata_command

    run_errata_command(arm, json_file, out, whole)


def paper(
    figure: Annotated[
        list[int] | None,
        typer.Option(help="A figure of the paper, 4 to 20 (default: all chapters)."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("paper-report"),
    first_seed: Annotated[
        int, typer.Option(help="Seed of the first start of every sample; others follow.")
    ] = 1,
    jobs: Jobs = None,
) -> None:
    """Reproduce the paper's figures and judge its claims; write paper.html and claims.json."""
    from crosscheck.audit.page.command import run_paper_command

    run_paper_command(figure or [], out, jobs or os.cpu_count() or 1, first_seed)
