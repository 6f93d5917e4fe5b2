"""Hypothesis H7: Hill's equation from first principles, samples, and what is made of them."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.claims.quantities import quantity_of
from crosscheck.audit.claims.rule import Answer, Claim, Place, State, limits_above
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.experiments.paper_conditions import LAWS, PRINTED, Condition
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.third_fluctuation import PARTING_SPREAD_M
from crosscheck.audit.measures.twosamples import PValues
from crosscheck.audit.phase.runs import build_pd_variant
from crosscheck.audit.planets import hill, parting, verdict
from crosscheck.audit.planets.parting import (
    FirstPartingQuestion,
    PartingCourse,
    PartingQuestion,
    SymmetryBreaking,
    make_lumped_case,
)
from crosscheck.models.loading import Case
from tests.audit.planted_runs import third
from tests.loops import require_items

ABOVE, BELOW = 1.01, 0.99
CELL = Condition(PRINTED, 0.005)
SHORT = replace(build_pd_variant(CELL, 0.02), seed=1, record_every=10)


def _model(planets: str, variant: Variant = SHORT) -> PhysicalModel:
    arm, scenario, switches = variant.case()
    lumped = make_lumped_case(variant.case()) if planets == "lumped" else (arm, scenario, switches)
    return PhysicalModel(*lumped)


def _contacts() -> list[tuple[float, float]]:
    """x_sp and x_pr [m] of all planets: both meshes in contact, one of them, none."""
    b = 50e-6
    return [(b + 9e-6, b + 8e-6), (b + 9e-6, 0.0), (0.0, -b - 8e-6), (0.0, 0.0)]


@pytest.mark.parametrize("damping", ["always", "contact"])
@pytest.mark.parametrize("law", ["omega_t", "angle"])
@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("x", _contacts())
def test_hills_equation_is_the_free_models_own(law, joint, damping, x):
    """A difference that adds up to 0 is accelerated by itself alone, as the equation says."""
    arm, scenario, chosen = replace(SHORT, phase=law).case()
    model = PhysicalModel(arm, scenario, chosen.model_copy(update={"damping": damping}))
    q, v = _pose(model, x)
    mode = np.zeros(q.size)
    rows = [model.layout.at("x_pr", joint, planet) for planet in range(3)]
    mode[rows] = (2.0, -0.5, -1.5)
    stages = hill.build_stages(model)
    spring, damper, _, _ = hill.coefficients(model.gears, stages.mesh[joint], 0.3, q, v)
    for by, step, expected in (("q", 1e-9, spring), ("v", 1e-6, damper)):
        moved = _slope(model, q, v, mode, by, step)
        wanted = -expected / stages.mass[joint] * mode
        assert moved == pytest.approx(wanted, rel=1e-6, abs=1e-6 * stages.frequency[joint] ** 2)


def _pose(model: PhysicalModel, x: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Both joints in the same contacts, moving."""
    q, v = np.zeros((2, len(model.layout)))
    q[model.layout.theta], v[model.layout.theta] = (0.2, -0.4), (1.1, 0.7)
    q[model.layout.indices("x_s")], q[model.layout.indices("x_pr")] = sum(x), x[1]
    return q, v


def _slope(
    model: PhysicalModel, q: np.ndarray, v: np.ndarray, mode: np.ndarray, by: str, step: float
) -> np.ndarray:
    """Derivative of all accelerations along a mode of q or v, by central differences."""
    move = {"q": (mode, 0 * mode), "v": (0 * mode, mode)}[by]
    ahead, back = (
        model.acceleration(0.3, q + sign * step * move[0], v + sign * step * move[1])
        for sign in (1, -1)
    )
    return (ahead - back) / (2 * step)


