"""Exudyn's separate bodies against mechanics that owes nothing to them."""

import numpy as np
import pytest

from crosscheck.checks.answers import Setting
from crosscheck.checks.invariants import OPENED, constraint_residual
from crosscheck.models.errors import Diverged
from crosscheck.models.exudyn.bodies.bodies import ExudynBodies, GearPair
from crosscheck.models.exudyn.bodies.contact import CARRIER, PLANET, WHEEL, mesh_forces
from crosscheck.models.exudyn.bodies.poses import GROUND
from crosscheck.models.loading import Case, load_case
from tests.loops import require_items
from tests.mixed_arms import random_states

ALPHA = np.radians(24.6)
R_S, R_P, R_R = (3e-3 * teeth / 2 * np.cos(ALPHA) for teeth in (27, 36, 99))


def bodies(*settings: str, **switches: str) -> ExudynBodies:
    case = load_case("paper-labelled", "constant-torque", switches, settings)
    return ExudynBodies(*case)


def every_mesh(model: ExudynBodies) -> list[tuple[str, int, GearPair]]:
    return [
        (name, 3 * joint + coordinate, toothed)
        for joint, sides in enumerate(model.meshes)
        for coordinate, (name, side) in enumerate(zip(("sun", "ring"), sides, strict=True))
        for toothed in side
    ]


def seen(values: np.ndarray, toothed: GearPair) -> np.ndarray:
    """Poses or rates of a mesh's bodies, the ground's zero."""
    by_body = np.vstack([values.reshape(-1, 3), np.zeros(3)])
    return by_body[list(toothed.bodies)].ravel()


def placed(model: ExudynBodies, toothed: GearPair, q: np.ndarray, v: np.ndarray) -> tuple:
    pose, velocity = model.poses.pose(q), model.poses.velocity(q, v)
    return seen(pose, toothed), seen(velocity, toothed)


def wheel_centre(model: ExudynBodies, toothed: GearPair, pose: np.ndarray) -> complex:
    """The sun's own origin; of the ring's body, the far end of the previous link or the ground."""
    x, y, angle = pose[3 * WHEEL : 3 * WHEEL + 3]
    external, grounded = len(toothed.bodies) == 4, toothed.bodies[WHEEL] == GROUND
    length = 0.0 if external or grounded else model.arm.links[0].length_m
    return complex(x, y) + length * np.exp(1j * angle)


@pytest.mark.parametrize(
    "answered", [lambda opened: None, lambda opened: opened - OPENED], ids=["not", "too little"]
)
def test_a_model_whose_joints_do_not_open_as_asked_has_a_gap(answered, monkeypatch):
    """Closed joints alone would be those of a model that makes up its residuals."""
    model = bodies()
    asked = model, Setting(Case(model.arm, model.scenario, model.switches), "", 2, 0)
    assert constraint_residual(*asked).max() < 1e-12
    closed = ExudynBodies.constraint_residual
    monkeypatch.setattr(
        ExudynBodies,
        "constraint_residual",
        lambda self, q, v, a, opened=None: closed(
            self, q, v, a, None if opened is None else answered(opened)
        ),
    )
    assert constraint_residual(*asked).min() > OPENED / 2


def test_accelerations_of_bodies_that_solve_the_engines_equations_keep_the_joints_closed():
    model = bodies()
    for q, v in require_items(random_states(model.layout, 5, 7)):
        a = model.body_accelerations(0.1, q, v)
        engine = model.driven_engine
        swing = engine.swing(0.1, model.poses.pose(q), model.poses.velocity(q, v))
        engine.place(0.1, model.poses.pose(q), model.poses.velocity(q, v))
        # Gears accelerate with up to 1e6 rad/s^2; the solve leaves roundings of that.
        assert abs(engine.joint_jacobian() @ a + swing).max() < 1e-12 * abs(a).max()
        mapped = model.poses.acceleration(q, v, model.acceleration(0.1, q, v))
        np.testing.assert_allclose(a, mapped, rtol=0, atol=1e-11 * abs(a).max())


