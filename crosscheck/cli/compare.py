"""`crosscheck compare`: a recorded motion and the rigid levels of an arm or a robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from crosscheck.cli.output import FileRequest, print_and_write
from crosscheck.file_types import EXCITATION, IDENTIFIED, IDENTIFIED_PAGE, MEASURED, MEASURED_PAGE
from crosscheck.identification import output
from crosscheck.identification.compare import compare_robot
from crosscheck.identification.description import (
    find_knowledge,
    load_description,
    read_recordings,
    transmission_matrix,
)
from crosscheck.identification.excitation import format_excitation
from crosscheck.identification.messages import EXCITATION_FILE
from crosscheck.identification.recording import convert_record
from crosscheck.identification.refinement import Knowledge
from crosscheck.models.errors import InputError
from crosscheck.models.files import is_robot
from crosscheck.models.loading import load_selection
from crosscheck.models.robot.file import load_robot
from crosscheck.output import require_files
from crosscheck.recordings.compare import RecordComparison, compare
from crosscheck.recordings.output import comparison_json, comparison_page, describe_comparison
from crosscheck.recordings.record import read_record
from crosscheck.runner.progress import progress_bar

PAGE = "compare.html"
DESCRIPTION = ".toml"  # ends the name of a record's description


def compare_command(
    record: Path,
    arm: str,
    scenarios: list[str],
    settings: list[str],
    stated: list[str],
    topic: str,
    joints: list[str],
    json_file: Path | None,
    out: Path | None,
) -> int:
    """Compare a recorded motion with an arm's or a robot's levels; returns the exit code.

    Of an arm it is 0 if the engines agree and the likeliest level leaves noise alone, else 1; of a
    robot it is 0 if they agree, the torques distinguish links alone from rotors, and everything
    else that the record's description asks for can be determined. Raises InputError.
    """
    if is_robot(arm):
        for option, given in (
            ("--scenario", scenarios),
            ("--set", settings),
            ("--tolerance", stated),
        ):
            if given:
                raise InputError(option, given[0], None, f"is for arms, and {arm} is a robot")
        return _compare_robot(record, arm, topic, joints, json_file, out)
    if record.suffix == DESCRIPTION:
        reason = f"describes a record of a robot, and {arm} is an arm"
        raise InputError(str(record), "", None, reason)
    chosen = load_selection(arm, scenarios, settings)
    tolerances = dict(_tolerance(text) for text in stated)
    page = None if out is None else out / PAGE
    require_files((json_file, MEASURED), (page, MEASURED_PAGE))
    recording = read_record(record, len(chosen.arm.joints), topic, joints)
    scenario = chosen.scenarios[0] if chosen.scenarios else None
    with progress_bar() as progress:
        comparison = compare(recording, chosen.arm, scenario, tolerances, progress)
    requests = (
        (json_file, lambda: comparison_json(comparison)),
        (page, lambda: comparison_page(comparison)),
    )
    print_and_write(describe_comparison(comparison), *requests)
    return 0 if isinstance(comparison, RecordComparison) and comparison.explained else 1


def _compare_robot(
    record: Path,
    name: str,
    topic: str,
    joints: list[str],
    json_file: Path | None,
    out: Path | None,
) -> int:
    """Compare recordings with a robot; returns the exit code. Raises InputError."""
    robot = load_robot(name)
    page = None if out is None else out / PAGE
    table = None if out is None else out / EXCITATION_FILE
    require_files((json_file, IDENTIFIED), (page, IDENTIFIED_PAGE), (table, EXCITATION))
    count = len(robot.coordinates)
    if record.suffix == DESCRIPTION:
        description = load_description(record)
        recordings = read_recordings(description, robot, record)
        transmission = transmission_matrix(description, count)
        knowledge = find_knowledge(description, robot, record)
    else:
        recordings = (convert_record(read_record(record, count, topic, joints)),)
        transmission, knowledge = np.eye(count), Knowledge()
    with progress_bar() as progress:
        comparison = compare_robot(robot, recordings, transmission, progress, knowledge)
    requests: list[FileRequest] = [
        (json_file, lambda: output.comparison_json(comparison)),
        (page, lambda: output.comparison_page(comparison)),
    ]
    if (excitation := comparison.excitation) is not None:
        requests.append((table, lambda: format_excitation(excitation)))
    print_and_write(output.describe_comparison(comparison), *requests)
    return 0 if comparison.engines_agree and comparison.is_decided else 1


def _tolerance(text: str) -> tuple[str, float]:
    """Path and relative standard uncertainty of a text PATH=SHARE. Raises InputError."""
    path, _, number = text.partition("=")
    try:
        share = float(number)
    except ValueError:
        share = -1.0
    if not 0 < share < 1:
        allowed = "must be PATH=SHARE with a share between 0 and 1, such as 0.01 for 1 %"
        raise InputError("--tolerance", path, number or None, allowed)
    return path, share
