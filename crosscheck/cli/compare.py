"""`crosscheck compare`: recorded motions and the rigid levels of an arm or a robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from crosscheck.cli.output import FileRequest, print_and_write
from crosscheck.file_types import EXCITATION, MEASURED, MEASURED_PAGE
from crosscheck.identification.compare import compare
from crosscheck.identification.description import (
    find_knowledge,
    load_description,
    read_recordings,
    transmission_matrix,
)
from crosscheck.identification.excitation import format_excitation
from crosscheck.identification.mechanism import ComparedMechanism
from crosscheck.identification.messages import EXCITATION_FILE
from crosscheck.identification.output import comparison_json, comparison_page, describe_comparison
from crosscheck.identification.refinement import Knowledge
from crosscheck.mechanisms import supply
from crosscheck.models.errors import InputError, make_printable
from crosscheck.models.mechanism import select_mechanism
from crosscheck.output import require_files
from crosscheck.recordings.record import Record, read_record
from crosscheck.recordings.smoothing import add_drive_torques, check_rates
from crosscheck.runner.progress import show_progress

PAGE = "compare.html"
DESCRIPTION = ".toml"  # suffix of a description of records


def compare_command(
    record: Path,
    name: str,
    scenario: str | None,
    settings: list[str],
    tolerance_texts: list[str],
    topic: str,
    joints: list[str],
    json_file: Path | None,
    out: Path | None,
) -> int:
    """Compare recorded motions with an arm's or a robot's levels; returns the exit code.

    It is 0 if the engines agree and a level with the files' numbers explains the torques, friction
    aside; where the record's description asks for more, if that can be determined. Raises
    InputError.
    """
    selection = select_mechanism(name, () if scenario is None else (scenario,), settings)
    adopt = supply("compare", selection.mechanism.section)
    mechanism: ComparedMechanism = adopt(selection.mechanism)
    tolerances = dict(_tolerance(text) for text in tolerance_texts)
    mechanism.require_parameters(tolerances)
    page = None if out is None else out / PAGE
    table = None if out is None else out / EXCITATION_FILE
    require_files((json_file, MEASURED), (page, MEASURED_PAGE), (table, EXCITATION))
    count = len(mechanism.robot.coordinates)
    records: tuple[Record, ...]
    if record.suffix == DESCRIPTION:
        description = load_description(record)
        records = read_recordings(description, mechanism.robot, record)
        transmission = transmission_matrix(description, count)
        knowledge = find_knowledge(description, mechanism.robot, record)
    else:
        alone = read_record(record, count, topic, joints, mechanism.robot.slides)
        check_rates(alone)
        records, transmission, knowledge = (alone,), np.eye(count), Knowledge()
    for chosen in selection.scenarios:
        records = tuple(add_drive_torques(each, chosen) for each in records)
    for each in records:
        if each.motor_torque is None and each.joint_torque is None:
            columns = "columns must be torque_1_N_m, ..., or --scenario says whose drive"
            raise InputError(each.where, "", None, f"has no torques; {columns}")
    with show_progress(f"comparing {make_printable(str(record))}") as progress:
        comparison = compare(mechanism, records, transmission, progress, knowledge, tolerances)
    requests: list[FileRequest] = [(json_file, lambda: comparison_json(comparison))]
    requests.append((page, lambda: comparison_page(comparison)))
    if (excitation := comparison.excitation) is not None:
        requests.append((table, lambda: format_excitation(excitation, mechanism.robot.slides)))
    print_and_write(describe_comparison(comparison), *requests)
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
