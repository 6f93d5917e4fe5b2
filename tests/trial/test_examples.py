"""The examples are right: held against the project's own models, part by part."""

from pathlib import Path

import pytest

from crosscheck.models.loading import load_arm
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.input.supplied import SuppliedEquations, bind_equations
from tests.loops import require_items
from tests.trial.judge import worst

EXAMPLES = Path(__file__).parents[2] / "examples"
ROUNDING = 1e-12
# Where x are gear angles, 0.1 mm between teeth is the difference of arcs of a metre: 1e-16 / 1e-4.
ROUNDING_OF_ARCS = 1e-11
WHOLE = {"mass_matrix", "bias", "force", "acceleration", "inverse_dynamics"}
INERTIA = {"mass_matrix", "bias", "inverse_dynamics"}
TWO_LINKS, ANY_TWO, ANY = (
    ("paper-labelled",),
    ("paper-labelled", "probe"),
    ("paper-labelled", "probe", "three-unlike"),
)
CASES = {
    "plain_functions": (TWO_LINKS, WHOLE),
    "coriolis_matrix": (ANY_TWO, {"coriolis", "bias"}),
    "mass_matrix_alone": (ANY, {"mass_matrix"}),
    "absolute_angles": (ANY, WHOLE),
    "sympy_mechanics": (ANY_TWO, WHOLE),
    "sympy_map": (ANY_TWO, WHOLE),
    "casadi_two_link": (ANY_TWO, WHOLE),
    "acceleration_alone": (ANY_TWO, {"acceleration"}),
    "inverse_dynamics_alone": (ANY, INERTIA),
    "geared_lumped": (ANY_TWO, WHOLE),
    "geared_free": (ANY_TWO, WHOLE),
}


def loaded(example: str, name: str) -> SuppliedEquations:
    arm = load_arm(name)
    equations = load_equations(f"{EXAMPLES / example}.py:model", arm, None)
    return bind_equations(equations, arm, build_frame(equations.coordinates, arm))


def test_every_example_is_here():
    assert {path.stem for path in EXAMPLES.glob("*.py")} == set(CASES)


@pytest.mark.parametrize("example", CASES)
def test_is_right(example):
    arms, parts = CASES[example]
    tolerance = ROUNDING_OF_ARCS if example == "geared_free" else ROUNDING
    for name in require_items(arms):
        model = loaded(example, name)
        assert model.has == parts
        for part, apart in require_items(worst(model, model.arm).items()):
            assert apart < tolerance, f"{part} on {name}"


def test_a_correct_example_on_another_arm_is_found_wrong():
    """The comparison above can fail."""
    model = loaded("plain_functions", "probe")
    assert worst(model, model.arm)["mass_matrix"] > 0.1


@pytest.mark.parametrize("example", ["casadi_two_link", "sympy_mechanics", "geared_free"])
def test_knows_other_arms(example):
    model, probe = loaded(example, "paper-labelled"), load_arm("probe")
    other = model.equations.adapt_to_arm(probe)
    bound = bind_equations(other, probe, build_frame(other.coordinates, probe))
    assert worst(bound, probe)["bias"] < ROUNDING
