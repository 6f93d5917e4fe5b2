"""Both of Exudyn's tiers: every stiffness law's force, damping, modes and largest step."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.models.exudyn.bodies.bodies import ExudynBodies
from crosscheck.models.exudyn.tree.tree import ExudynTree
from tests.mixed_arms import (
    LAWS,
    PAYLOAD,
    PLANET_M,
    R_S,
    ROD_MASS,
    SUN_J,
    Data,
    arm_of,
    direct,
    geared,
    mean_stiffness,
    scenario,
    stiffness,
)

Tier = type[ExudynTree] | type[ExudynBodies]
both_tiers = pytest.mark.parametrize("tier", [ExudynTree, ExudynBodies], ids=lambda t: t.name)
every_law = pytest.mark.parametrize("law", LAWS)


def beyond(x: float, b: float) -> float:
    """Eq. 5 [m]."""
    return float(np.sign(x) * max(abs(x) - b, 0))


@both_tiers
@every_law
def test_each_stiffness_law_makes_its_mesh_force(tier: Tier, law: str):
    for sun, ring in ((law, "sine"), ("sine", law)):
        model = tier(arm_of(geared(sun, ring), gravity=(0.0, 0.0)), scenario())
        for x_sp, x_pr, theta in ((9e-5, -8e-5, 0.71), (-7e-5, 2e-4, -3.3), (1e-4, 9e-5, 0.0)):
            q = np.array([x_sp, x_pr, theta])
            at_sun, at_ring = 90 * theta + 0.9, 90 * theta - 0.4
            expected = [
                -4 * stiffness(sun, at_sun) * beyond(x_sp - 2e-5 * np.sin(at_sun), 4e-5),
                -4 * stiffness(ring, at_ring) * beyond(x_pr - 1e-5 * np.sin(at_ring), 3e-5),
                0.0,
            ]
            # Deflections of 1e-5 m out of places near 1 m, times 4e8 N/m; a phase of 300 rad.
            np.testing.assert_allclose(
                model.generalized_force(0.0, q, 0 * q), expected, rtol=1e-11, atol=1e-6
            )


@both_tiers
@every_law
def test_damping_follows_the_mean_stiffness(tier: Tier, law: str):
    model = tier(arm_of(geared(law, law), gravity=(0.0, 0.0)), scenario())
    mean, sun_mass = mean_stiffness(law), SUN_J / R_S**2
    damping = np.array(
        [2 * 0.06 * np.sqrt(4 * mean * sun_mass), 2 * 0.04 * np.sqrt(4 * mean * 4 * PLANET_M), 0.0]
    )
    q = np.zeros(3)  # in the play of every mesh
    for v in np.diag([0.3, -0.2, 0.0]):
        # Means, roots and a few products.
        np.testing.assert_allclose(
            model.generalized_force(0.0, q, v), -damping * v, rtol=1e-12, atol=1e-9
        )


@every_law
def test_mesh_modes_are_those_of_the_mean_stiffness(law: str):
    model = ExudynTree(arm_of(geared(law, law), gravity=(0.0, 0.0)), scenario())
    steady = {"law": "sine", "mean_N_per_m": mean_stiffness(law), "amplitude_N_per_m": 0.0}
    joint = geared()
    meshes = {name: {**joint[name], "stiffness": steady} for name in ("sun_mesh", "ring_mesh")}
    plain = ExudynTree(arm_of(geared(**meshes), gravity=(0.0, 0.0)), scenario())
    # The engine linearises by differences at 1e-7.
    np.testing.assert_allclose(model.mesh_modes(), plain.mesh_modes(), rtol=1e-6)
    highest = max(stiffness(law, phase) for phase in np.linspace(0, 2 * np.pi, 2001))
    steady["mean_N_per_m"] = highest
    stiff = ExudynTree(arm_of(geared(**meshes), gravity=(0.0, 0.0)), scenario())
    # Fine samples miss a maximum by the square of their distance; the step follows its root, and
    # the damping ratio counts a mean that differs: 1 percent of what a ratio of 0.06 changes.
    assert model.largest_stable_step() == pytest.approx(stiff.largest_stable_step(), rel=0.02)


def test_without_gears_there_are_no_modes_and_the_step_follows_friction_and_gains():
    inertia = 0.07 + ROD_MASS * (0.9**2 / 12 + 0.4**2) + PAYLOAD * 0.9**2
    drives: tuple[tuple[float, Data, float], ...] = (
        (1e4, {"kind": "constant", "torque_N_m": 0.0}, 2.785293563 * inertia / 1e4),
        (0.0, pd(1e8), np.sqrt(8) / np.sqrt(1e8 / inertia)),
    )
    for friction, drive, limit in drives:
        arm = arm_of(direct(friction_N_m_s_per_rad=friction), gravity=(0.0, 0.0))
        model = ExudynTree(arm, scenario(drive=drive))
        assert model.mesh_modes().shape == (0,)
        # Where RK4's |R| passes 1 on the real and on the imaginary axis; steps are tried in 1e-4.
        assert model.largest_stable_step() == pytest.approx(limit, rel=1e-3)


def pd(gain: float) -> Data:
    return {
        "kind": "pd",
        "target_rad": 0.0,
        "proportional_N_m_per_rad": gain,
        "derivative_N_m_s_per_rad": 0.0,
    }