def test_the_force_of_a_mesh_touches_both_base_circles_at_the_pressure_angle():
    model = bodies()
    for q, v in require_items(random_states(model.layout, 5, 7)):
        for name, coordinate, toothed in require_items(every_mesh(model)):
            pose, velocity = placed(model, toothed, q, v)
            forces = mesh_forces(toothed.mesh, 0.0, pose, velocity).reshape(-1, 3)
            on_planet, about_planet = complex(*forces[PLANET, :2]), forces[PLANET, 2]
            centre = wheel_centre(model, toothed, pose)
            line = complex(*pose[3 * PLANET : 3 * PLANET + 2]) - centre
            about_wheel = about_planet + (line.conjugate() * on_planet).imag
            across = on_planet * line.conjugate() / abs(line)
            size = abs(on_planet)
            # Turned back into the frame of the line of centres: a few roundings.
            close = {"rel": 1e-12, "abs": 1e-12 * size}
            assert abs(about_wheel) == pytest.approx(
                (R_S if name == "sun" else R_R) * size, **close
            )
            assert abs(about_planet) == pytest.approx(R_P * size, **close)
            assert abs(across.imag) == pytest.approx(np.cos(ALPHA) * size, **close)
            outwards = 1 if name == "sun" else -1
            assert across.real == pytest.approx(outwards * np.sin(ALPHA) * size, **close)
            assert not forces[CARRIER].any()
            if abs(q[coordinate]) > 60e-6 and not v[coordinate] * q[coordinate] < 0:
                assert np.sign(across.imag) == np.sign(q[coordinate])


def bearing_forces(model, t, q, v):
    """Forces [N] of its revolute joint on every body, ground frame, (bodies, 2)."""
    engine, pose = model.driven_engine, model.poses.pose(q)
    reactions = engine.solve(t, pose, model.poses.velocity(q, v))[1].reshape(-1, 2)
    sign = np.diag(engine.joint_jacobian()[::2, ::3])  # of its own body in the gap: +1 or -1
    return -sign[:, None] * reactions


def test_bearings_and_teeth_accelerate_every_gear():
    model = bodies()
    mass = {"sun": 0.39, "planet": 0.61}
    for q, v in require_items(random_states(model.layout, 5, 7)):
        a = model.poses.acceleration(q, v, model.acceleration(0.0, q, v)).reshape(-1, 3)
        teeth = model.body_forces(0.0, q, v).reshape(-1, 3)
        bearings = bearing_forces(model, 0.0, q, v)
        for stage in require_items(model.stages):
            for gear, numbers in (("sun", [stage.driven]), ("planet", list(stage.planets))):
                total = teeth[numbers, :2] + bearings[numbers]
                # Teeth push with up to 2e4 N, and three of them balance on the sun.
                np.testing.assert_allclose(total, mass[gear] * a[numbers, :2], atol=1e-8)


def test_records_belong_to_the_recorded_state_and_the_joints_hold():
    model = bodies("scenario.duration_s=0.0005", "scenario.step_s=1e-6", "scenario.record_every=1")
    run = model.simulate()
    assert dict(run.sizes) == {"time": 501, "joint": 2, "planet": 3}
    for name in ("theta", "theta_dot", "x_sp", "x_pr"):
        record, rate = run[name], run[{"theta_dot": "theta_ddot"}.get(name, f"{name}_dot")]
        differences = (record.values[2:] - record.values[:-2]) / 2e-6
        # Mesh modes of 3e4 rad/s: central differences and the rule are off by (3e4 * 1e-6)^2 / 6.
        off = abs(differences - rate.values[1:-1]).max()
        assert off < 5e-4 * abs(rate).max()
    np.testing.assert_array_equal(run.torque, 100.0)
    q, v = model.start()
    assert run.kinetic_energy[0] == 0.5 * v @ model.mass_matrix(q) @ v
    pose, velocity = model.poses.pose(q), model.poses.velocity(q, v)
    model.free_engine.place(0.0, *model.driven_engine.run(pose, velocity, 500, 1e-6, 500)[-1])
    # Rates are held to rounding; places drift by what the rule leaves, far below the 5e-5 m of b.
    assert abs(model.free_engine.joints(velocity_level=True)).max() < 1e-12
    assert abs(model.free_engine.joints()).max() < 1e-12


def test_a_step_without_solution_ends_the_run_in_silence_and_says_when(capfd):
    model = bodies(
        "scenario.duration_s=0.1",
        "scenario.step_s=1e-3",
        "scenario.start.theta_dot_rad_per_s=[50.0, -100.0]",
    )
    assert model.largest_stable_step() == np.inf
    with pytest.raises(Diverged, match="exudyn:bodies: diverged at t = 0"):
        model.simulate()
    assert capfd.readouterr() == ("", "")
