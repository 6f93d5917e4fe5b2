"""States on each side of every branch of the mesh laws, for every mesh of an arm."""

from itertools import product

import numpy as np
import pytest

from crosscheck.checks.answers import sample_states
from crosscheck.checks.corners import sample_corner_states
from crosscheck.checks.energy import springs_at
from crosscheck.checks.scales import geared_joints, mesh_damping
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import MESHES, geared_layout, rigid_layout
from crosscheck.models.arm.meshes import change_meshes
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.models.loading import load_arm
from tests.arms import PAPER, arm_of
from tests.loops import require_items

SIGNS = (1.0, -1.0)
CASES = [
    ("three-unlike", {}),
    ("probe", {"planets": "free"}),
    ("planets-apart", {}),
    ("direct-between", {}),
    ("paper-labelled", {"phase": "omega_t"}),
]


def corners_met(arm: Arm, chosen: Switches, pressed_by: float) -> dict[tuple[int, int, str], set]:
    """By mesh: flank, direction, and what |x - e| and |x| say of the contact, of its states.

    Only of states nearer to the corner than the damper's force presses the teeth.
    """
    layout = geared_layout(arm, chosen)
    states = sample_corner_states(layout, arm, chosen, 0)
    turned = states.q.copy()
    if chosen.phase == "omega_t":
        turned[:, layout.theta] = states.v[:, layout.theta] * states.t[:, None]
    springs, met = springs_at(arm, chosen, layout, turned), {}
    for number, joint in require_items(geared_joints(arm)):
        for planet, name in product(range(joint.planet_count), MESHES):
            spring, row = next(springs), layout.displacement(name, number, planet)
            x, rate, gap = states.q @ row, states.v @ row, spring.gap
            beyond = np.abs(gap) - spring.backlash
            pulled = mesh_damping(joint, name, planet) * np.abs(rate) / spring.stiffness
            near = np.abs(beyond) < pressed_by * pulled
            signs = np.sign(gap), np.sign(rate), beyond > 0, np.abs(x) > spring.backlash
            met[number, planet, name] = set(zip(*(sign[near] for sign in signs), strict=True))
    return met


@pytest.mark.parametrize(("name", "laws"), CASES)
def test_every_mesh_is_just_inside_and_just_outside_on_both_flanks_in_both_directions(name, laws):
    arm = load_arm(name)
    met = corners_met(arm, usual_switches(arm, **laws), 1.0)
    errs_both_ways = name != "planets-apart"  # its static errors are larger than the waves
    for mesh in require_items(met.values()):
        for flank, direction in require_items(product(SIGNS, SIGNS)):
            seen = {signs[2:] for signs in mesh if signs[:2] == (flank, direction)}
            assert {touching for touching, _ in seen} == {True, False}
            # What x says is the opposite of what x - e says.
            assert not errs_both_ways or seen >= {(True, False), (False, True)}


def test_without_dampers_and_errors_of_teeth_states_are_near_the_clearance():
    arm = change_meshes(
        PAPER, lambda mesh: mesh.model_copy(update={"damping_ratio": 0.0, "tooth_error_m": 0.0})
    )
    layout = geared_layout(arm, switches())
    states = sample_corner_states(layout, arm, switches(), 0)
    gaps = np.array([s.gap for s in springs_at(arm, switches(), layout, states.q)])
    b = PAPER.joints[0].sun_mesh.backlash_m
    assert (np.abs(np.abs(gaps) - b) < 1e-6).all()
    assert set(np.sign(np.abs(gaps) - b).ravel()) == {1.0, -1.0}


def test_an_arm_without_meshes_has_no_corners():
    arm = arm_of(2, direct=[0, 1])
    states = sample_corner_states(rigid_layout(arm), arm, switches(), 0)
    assert [values.shape for values in states] == [(0,), (0, 2), (0, 2)]
    assert sample_states(rigid_layout(arm), arm, 3, 0).q.shape == (3, 2)
