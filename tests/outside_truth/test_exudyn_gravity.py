"""Both of Exudyn's tiers on the arm's second version: gravity, friction, direct joints, laws.

Closed forms first; then the tiers, which share no law and no body, against each other.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.special import ellipj

from models.arm import Arm
from models.exudyn_bodies import ExudynBodies
from models.exudyn_tree import ExudynTree
from models.scenario import Scenario
from models.switches import switches

Tier = type[ExudynTree] | type[ExudynBodies]
Data = dict[str, object]
EPSILON = np.finfo(float).eps
GRAVITY = (3.1, -9.2)
TEETH = {"sun_teeth": 30, "planet_teeth": 30, "ring_teeth": 90, "planet_count": 4}
R_S = R_P = 0.0025 * 30 / 2 * np.cos(np.radians(20))
SUN_J, PLANET_M = 4.5e-4, 0.7
LAWS: dict[str, Data] = {
    "sine": {"law": "sine", "mean_N_per_m": 8e7, "amplitude_N_per_m": 1.5e7},
    "fourier": {
        "law": "fourier",
        "mean_N_per_m": 9e7,
        "cosine_N_per_m": [1e7, -3e6, 2e6],
        "sine_N_per_m": [6e6],
    },
    "square": {
        "law": "square",
        "contact_ratio": 1.6,
        "least_N_per_m": 6e7,
        "largest_N_per_m": 1e8,
        "harmonics": 7,
    },
    "table": {
        "law": "table",
        "phase_cycles": [0.0, 0.13, 0.2, 0.45, 0.7, 0.86, 1.0],
        "stiffness_N_per_m": [8e7, 9.5e7, 1e8, 7e7, 6e7, 8.5e7, 8e7],
    },
}
MEANS = {"sine": 8e7, "fourier": 9e7, "square": 6e7 + 0.6 * 4e7}

both_tiers = pytest.mark.parametrize("tier", [ExudynTree, ExudynBodies], ids=lambda t: t.name)
every_law = pytest.mark.parametrize("law", LAWS)


def stiffness(law: str, phase: float) -> float:
    """As the laws' descriptions state it [N/m]."""
    if law == "sine":
        return 8e7 + 1.5e7 * np.sin(phase)
    if law == "fourier":
        cosines = sum(c * np.cos(n * phase) for n, c in ((1, 1e7), (2, -3e6), (3, 2e6)))
        return 9e7 + cosines + 6e6 * np.sin(phase)
    if law == "square":
        waves = sum(
            (np.sin(i * (2 * np.pi * 0.6 - phase)) + np.sin(i * phase)) / (i * np.pi)
            for i in range(1, 8)
        )
        return 6e7 + 4e7 * (0.6 + waves)
    return float(spline()(phase / (2 * np.pi) % 1))


def spline() -> CubicSpline:
    table = LAWS["table"]
    return CubicSpline(table["phase_cycles"], table["stiffness_N_per_m"], bc_type="periodic")


def mean_stiffness(law: str) -> float:
    return MEANS[law] if law in MEANS else float(spline().integrate(0, 1))


def geared(sun: str = "sine", ring: str = "sine", **changes: object) -> Data:
    sun_mesh = {
        "stiffness": LAWS[sun],
        "backlash_m": 4e-5,
        "tooth_error_m": 2e-5,
        "phase_rad": 0.9,
        "damping_ratio": 0.06,
        "tanh_sharpness_per_m": 3e4,
    }
    ring_mesh = {
        "stiffness": LAWS[ring],
        "backlash_m": 3e-5,
        "tooth_error_m": 1e-5,
        "phase_rad": -0.4,
        "damping_ratio": 0.04,
        "tanh_sharpness_per_m": 2e4,
    }
    return {
        "kind": "planetary",
        **TEETH,
        "module_m": 0.0025,
        "pressure_angle_deg": 20.0,
        "sun_inertia_kg_m2": SUN_J,
        "planet_equivalent_mass_kg": PLANET_M,
        "carrier_inertia_kg_m2": 0.03,
        "sun_mass_kg": 0.36,
        "planet_mass_kg": 0.52,
        "carrier_mass_kg": 5.5,
        "ring_mass_kg": 8.0,
        "ring_inertia_kg_m2": 0.11,
        "sun_mesh": sun_mesh,
        "ring_mesh": ring_mesh,
        **changes,
    }


