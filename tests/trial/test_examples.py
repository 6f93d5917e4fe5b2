"""The examples are right: trials of them agree.

tests/trial/other_tools/test_tables.py tries all but those by symbols, on the paper's arm and on
others of its joints.
"""

from pathlib import Path

import pytest

from crosscheck.models.loading import load_arm
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.trial import run_trial
from tests.trial.other_tools.test_tables import GEARED, RIGID

EXAMPLES = Path(__file__).parents[2] / "examples"
SYMBOLIC = ("sympy_mechanics", "sympy_map", "casadi_two_link")
# Those for arms of any joints on three, those by symbols on an arm that is not the paper's.
ON = {
    "mass_matrix_alone": "three-unlike",
    "absolute_angles": "three-unlike",
    "inverse_dynamics_alone": "three-unlike",
    **dict.fromkeys(SYMBOLIC, "probe"),
}


def test_every_example_is_here():
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {*RIGID, *GEARED, *SYMBOLIC}


@pytest.mark.parametrize("example", ON)
def test_is_right(example):
    arm = load_arm(ON[example])
    equations = load_equations(f"{EXAMPLES / example}.py:model", arm, None)
    trial = run_trial(TrialRequest(example, equations, arm, quick=True))
    assert (trial.exit_code, trial.diagnosis.entries, trial.diagnosis.hidden) == (0, (), ())
