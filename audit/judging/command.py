"""What the command `paper` does with another paper's folder."""

from __future__ import annotations

from pathlib import Path

from crosscheck.audit.judging.paper_folder import audit_paper, read_folder
from crosscheck.file_types import VERDICTS
from crosscheck.models.errors import InputError
from crosscheck.output import require_files, write_text

FILE = "verdicts.json"


def run_folder_command(
    folder: Path, figures: list[int], out: Path, jobs: int, run_code: bool
) -> None:
    """Judge the claims of a paper's folder, and try its equations. Raises InputError."""
    if figures:
        raise InputError("--figure", "", figures[0], "is of the case study; a folder has none")
    given = read_folder(folder, run_code)
    require_files((out / FILE, VERDICTS))
    audit = audit_paper(given, jobs)
    write_text(out / FILE, audit.format_json())
    print("\n".join([*audit.lines, f"wrote {out / FILE}"]))