@pytest.mark.parametrize("base", ["lumped", "free"])
def test_a_tiny_difference_follows_the_equation(base):
    """Through the first impacts, in which teeth part; started pressed in, not at the very edge."""
    case = _pressed_in(SHORT.case())
    model = PhysicalModel(*(make_lumped_case(case) if base == "lumped" else case))
    start = np.ptp(np.array(case.scenario.start.planet_offset_m), axis=1)
    (run,) = hill.follow_planets([model], start[None])
    found = run.by_contact
    spread = np.ptp(PhysicalModel(*case).simulate()["x_pr"].values, axis=2)
    assert (np.abs(spread - np.exp(found.part)) < 1e-3 * np.exp(found.size)).all()
    assert run.pressed.size.max() < np.log(3e-12)


@pytest.mark.parametrize("base", ["lumped", "free"])
def test_the_motion_that_is_followed_is_the_models_own_run(base):
    """Bit for bit, whichever starts are followed beside it: the same steps of the same kernel."""
    cases = [replace(SHORT, seed=seed).case() for seed in range(1, 11)]
    models = [
        PhysicalModel(*(make_lumped_case(case) if base == "lumped" else case)) for case in cases
    ]
    found = hill.follow_planets(models, np.full((10, 2), 1e-12))
    for one, run in require_items(zip(found, PhysicalModel.simulate_together(models), strict=True)):
        assert (one.time == run["time"].values).all()
        for joint, x_pr in require_items(enumerate(one.x_pr)):
            assert (x_pr == run["x_pr"].values[:, joint, : x_pr.shape[1]]).all()


def _pressed_in(case: Case) -> Case:
    """Every mesh by 1e-7 m."""
    start = case.scenario.start
    moved = {
        name: tuple(offset + 1e-7 for offset in getattr(start, name))
        for name in ("sun_planet_offset_m", "planet_ring_offset_m")
    }
    scenario = case.scenario.model_copy(update={"start": start.model_copy(update=moved)})
    return case._replace(scenario=scenario)


def test_the_mean_of_the_planets_starts_the_lumped_run():
    free, lumped = _model("free"), _model("lumped")
    (q, _), (p, _) = free.start(), lumped.start()
    for joint in (0, 1):
        x_pr = [q[free.layout.at("x_pr", joint, planet)] for planet in range(3)]
        assert p[lumped.layout.at("x_pr", joint)] == pytest.approx(np.mean(x_pr), abs=1e-19)
        both = p[lumped.layout.at("x_sp", joint)] + p[lumped.layout.at("x_pr", joint)]
        assert both == pytest.approx(q[free.layout.at("x_s", joint)], abs=1e-19)


def test_rounding_adds_up_until_damping_takes_as_much():
    decay, step, x = 90.0, 1e-5, 50e-6
    generator = np.random.default_rng(1)
    steps = generator.uniform(-0.5, 0.5, 400_000) * np.spacing(x)
    level, levels = 0.0, []
    for one in steps:
        level = level * np.exp(-decay * step) + one
        levels.append(level)
    floor = hill.rounding_floor(np.array(x), np.array(decay), step)
    assert float(np.std(levels[20_000:])) == pytest.approx(float(floor), rel=0.15)


def test_seeds_of_lumped_planets_are_those_of_free_ones_and_more():
    lumped, free = (
        replace(SHORT, planets=planets).case().scenario.start for planets in ("lumped", "free")
    )
    assert lumped.sun_planet_offset_m == free.sun_planet_offset_m
    assert lumped.planet_ring_offset_m == free.planet_ring_offset_m
    assert lumped.planet_offset_m == ()
    offsets = np.array(free.planet_offset_m)
    assert offsets.shape == (2, 3)
    assert 0 < np.abs(offsets).max() <= 1e-12
    assert len(set(offsets.ravel())) == 6


def test_pairs_of_samples_say_what_they_are():
    weaker = verdict.PlanetsComparison(
        CELL, third(*[400.0] * 8), third(*[20.0] * 8), PValues(0.01, 0.01)
    )
    assert weaker.effect == verdict.PlanetsEffect.WEAKER
    assert verdict.count_effects([weaker])[PRINTED] == {verdict.PlanetsEffect.WEAKER: 1}
    assert set(verdict.count_effects([])) == set(LAWS)


