"""The examples are right: trials of them agree; tables of answers hold more of them so.

tests/trial/other_tools/test_tables.py tries all but those by symbols, on the paper's arm.
"""

from pathlib import Path

import pytest

from crosscheck.models.loading import load_arm
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import Trial
from crosscheck.trial.trial import run_trial
from tests.trial.other_tools.test_tables import GEARED, RIGID

EXAMPLES = Path(__file__).parents[2] / "examples"
SYMBOLIC = ("sympy_mechanics", "sympy_map", "casadi_two_link")
# Those for arms of any joints, and those for any two.
ON = {
    **dict.fromkeys(("mass_matrix_alone", "absolute_angles", "inverse_dynamics_alone"), 3),
    **dict.fromkeys(("coriolis_matrix", "acceleration_alone", "geared_lumped", *SYMBOLIC), 2),
}
ARMS = {2: "probe", 3: "three-unlike"}


def tried(example: str, arm: str) -> Trial:
    own = load_arm(arm)
    equations = load_equations(f"{EXAMPLES / example}.py:model", own, None)
    return run_trial(TrialRequest(example, equations, own, quick=True))


def test_every_example_is_here():
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {*RIGID, *GEARED, *SYMBOLIC}


@pytest.mark.parametrize("example", ON)
def test_is_right(example):
    trial = tried(example, ARMS[ON[example]])
    assert (trial.exit_code, trial.diagnosis.entries, trial.diagnosis.hidden) == (0, (), ())


def test_a_correct_example_on_another_arm_is_found_wrong():
    """The comparison above can fail: its numbers are of the paper's arm."""
    assert tried("plain_functions", "probe").exit_code == 1
