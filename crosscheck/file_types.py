"""Recognizes files that the program wrote by their content, so that it replaces no others."""

from __future__ import annotations

import os
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import NamedTuple

JSON = b'{\n "schema_version": '
PROVENANCE = b'\n "provenance": {'
HTML = b"<!doctype html>"
HDF5 = b"\x89HDF\r\n\x1a\n"
PNG = b"\x89PNG\r\n\x1a\n"


class FileType(NamedTuple):
    """A kind of file: its name in messages, how its content begins, what stands anywhere in it."""

    description: str
    begins: bytes
    holds: tuple[bytes, ...]


AGREEMENT = FileType("a cross-check's JSON file", JSON, (b'\n "findings": [', PROVENANCE))
TRIAL = FileType(
    "a trial's JSON file", JSON, (b'\n "equations": ', b'\n "headline": ', b'\n "agreement": {')
)
RECORD = FileType("a record", b'{\n "checks": ', ())  # also a damaged one, which is so renewed
ERRATA = FileType("an errata JSON file", JSON, (b'\n "errata": [', PROVENANCE))
CLAIMS = FileType("a file of the paper's claims", JSON, (b'\n "chapters": {', PROVENANCE))
VERDICTS = FileType("a file of a paper's verdicts", JSON, (b'\n "claims": [', b'\n "title": '))
XML_OF_TESTS = b'<?xml version="1.0" encoding="UTF-8"?>\n<testsuites tests="'
JUNIT = FileType("a cross-check's JUnit file", XML_OF_TESTS, (b'<property name="arm_sha256" ',))
PAGE = FileType("a cross-check's page", HTML, (b"<title>Cross-check of ",))
TRIAL_PAGE = FileType("a trial's page", HTML, (b"<title>Trial of ",))
PAPER_PAGE = FileType("the paper's page", HTML, (b"<title>The paper, reproduced and judged<",))
VIEW = FileType("a run's page", HTML, (b"<title>Run of ", b'id="scene-data"'))
TRAJECTORY = FileType("a trajectory", HDF5, (b"theta_dot", b"switches", b"step_s", b"joint number"))
C_FILE = FileType("an exported C file", b"/* Equations of motion of ", (b" */\n#include <math.h>",))
URDF_FILE = FileType("an exported URDF", b'<?xml version="1.0"?>\n<!-- Written by crosscheck', ())
ROBOT_FILE = FileType("an exported robot's file", b"# Written by crosscheck export. ", ())
FMU_FILE = FileType("an exported FMU", b"PK\x03\x04", (b'generationTool="crosscheck export"',))
MEASURED = FileType(
    "a comparison with a record", JSON, (b'\n "records": [', b'\n "sides": [', b'\n "ranks": {')
)
MEASURED_PAGE = FileType("a comparison's page", HTML, (b"<title>Recording compared with ",))
EXCITATION = FileType("a suggested motion", b"t_s,theta_1_", ())
COST = FileType("a cost of shortcuts", JSON, (b'\n "engines_agree": ', b'\n "negligible_share": '))
COST_PAGE = FileType("a page of shortcuts' cost", HTML, (b"<title>Cost of shortcuts: ",))
PICTURE = FileType("a study's drawing", PNG, (b"Software\0geararm-crosscheck",))


FILE_TYPES = tuple(each for each in list(globals().values()) if isinstance(each, FileType))


def identify_file_type(content: bytes) -> FileType | None:
    """The kind of a file's content; None where it is of none."""
    return next((kind for kind in FILE_TYPES if _is_of_type(content, kind)), None)


def is_file_of_type(path: Path, kind: FileType) -> bool:
    """Whether a file is of a kind, or empty. Raises OSError."""
    with path.open("rb") as file:
        if not os.fstat(file.fileno()).st_size:
            return True
        with mmap(file.fileno(), 0, access=ACCESS_READ) as content:
            return _is_of_type(content, kind)


def _is_of_type(content: bytes | mmap, kind: FileType) -> bool:
    is_begun = content[: len(kind.begins)] == kind.begins
    return is_begun and all(content.find(mark) >= 0 for mark in kind.holds)