def test_a_statement_about_a_figure_may_rest_on_planets_held_alike():
    limits = limits_above(100.0, "")
    claim = Claim("3.2-99", 14, "", quantity_of(PD, "third"), limits)
    place = Place(PRINTED, CELL.arm, 0.005, "")
    true, false = (Answer(place, (size,) * 16, 16, limits) for size in (200.0, 20.0))
    lost = verdict.ClaimComparison(claim, place, true, false, 0.01)
    assert (lost.survives, lost.changed) == (verdict.Survival.LOST, True)
    assert verdict.ClaimComparison(claim, place, true, true, 1.0).changed is False
    assert lost.free.state == State.NO


def _parted(
    measured: float | None, lumped: float | None, strayed: float | None = None
) -> SymmetryBreaking:
    """The elbow parts; the shoulder does not."""
    times = tuple(0.005 * k for k in range(8))
    flat = tuple(-12.0 for _ in times)
    rising = tuple(-12.0 + k for k in range(8))

    def course(parting: float | None) -> PartingCourse:
        return PartingCourse((flat, rising), (None, parting))

    none = PartingCourse((flat, flat), (None, None))
    courses = course(measured), course(lumped), course(measured)
    return SymmetryBreaking(times, *courses, none, (None, strayed))


def _foretold(found: list[SymmetryBreaking]) -> parting.PartingPrediction:
    return parting._count_predictions("lumped", len(found) + 1, found)


def test_the_first_parting_is_foretold_start_by_start():
    found = [
        _parted(0.1, 0.1 * (1 + BELOW * parting.PREDICTED)),
        _parted(0.1, 0.1),
        _parted(None, None),
    ]
    told = _foretold(found)
    assert (told.starts, told.right, told.all_right, told.strayed) == (2, 2, True, 0)
    late = 0.1 * (1 + ABOVE * parting.PREDICTED)
    worse = _foretold([*found, _parted(0.1, late, 0.1 * BELOW), _parted(0.1, late, 0.1 * ABOVE)])
    assert (worse.right, worse.starts, worse.all_right) == (2, 4, False)
    assert (worse.strayed, worse.right_unless_strayed) == (1, 2)
    assert (told.asked, told.diverged, told.courses_part) == (4, 1, 2)
    assert _foretold([]).all_right is None
    assert replace(told, diverged=2).all_right is True
    assert replace(told, diverged=3).all_right is None
    elbow = parting._summarize_joint(found, 1)
    assert (elbow.parted, elbow.first, elbow.median_s, elbow.lumped_right) == (2, 2, 0.1, 3)
    assert elbow.largest_growth_per_s == pytest.approx(np.log(10) / 0.005)
    shoulder = parting._summarize_joint(found, 0)
    assert (shoulder.parted, shoulder.median_s) == (0, None)


def test_parting_is_measured_where_planets_pass_a_micrometre():
    variant = replace(SHORT, settings=(), duration_s=0.002)
    (parted,) = PartingQuestion((variant,)).answer()
    assert parted is not None
    assert parted.measured.parting_s == parted.by_lumped.parting_s == (None, None)
    assert parted.measured.spread[0][0] == pytest.approx(-12, abs=0.4)
    assert PARTING_SPREAD_M == 1e-6


def test_first_partings_are_those_of_the_run_itself():
    """At the smallest damping planets part within the first tenth of a second."""
    variant = build_pd_variant(Condition(PRINTED, 0.003), 0.08)
    times = FirstPartingQuestion(variant, (1, 2)).answer()
    run = PhysicalModel(*replace(variant, seed=2).case()).simulate()
    spread = np.ptp(run["x_pr"].values, axis=2).max(axis=1)
    assert times[1] == run["time"].values[np.argmax(spread >= PARTING_SPREAD_M)]
    assert FirstPartingQuestion(build_pd_variant(CELL, 0.002), (1,)).answer() == [None]
