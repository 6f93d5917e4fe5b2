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
        typer.Option(help="Folder for the typeset sheet, errata.html."),
    ] = None,
    whole: Annotated[
        bool, typer.Option("--all", help="Print statements, contradictions, notation and gaps too.")
    ] = False,
) -> None:
    """Find the errors in the paper's equations, symbolically, and simulate their effects."""
    from crosscheck.audit.errata.command import run_errata_command

    run_errata_command(arm, json_file, out, whole)


def paper(
    folder: Annotated[
        Path | None,
        typer.Argument(metavar="FOLDER", help="Another paper's folder (default: the case study)."),
    ] = None,
    figure: Annotated[
        list[int] | None,
        typer.Option(help="A figure of the paper, 4 to 20 (default: all chapters)."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("paper-report"),
    first_seed: Annotated[
        int, typer.Option(help="Seed of the first start of every sample; others follow.")
    ] = 1,
    jobs: Jobs = None,
    run_code: Annotated[
        bool, typer.Option("--run-code", help="Allow the folder's equations and functions to run.")
    ] = False,
) -> None:
    """Reproduce the paper's figures and judge its claims; write paper.html and claims.json.

    Of another paper's folder, judge its claims and try its equations; write verdicts.json.
    """
    if folder is not None:
        from crosscheck.audit.judging.paper_folder import run_folder_command

        run_folder_command(folder, figure or [], out, jobs or os.cpu_count() or 1, run_code)
        return
    from crosscheck.audit.page.report import run_paper_command

    run_paper_command(figure or [], out, jobs or os.cpu_count() or 1, first_seed)
