"""The errors that newcomers make, answered by Octave: the same entries and terms as from Python."""

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm
from crosscheck.trial.arms import subject as trial_module
from crosscheck.trial.input.equations import Coordinates
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.result import Trial
from crosscheck.trial.tables.folder import encode_mat_file, render_request_files
from crosscheck.trial.tables.state_requests import TableTrial, collect_state_request
from crosscheck.trial.trial import run_trial
from tests.trial.mistakes.equations import written
from tests.trial.other_tools.tables import judge_table

HERE, EXAMPLES = Path(__file__).parent, Path(__file__).parents[3] / "examples"
OCTAVE = shutil.which("octave-cli")
ABSOLUTE, LUMPED = Coordinates(links="absolute"), Coordinates(gearing="lumped")
TWO_LINK = {
    "mass_matrix": "@(q) two_link(arm, q, q, q)",
    "bias": "@(q, v) nthargout(2, @two_link, arm, q, v, q)",
    "force": "@(t, q, v, torque) nthargout(3, @two_link, arm, q, v, torque)",
}
GEARED = (EXAMPLES / "geared_lumped.py").read_text(encoding="utf-8")


class Planted(NamedTuple):
    """An error in Octave's text and in Python's; functions: what answers, by part.

    python: pieces of the text ``absolute`` of tests.trial.mistakes, or of an example's file.
    """

    file: str
    octave: tuple[str, str]
    python: tuple[str, str]
    coordinates: Coordinates = ABSOLUTE
    functions: dict[str, str] = TWO_LINK


ERRORS = {
    "none": Planted("two_link", ("far = I2", "far = I2"), ("I2", "I2")),
    "payload at the centre of mass": Planted(
        "two_link", ("payload * L2) * L1", "payload * d2) * L1"), ("mp*L1*L2", "mp*L1*d2")
    ),
    "friction without reaction": Planted(
        "two_link", ("c1 * v(1) + rubbed", "c1 * v(1)"), (" + k2*(v[1] - v[0])", "")
    ),
    "planets' orbit": Planted(
        "geared_inertia",
        ("orbit = orbit + count * joint.planet_mass_kg * r_c ^ 2;", ""),
        ("orbit += self.N * self.joint.planet_mass_kg * self.r_c**2", "pass"),
        LUMPED,
        {"mass_matrix": "@(q) geared_inertia(arm, q)"},
    ),
    "teeth in a rate": Planted(
        "geared_force",
        ("joint.ring_teeth * x", "joint.sun_teeth * x"),
        ("self.joint.ring_teeth * x", "self.joint.sun_teeth * x"),
        LUMPED,
        {"force": "@(t, q, v, torque) geared_force(arm, q, v, torque)"},
    ),
}
FORCE_ALONE = ERRORS["friction without reaction"]._replace(functions={"force": TWO_LINK["force"]})
NAMES = {
    "mass_matrix": ("mass_matrix", "M"),
    "bias": ("bias_force", "bias"),
    "force": ("all_forces", "force"),
}


@pytest.mark.system
@pytest.mark.skipif(OCTAVE is None, reason="no octave-cli here")
@pytest.mark.parametrize("error", ERRORS)
def test_octave_gets_the_answers_that_python_gets(error, tmp_path, monkeypatch):
    monkeypatch.setattr(trial_module, "QUICK_STATES", 1)
    planted = ERRORS[error]
    table = TableTrial(rubbing(), planted.coordinates, quick=True)
    file = answered_by_octave(planted, table, tmp_path)
    found = said(judge_table(table, file))
    assert found == said(by_python(planted, table, tmp_path))
    assert bool(found) == (error != "none")


@pytest.mark.usefixtures("usual_states")  # as when they were recorded
def test_recorded_answers_of_octave_are_judged_as_those_of_python(tmp_path, monkeypatch):
    """What the test above made of ``FORCE_ALONE``, for machines without Octave."""
    monkeypatch.setattr(trial_module, "QUICK_STATES", 1)
    table = TableTrial(rubbing(), ABSOLUTE, quick=True)
    found = said(judge_table(table, HERE / "octave" / "answers.mat"))
    assert found == said(by_python(FORCE_ALONE, table, tmp_path))
    assert [entry for entry, _ in found] == ["force[phi_1]"]


def rubbing() -> Arm:
    """No two numbers of it are equal, and there is friction."""
    arm = load_arm("probe")
    joints = (
        joint.model_copy(update={"friction_N_m_s_per_rad": 3.0 + 4.0 * number})
        for number, joint in enumerate(arm.joints)
    )
    return arm.model_copy(update={"joints": tuple(joints)})


def by_python(planted: Planted, table: TableTrial, folder: Path) -> Trial:
    """The trial of the same equations as functions, of this arm alone."""
    arm = table.mechanism
    if planted.coordinates == ABSOLUTE:
        own = replace(written("absolute", (planted.python,), arm), coordinates=ABSOLUTE, level="")
    else:
        mine = folder / "mine.py"
        mine.write_text(replaced(GEARED, planted.python), encoding="utf-8")
        own = load_equations(f"{mine}:model", arm, None)
    parts = {part: getattr(own, part) if part in planted.functions else None for part in NAMES}
    return run_trial(
        table.make_request("yours", replace(own, **parts, rebuild=None, any_arm=False))
    )


def said(trial: Trial) -> list[tuple[str, str]]:
    """Every wrong entry, and why."""
    return [(wrong.name, wrong.cause) for wrong in trial.diagnosis.entries]


def answered_by_octave(planted: Planted, table: TableTrial, folder: Path) -> Path:
    """What the template writes, once the functions stand in it."""
    asked = collect_state_request(table)
    for name, content in render_request_files(table, [asked], "", folder).items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    (folder / "arm.mat").write_bytes(
        encode_mat_file({"arm": without_none(table.mechanism.model_dump())})
    )
    text = (HERE / "octave" / f"{planted.file}.m").read_text(encoding="utf-8")
    (folder / f"{planted.file}.m").write_text(replaced(text, planted.octave), encoding="utf-8")
    template = folder / "answers.m"
    lines = template.read_text(encoding="utf-8").splitlines()
    found = ["load('arm.mat');"]
    for line in lines:
        part = next((part for part, (name, _) in NAMES.items() if f"{name} =" in line), None)
        if part is not None:
            line = (
                f"{NAMES[part][0]} = {planted.functions[part]};"
                if part in planted.functions
                else ""
            )
        calls = [
            part for part, (name, _) in NAMES.items() if f"{name}(q" in line or f"{name}(t" in line
        ]
        found += [] if any(part not in planted.functions for part in calls) else [line]
    variables = ["row", "q", "v", "torque", *(NAMES[part][1] for part in planted.functions)]
    found[-1] = f"save('-v6', 'answers.mat', {', '.join(map(repr, variables))});"
    template.write_text("\n".join(found) + "\n", encoding="utf-8")
    subprocess.run([str(OCTAVE), "--norc", template.name], cwd=folder, check=True, timeout=300)
    return folder / "answers.mat"


def replaced(text: str, change: tuple[str, str]) -> str:
    assert change[0] in text
    return text.replace(*change)


def without_none(value: Any) -> Any:
    """Records and lists as MAT files have them: structs and cells."""
    if isinstance(value, dict):
        return {key: without_none(entry) for key, entry in value.items() if entry is not None}
    if isinstance(value, list | tuple):
        cells = np.empty(len(value), dtype=object)
        cells[:] = [without_none(entry) for entry in value]
        return cells
    return float(value) if isinstance(value, int | float) else value