def direct(**changes: object) -> Data:
    return {"kind": "direct", "motor_mass_kg": 2.5, "rotor_inertia_kg_m2": 0.07, **changes}


ROD: Data = {
    "length_m": 0.9,
    "com_m": 0.4,
    "cross_section_m2": 0.004,
    "density_kg_per_m3": 2700.0,
}
BODY: Data = {"length_m": 0.7, "com_m": 0.25, "mass_kg": 6.0, "inertia_kg_m2": 0.5}
ROD_MASS = 0.9 * 0.004 * 2700
PAYLOAD = 3.0


def arm_of(*joints: Data, gravity: tuple[float, float] = GRAVITY) -> Arm:
    """Rod and body take turns as links."""
    links = [(ROD, BODY)[place % 2] for place in range(len(joints))]
    return Arm.model_validate(
        {
            "schema_version": 2,
            "name": "arm",
            "payload_mass_kg": PAYLOAD,
            "gravity_m_per_s2": gravity,
            "joints": joints,
            "links": links,
        }
    )


def scenario(torque: float | list[float] = 0.0, **changes: object) -> Scenario:
    return Scenario.model_validate(
        {
            "schema_version": 1,
            "name": "test",
            "duration_s": 1e-4,
            "step_s": 1e-6,
            "record_every": 10,
            "drive": {"kind": "constant", "torque_N_m": torque},
            **changes,
        }
    )


def turning(mass_place: float, angle: float) -> float:
    """Gravity's torque [N m] about an axis of mass times distance [kg m] along an angle."""
    return mass_place * (GRAVITY[1] * np.cos(angle) - GRAVITY[0] * np.sin(angle))


@both_tiers
@pytest.mark.parametrize("joint", [geared(), direct()], ids=["geared", "direct"])
def test_gravity_turns_a_single_link(tier: Tier, joint: Data):
    model = tier(arm_of(joint), scenario())
    q = np.zeros(len(model.layout))
    q[-1] = 0.8
    force = model.generalized_force(0.0, q, 0 * q)
    # Weights of 90 N on levers of 1 m, rounded; the planets' cancel.
    assert force[-1] == pytest.approx(turning(ROD_MASS * 0.4 + PAYLOAD * 0.9, 0.8), rel=1e-13)
    np.testing.assert_allclose(force[:-1], 0, atol=1e-12)


@both_tiers
def test_gravity_turns_a_bent_arm(tier: Tier):
    for joints, at_elbow in (
        ((geared(), geared()), 0.36 + 4 * 0.52 + 5.5 + 8.0),
        ((direct(), direct()), 2.5),
        ((geared(), direct()), 2.5),
    ):
        model = tier(arm_of(*joints), scenario())
        q = np.zeros(len(model.layout))
        q[model.layout.theta] = 0.8, -1.7
        outer = turning(6.0 * 0.25 + PAYLOAD * 0.7, 0.8 - 1.7)
        inner = turning(ROD_MASS * 0.4 + (at_elbow + 6.0 + PAYLOAD) * 0.9, 0.8)
        force = model.generalized_force(0.0, q, 0 * q)
        expected = np.zeros(len(q))
        expected[model.layout.theta] = inner + outer, outer
        # Weights of 300 N on levers of 1 m, rounded.
        np.testing.assert_allclose(force, expected, rtol=1e-12, atol=1e-11)


@both_tiers
def test_gravity_is_no_part_of_the_bias(tier: Tier):
    still, falling = (
        tier(arm_of(geared(), direct(), gravity=gravity), scenario())
        for gravity in ((0.0, 0.0), GRAVITY)
    )
    for q, v in random_states(still, 3):
        np.testing.assert_array_equal(falling.bias(q, v), still.bias(q, v))


@both_tiers
def test_friction_brakes_link_against_previous_link(tier: Tier):
    rough = [kind(friction_N_m_s_per_rad=c) for kind, c in ((geared, 7.0), (direct, 11.0))]
    with_friction, without = (
        tier(arm_of(*joints), scenario()) for joints in (rough, (geared(), direct()))
    )
    for q, v in random_states(without, 3):
        dragged = with_friction.generalized_force(0.0, q, v)
        expected = np.zeros(len(q))
        expected[without.layout.theta] = -np.array([7.0, 11.0]) * v[without.layout.theta]
        # Contact forces up to 1e4 N on levers of 1 m stand beside the friction.
        np.testing.assert_allclose(
            dragged - without.generalized_force(0.0, q, v), expected, rtol=0, atol=1e-10
        )


