"""A trial from end to end: right equations pass, an error is named, whatever the coordinates."""

from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
import pytest

from crosscheck.checks.corners import list_corners
from crosscheck.cli.files.template import make_plain_arm
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_arm, load_scenario, make_rest_scenario
from crosscheck.models.robot.file import load_robot
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.registry import build
from crosscheck.trial.arms.questions import TransformedModel
from crosscheck.trial.arms.subject import build_problem
from crosscheck.trial.changes.arms.arm_numbers import draw_probe_arms
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.coordinates.states import UserState
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.input.loading import build_equations
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import DIGITS, Trial
from crosscheck.trial.trial import run_trial
from tests.arms import random_arm
from tests.robots.trials import robot_equations, run_robot_trial
from tests.trial.mistakes.equations import written

two_links = partial(written, "absolute", ())  # two rods, by hand
LEVELS = ("links", "carriers", "armature", "coupled")


class FramedModel(TransformedModel):
    """A model in a user's coordinates, asked at a state."""

    def ask(self, part: str, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """A part's answer, (n,) or (n, n)."""
        q, v = self.frame.position(x), self.frame.jacobian(x) @ u
        made: np.ndarray = self.answer(part, [UserState(0.0, x, u, q, v, 0 * q)])[0]
        return made

    def mass_matrix(self, x: np.ndarray) -> np.ndarray:
        """M (n, n)."""
        return self.ask("mass_matrix", x, 0 * x)

    def bias(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The bias (n,)."""
        return self.ask("bias", x, v)

    def gravity(self, x: np.ndarray) -> np.ndarray:
        """The forces that hold the weights (n,)."""
        return self.ask("gravity", x, 0 * x)


def in_frame(model: str, coordinates: Coordinates, arm: Arm, scenario: Scenario) -> FramedModel:
    """A model of the project in a user's coordinates."""
    gearing = coordinates.gearing
    planets = {} if gearing == "rigid" else {"planets": gearing}
    built = build(model, arm, scenario, usual_switches(arm, **planets))
    return FramedModel(built, build_frame(coordinates, arm))


def equations_of(moved: FramedModel, **errors: object) -> Equations:
    """Plain functions that answer as a model does; errors: other functions in their place."""

    def force(t: float, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        frame: Frame = moved.frame
        jacobian = frame.jacobian(x)
        return jacobian.T @ moved.model.generalized_force(t, frame.position(x), jacobian @ v)

    def bias(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return moved.bias(x, v)

    functions = {"mass_matrix": moved.mass_matrix, "bias": bias, "force": force}
    return Equations(**{**functions, **errors})


def trial_of(factory: object, arm: Arm, name: str = "yours", **asked: object) -> Trial:
    """Of a factory of an arm and a scenario."""
    equations = build_equations(factory, arm, load_scenario("pd"), name)
    return run_trial(TrialRequest(name, equations, arm, quick=True, **asked))


def of_project(model: str, coordinates: Coordinates):
    """A factory of a model of the project, handed over."""

    def factory(arm: Arm, scenario: Scenario) -> Equations:
        moved = in_frame(model, coordinates, arm, scenario)
        return replace(equations_of(moved), coordinates=coordinates)

    return factory


# Every two of the three choices together, each on an arm of its own.
@pytest.mark.parametrize(
    ("gearing", "gears", "links", "seed"),
    [
        ("lumped", "displacements", "relative", 15),
        ("lumped", "angles", "absolute", 24),
        ("free", "displacements", "absolute", 29),
        ("free", "angles", "relative", 32),
    ],
)
def test_right_geared_equations_pass_on_an_arm_of_random_numbers(gearing, gears, links, seed):
    """And on the probe arms of its structure."""
    coordinates = Coordinates(gearing, links, gears)
    most = 2 if gearing == "lumped" else 1  # each planet of a joint is a coordinate
    arm = random_arm(seed, most_joints=most, all_geared=True)
    trial = trial_of(of_project("analytic:physical", coordinates), arm)
    assert [finding.id for finding in trial.agreement.disagreeing] == []
    assert trial.diagnosis.entries == ()


def test_products_of_rates_are_asked_on_both_sides_of_the_edge_of_contact(labelled):
    """And M at all corners of the mesh laws: no law is in either, unless equations are wrong."""
    of_gears = of_project("analytic:physical", Coordinates("lumped"))
    equations = build_equations(of_gears, labelled, load_scenario("pd"), "yours")
    problem = build_problem(TrialRequest("yours", equations, labelled, quick=True))
    corners = list_corners(problem.frame.layout, labelled)
    asked = {
        part: len(problem.evaluate(problem.reference(""), part)) - problem.count
        for part in ("mass_matrix", "rate_terms")
    }
    assert {corner.touching for corner in corners[: asked["rate_terms"]]} == {True, False}
    assert asked["mass_matrix"] == len(corners)


@pytest.mark.parametrize("planets", range(2, 9))
def test_probe_arms_have_as_many_planets_that_mesh_in_the_same_order(planets, labelled):
    teeth = {"sun_teeth": 16 * planets - 1, "planet_teeth": 4 * planets + 1}
    ring = teeth["sun_teeth"] + 2 * teeth["planet_teeth"]
    joint = {**labelled.joints[0].model_dump(), **teeth, "ring_teeth": ring}
    joints = [{**joint, "planet_count": planets}] * 2
    probe, _ = draw_probe_arms(
        Arm.model_validate({**labelled.model_dump(), "joints": joints}), 2, {}
    )
    assert [made.planet_count for made in probe.joints] == [planets] * 2
    assert [(made.sun_teeth + 1) % planets for made in probe.joints] == [0, 0]
    assert probe.joints[0].sun_teeth != probe.joints[1].sun_teeth


@pytest.mark.parametrize("level", LEVELS)
def test_the_ladder_says_which_level_a_rigid_model_is(level):
    """By M, bias and force, and by accelerations alone."""
    arm, absolute = load_arm("probe"), Coordinates("rigid", "absolute")
    moved = in_frame(f"pinocchio:{level}", Coordinates(), arm, make_unequal_gains_scenario(arm))
    alone = Equations(acceleration=lambda t, x, v, torque: moved.model.acceleration(t, x, v))
    for own in (of_project(f"pinocchio:{level}", absolute), alone):
        trial = trial_of(own, arm)
        assert (trial.level, trial.exit_code) == (level, 0)
        assert own is alone or [d.level for d in trial.distances if d.entries == 0] == [level]


def test_half_a_length_for_a_centre_of_mass_is_a_note(labelled):
    """L_2 / 2 for d_2, of a link whose centre is there: right on this arm, and said."""

    def halves(arm: Arm) -> Equations:
        outer = arm.links[1].model_copy(update={"com_m": arm.links[1].length_m / 2})
        return two_links(arm.model_copy(update={"links": (arm.links[0], outer)}))

    trial = trial_of(halves, labelled)
    assert (trial.exit_code, trial.diagnosis.entries, trial.diagnosis.hidden) == (0, (), ())
    (number,) = trial.diagnosis.ignored_numbers
    assert (number.name, dict(number.goes_with)) == ("links[1].com_m", {"links[1].length_m": 1})


def shorten_answers(whole: Equations, factor: float) -> Equations:
    """The same by float32, M times a factor."""
    return replace(
        whole,
        mass_matrix=lambda q: np.float32(factor) * np.float32(whole.mass_matrix(q)),
        bias=lambda q, v: np.float32(whole.bias(q, v)),
    )


@pytest.mark.parametrize(("factor", "is_rounding"), [(1 + 5.5e-5, True), (1 + 6.5e-5, False)])
@pytest.mark.parametrize("mechanism", ["arm", "robot"])
def test_the_rounding_of_single_precision_is_no_error_of_equations(
    mechanism, factor, is_rounding, labelled
):
    if mechanism == "arm":
        trial = trial_of(lambda arm: shorten_answers(two_links(arm), factor), labelled)
    else:
        robot = load_robot("sliding")
        trial = run_robot_trial(shorten_answers(robot_equations(robot), factor), robot)
    assert trial.exit_code == 1
    assert ("wrong" in trial.headline) == (not is_rounding)
    assert any("float32" in each for each in trial.causes) == is_rounding
    assert all((each.cause == DIGITS) == is_rounding for each in trial.wrong)
    assert len(trial.wrong) > 2


def test_inverse_dynamics_alone_is_judged_where_a_and_v_meet(labelled):
    """Not only at a = 0 and at unit a at rest."""

    def of(by: float):
        def factory(arm: Arm) -> Equations:
            own = two_links(arm)

            def whole(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
                return own.mass_matrix(q) @ a + own.bias(q, v) + by * a * v

            return Equations(inverse_dynamics=whole, coordinates=own.coordinates)

        return factory

    assert trial_of(of(0.0), labelled).exit_code == 0
    (red,) = trial_of(of(1e-3), labelled).agreement.disagreeing
    assert red.quantity == "inverse-dynamics"


@pytest.mark.parametrize("share", [1, 0.9, -1])
def test_inverse_dynamics_hold_the_weights_that_the_force_has(share):
    """share: of the weights in the inverse dynamics; the force has them whole."""

    def factory(arm: Arm) -> Equations:
        model = build("analytic:links", arm, make_rest_scenario())

        def push(x: np.ndarray, torque: np.ndarray) -> np.ndarray:
            return torque + model.generalized_force(0.0, x, 0 * x)

        def whole(x: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
            return model.mass_matrix(x) @ a + model.bias(x, v) - share * push(x, 0 * x)

        return Equations(model.mass_matrix, model.bias, inverse_dynamics=whole, force=push)

    differing = trial_of(factory, make_plain_arm("tested", 2)).agreement.disagreeing
    assert [each.quantity for each in differing] == ["inverse-dynamics"] * (share != 1)


FORMS = "effects", "beside gravity", "beside force", "whole in force", "torques"


@pytest.mark.parametrize(
    ("form", "friction", "share"), [("effects", 0, 1), *product(FORMS, [0.7], [1, 0.9])]
)
def test_weights_and_friction_may_stand_where_people_write_them(form, friction, share):
    """share: how much of both the equations have, of which less than all is wrong."""
    plain = make_plain_arm("tested", 2 if share == 1 else 1)
    damped = plain.joints[0].model_copy(update={"friction_N_m_s_per_rad": friction})

    def factory(arm: Arm) -> Equations:
        model = build("analytic:links", arm, make_rest_scenario())

        def hold(x: np.ndarray) -> np.ndarray:
            return -share * model.generalized_force(0.0, x, 0 * x)

        def bias(x: np.ndarray, v: np.ndarray) -> np.ndarray:
            return model.bias(x, v) + hold(x) + share * friction * v

        def whole(x: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
            return model.mass_matrix(x) @ a + bias(x, v)

        def push(x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
            return torque - hold(x) - share * friction * v

        return {
            "effects": Equations(model.mass_matrix, bias),
            "beside gravity": Equations(inverse_dynamics=whole, gravity=hold),
            "beside force": Equations(inverse_dynamics=whole, force=lambda torque: torque),
            "torques": Equations(model.mass_matrix, bias, force=lambda torque: torque),
            "whole in force": Equations(
                model.mass_matrix, model.bias, inverse_dynamics=whole, force=push
            ),
        }[form]

    trial = trial_of(factory, plain.model_copy(update={"joints": (damped,) * len(plain.joints)}))
    assert trial.agrees == (share == 1)
    assert any("not 0 at rest" in each for each in trial.scope)
