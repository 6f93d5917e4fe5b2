"""Laws of the mesh that differ from the arm's at their corners alone are found, and named."""

from collections.abc import Callable

import numpy as np
import pytest

from crosscheck.checks.arm_data import mesh_damping
from crosscheck.checks.energy import springs_at
from crosscheck.checks.scales import geared_joints
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import MESHES
from crosscheck.models.experiment.scenario import Scenario, switches
from crosscheck.models.loading import load_arm
from crosscheck.registry import build
from crosscheck.trial.input.equations import Coordinates, Equations
from tests.trial.test_trial import trial_of

PAPER = load_arm("paper-labelled")
LUMPED = Coordinates("lumped")
Law = Callable[..., float]


def usual(x: float, e: float, b: float, k: float, damper: float) -> float:
    """The arm's own law, with dampers in contact alone."""
    gap = x - e
    return k * (gap - np.clip(gap, -b, b)) + damper * (abs(gap) > b)


def never_pull(x: float, e: float, b: float, k: float, damper: float) -> float:
    """Teeth that are pressed together or let go, never held together."""
    spring = k * (x - e - np.clip(x - e, -b, b))
    total = spring + damper
    return float(max(total, 0.0) if spring > 0 else min(total, 0.0) if spring < 0 else 0.0)


def cap_damper(x: float, e: float, b: float, k: float, damper: float) -> float:
    """A damper that never exerts more than the spring."""
    spring = k * (x - e - np.clip(x - e, -b, b))
    return spring + float(np.clip(damper, -abs(spring), abs(spring)))


def forget_error(x: float, e: float, b: float, k: float, damper: float) -> float:
    """Contact by x, and a spring by x - e."""
    return (k * (x - e - np.sign(x) * b) + damper) * (abs(x) > b)


def equations_by(law: Law) -> Callable[[Arm, Scenario], Equations]:
    """The reference's equations, its law of the mesh replaced."""

    def factory(arm: Arm, scenario: Scenario) -> Equations:
        chosen = switches(damping="contact")
        model = build("analytic:physical", arm, scenario, chosen)
        layout = model.layout

        def force(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
            total = np.array(model.generalized_force(t, q, v))
            springs = springs_at(arm, chosen, layout, q[None])
            for number, joint in geared_joints(arm):
                for planet in range(joint.planet_count):
                    for name in MESHES:
                        spring, row = next(springs), layout.displacement(name, number, planet)
                        gap, k = float(spring.gap[0]), float(spring.stiffness[0])
                        damper = mesh_damping(joint, name, planet) * float(v @ row)
                        x = float(q @ row)
                        at = x, x - gap, spring.backlash, k, damper
                        total -= (law(*at) - usual(*at)) * row
            return total

        return Equations(model.mass_matrix, model.bias, force=force, coordinates=LUMPED)

    return factory


@pytest.mark.parametrize(
    ("law", "damping", "expected"),
    [
        (never_pull, "contact", "a contact that never pulls where damping = contact"),
        (cap_damper, "contact", "the damper capped at the spring's force where damping = contact"),
        (never_pull, "always", "a contact that never pulls where damping = always"),
        (forget_error, "contact", "the gap asked of x where x - e belongs"),
    ],
)
def test_a_law_with_other_corners_is_named_in_every_mesh(law, damping, expected):
    chosen = switches(damping=damping)
    result = trial_of(equations_by(law), PAPER, switches=chosen)
    wrong = {entry.place.row: entry for entry in result.diagnosis.entries}
    assert set(wrong) == {0, 1, 3, 4}  # x_sp and x_pr of both joints
    assert {entry.place.part for entry in wrong.values()} == {"force"}
    (error,) = result.diagnosis.notes  # one law of all meshes
    assert expected in error
    assert all(entry.explanation for entry in wrong.values())


def test_the_arms_own_law_agrees():
    result = trial_of(equations_by(usual), PAPER, switches=switches(damping="contact"))
    assert result.agreement.exit_code == 0