@both_tiers
def test_direct_joints_make_the_two_link_arm_of_the_textbooks(tier: Tier):
    model = tier(arm_of(direct(), direct(), gravity=(0.0, 0.0)), scenario([40.0, -15.0]))
    q, v = np.array([0.3, 0.9]), np.array([1.1, -2.0])
    outer = 0.07 + 0.5 + 6.0 * 0.25**2 + PAYLOAD * 0.7**2
    lever = (6.0 * 0.25 + PAYLOAD * 0.7) * 0.9
    inner = 0.07 + ROD_MASS * (0.9**2 / 12 + 0.4**2) + (2.5 + 6.0 + PAYLOAD) * 0.9**2
    c, s = np.cos(q[1]), np.sin(q[1])
    mass = [[inner + outer + 2 * lever * c, outer + lever * c], [outer + lever * c, outer]]
    bias = [-lever * s * (2 * v[0] + v[1]) * v[1], lever * s * v[0] ** 2]
    # A few sums of numbers near 10.
    np.testing.assert_allclose(model.mass_matrix(q), mass, rtol=1e-13)
    np.testing.assert_allclose(model.bias(q, v), bias, rtol=1e-12)
    np.testing.assert_allclose(model.generalized_force(0.0, q, v), [40.0, -15.0], rtol=1e-13)
    acceleration = np.linalg.solve(mass, np.subtract([40.0, -15.0], bias))
    np.testing.assert_allclose(model.acceleration(0.0, q, v), acceleration, rtol=1e-12)


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
        [
            2 * 0.06 * np.sqrt(4 * mean * sun_mass),
            2 * 0.04 * np.sqrt(4 * mean * 4 * PLANET_M),
            0.0,
        ]
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


def test_a_pendulum_swings_as_the_elliptic_functions_say():
    start = {"theta_rad": 2.0}
    run = scenario(duration_s=3.0, step_s=1e-3, record_every=50, start=start)
    motion = ExudynTree(arm_of(direct(), gravity=(9.81, 0.0)), run).simulate()
    inertia = 0.07 + ROD_MASS * (0.9**2 / 12 + 0.4**2) + PAYLOAD * 0.9**2
    rate = np.sqrt(9.81 * (ROD_MASS * 0.4 + PAYLOAD * 0.9) / inertia)
    k = np.sin(1.0)
    _, cn, dn, _ = ellipj(rate * motion.time.values, k**2)
    expected = 2 * np.arcsin(k * cn / dn)
    # RK4 at 1 ms: (h omega)^4 / 120 per radian of omega t, 12 of them.
    np.testing.assert_allclose(motion.theta.values[:, 0], expected, rtol=0, atol=1e-10)
    drop = 9.81 * (ROD_MASS * 0.4 + PAYLOAD * 0.9) * (np.cos(motion.theta.values[:, 0]) - np.cos(2))
    np.testing.assert_allclose(motion.kinetic_energy, drop, rtol=0, atol=1e-8)


def random_states(
    model: ExudynTree | ExudynBodies, count: int
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Every mesh in or around its play."""
    draw = np.random.default_rng(3)
    scale = np.where(model.layout.angular, 1.0, 1e-4)
    return [
        (scale * draw.normal(size=scale.size), scale * draw.normal(size=scale.size))
        for _ in range(count)
    ]


MIXED: dict[str, Callable[[], Arm]] = {
    "direct-geared": lambda: arm_of(direct(friction_N_m_s_per_rad=4.0), geared("table", "square")),
    "geared-direct": lambda: arm_of(geared("fourier", "table"), direct()),
    "geared-direct-geared": lambda: arm_of(
        geared("square", "sine", friction_N_m_s_per_rad=9.0),
        direct(friction_N_m_s_per_rad=2.0),
        geared("sine", "fourier", planet_count=3),
    ),
    "direct-direct": lambda: arm_of(direct(), direct(friction_N_m_s_per_rad=3.0)),
}
EVERY_LAW = [
    switches(phase=phase, dead_zone=zone, damping=damping)
    for phase, zone, damping in product(
        ("angle", "omega_t"), ("exact", "tanh"), ("always", "contact")
    )
]


@pytest.mark.parametrize("name", MIXED)
def test_the_tiers_agree_at_random_states(name: str):
    arm, run = MIXED[name](), scenario([30.0, -20.0, 10.0][: len(MIXED[name]().joints)])
    for chosen in EVERY_LAW:
        tree, bodies = ExudynTree(arm, run, chosen), ExudynBodies(arm, run, chosen)
        assert tree.coordinates == bodies.coordinates
        for q, v in random_states(tree, 3):
            for one, other in (
                (tree.mass_matrix(q), bodies.mass_matrix(q)),
                (tree.bias(q, v), bodies.bias(q, v)),
                (tree.generalized_force(0.1, q, v), bodies.generalized_force(0.1, q, v)),
                (tree.acceleration(0.1, q, v), bodies.acceleration(0.1, q, v)),
            ):
                # Of the largest entry: deflections near 1e-4 m out of places near 1 m.
                np.testing.assert_allclose(one, other, rtol=0, atol=1e-11 * abs(one).max())


@both_tiers
def test_records_of_an_arm_with_direct_joints(tier: Tier):
    run = tier(MIXED["geared-direct"](), scenario()).simulate()
    assert dict(run.sizes) == {"time": 11, "joint": 2, "planet": 4}
    for name in ("x_sp", "x_pr", "x_sp_dot", "x_pr_dot", "F_sp", "F_pr"):
        assert run[name].sel(joint=1).notnull().all()
        assert run[name].sel(joint=2).isnull().all()
    run = tier(MIXED["direct-direct"](), scenario()).simulate()
    assert dict(run.sizes) == {"time": 11, "joint": 2}
    assert {"theta", "theta_dot", "theta_ddot", "torque", "kinetic_energy"} == set(run.data_vars)


@both_tiers
def test_start_is_at_first_contact_of_each_mesh(tier: Tier):
    start = {"theta_rad": [0.1, 0.2], "sun_planet_offset_m": [1e-6, 2e-6]}
    run = tier(MIXED["direct-geared"](), scenario(start=start)).simulate().isel(time=0)
    # Angles of gears turned by 1 rad and back.
    np.testing.assert_allclose(run.x_sp.sel(joint=2), 4e-5 + 2e-6, rtol=0, atol=1e-16)
    np.testing.assert_allclose(run.x_pr.sel(joint=2), 3e-5, rtol=0, atol=1e-16)


@both_tiers
def test_large_contact_forces_in_balance_raise_no_alarm(tier: Tier):
    joint, torque = geared(), 2e5
    heavy = {"length_m": 0.9, "com_m": 0.4, "mass_kg": 1e6, "inertia_kg_m2": 1e9}
    data = arm_of(joint, gravity=(0.0, 0.0)).model_dump()
    model = tier(Arm.model_validate({**data, "links": [heavy]}), scenario(torque))
    force = torque / 4 / R_S / 4  # of a planet's mesh: the sun is at rest, the ratio is 4
    at_sun, at_ring = 90 * 0.7 + 0.9, 90 * 0.7 - 0.4
    x_sp = force / stiffness("sine", at_sun) + 4e-5 + 2e-5 * np.sin(at_sun)
    x_pr = force / stiffness("sine", at_ring) + 3e-5 + 1e-5 * np.sin(at_ring)
    acceleration = model.acceleration(0.0, np.array([x_sp, x_pr, 0.7]), np.zeros(3))
    assert acceleration[2] == pytest.approx(torque / 1e9, rel=1e-2)
    assert force > 3e5


def test_planets_that_move_apart_are_refused():
    poses = ExudynBodies(arm_of(geared()), scenario()).poses
    turning = poses.turns @ np.array([0.1, 0.2, 0.3])
    np.testing.assert_allclose(poses.paper(turning, 1e-12), [0.1, 0.2, 0.3], rtol=1e-12)
    turning[-1] += 1e-6
    with pytest.raises(ArithmeticError, match="equal planets do not move alike"):
        poses.paper(turning, 1e-9)
