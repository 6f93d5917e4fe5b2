"""The checks that planted faults must turn red: what each says of a model as it stands."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache

import numpy as np
import xarray as xr

from crosscheck.checks.trajectories import Pair
from crosscheck.cost.shortcuts import ShortcutCosts
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.exudyn.bodies import contact
from crosscheck.models.exudyn.bodies.bodies import ExudynBodies
from crosscheck.models.interface import Model
from crosscheck.models.loading import Case, load_arm, load_case
from crosscheck.models.pinocchio.arm import PinocchioGears
from crosscheck.planning.plan import perturb_start_by_one_ulp
from crosscheck.registry import MODELS, build
from tests import judged, planet_laws
from tests.engines import judge_limits, precise_steps
from tests.engines.bodies_checks import joint_gaps, wrenches
from tests.faults.bits import fused_as_written, same_bits
from tests.faults.measured import numbers_agree
from tests.faults.planting import Laws, Seen, judge_guard
from tests.faults.robots import robots_agree, traced_is_kanes
from tests.faults.views import VIEW_PROBLEMS
from tests.mixed_arms import MIXED, random_states, scenario
from tests.robots import cost_guard, cost_judge, cost_views
from tests.studies.observed import wrong_signals
from tests.studies.plot_numbers import wrong_drawings
from tests.trial import trial_views
from tests.views.views import judge_views

STATES, SEED = 5, 0
SINE = {
    "kind": "sinusoid",
    "amplitude_N_m": [200.0, 150.0, 40.0],
    "rate_rad_per_s": [50.0, 70.0, 90.0],
}
DRIVES = {  # of three joints
    "pd": {
        "kind": "pd",
        "target_rad": [0.5, -0.3, 0.2],
        "proportional_N_m_per_rad": [1000.0, 800.0, 500.0],
        "derivative_N_m_s_per_rad": [400.0, 300.0, 60.0],
    },
    "sinusoid": {**SINE, "argument": "time"},
    "root": {**SINE, "argument": "sqrt_time"},
    "table": {
        "kind": "table",
        "time_s": [0.0, 0.7e-3, 2e-3],
        "torque_N_m": [[0.0, 300.0, -200.0], [100.0, -100.0, 400.0], [30.0, 0.0, -50.0]],
    },
}
START = {
    "theta_rad": [0.3, -0.8, 0.5],
    "theta_dot_rad_per_s": [0.6, -0.9, 0.7],
    "sun_planet_offset_m": [2e-6, 5e-6, 1e-6],
    "planet_ring_offset_m": [-3e-6, 4e-6, 2e-6],
}


def probe_scenario(drive: str, joints: int = 2) -> Scenario:
    """100 steps from a start in motion, off centre in every mesh, of up to three joints."""

    def of_joints(fields: Mapping[str, object]) -> dict[str, object]:
        return {k: v[:joints] if isinstance(v, list) else v for k, v in fields.items()}

    return Scenario.model_validate(
        {
            "schema_version": 1,
            "name": "probe",
            "duration_s": 1e-3,
            "step_s": 1e-5,
            "record_every": 10,
            "start": of_joints(START),
            "drive": of_joints(DRIVES[drive]),
        }
    )


@lru_cache
def experiment(arm: str, drive: str, laws: Laws) -> Case:
    """An arm, moving and driven; on ``probe`` no two numbers that a fault might confuse are equal.

    Switches that are not named are the arm's usual ones.
    """
    own = load_arm(arm)
    return Case(own, probe_scenario(drive, len(own.joints)), usual_switches(own, **dict(laws)))


@lru_cache
def unharmed(name: str, arm: str, drive: str, laws: Laws) -> Model:
    """A model that is never harmed."""
    return build(name, *experiment(arm, drive, laws))


@lru_cache
def unharmed_runs(name: str, arm: str, drive: str, laws: Laws) -> Pair:
    """A run, and that from a start one rounding away."""
    case = experiment(arm, drive, laws)
    return Pair(*(build(name, *of).simulate() for of in (case, perturb_start_by_one_ulp(case))))


def _states(seen: Seen) -> str:
    """The answers of two models at random states."""
    (finding,) = judged.compare_states("planted", _pair(seen), [seen.quantity], STATES, SEED)
    return finding.verdict


def _pair(seen: Seen) -> list[Model]:
    at = seen.arm, seen.drive, seen.laws
    both = {
        seen.model: build(seen.model, *experiment(*at)),
        seen.against: unharmed(seen.against, *at),
    }
    return [both[name] for name in MODELS if name in both]  # as in a cross-check


def _same_step(seen: Seen) -> str:
    """Runs of two models in the same steps."""
    at = seen.arm, seen.drive, seen.laws
    case, pair = experiment(*at), unharmed_runs(seen.against, *at)
    run = build(seen.model, *case).simulate()
    (finding,) = judged.same_step("planted", case, run, pair.run, pair, [seen.quantity])
    return finding.verdict


def _energy(seen: Seen) -> str:
    """Energy against work, over a run."""
    model = build(seen.model, *experiment(seen.arm, seen.drive, seen.laws))
    (finding,) = judged.energy_over_run("planted", model.reference(1e-10))
    return finding.verdict


def _power(seen: Seen) -> str:
    """Power against the rate of the kinetic energy, at random states."""
    model = build(seen.model, *experiment(seen.arm, seen.drive, seen.laws))
    findings = judged.invariants("planted", [model], STATES, SEED)
    (verdict,) = (finding.verdict for finding in findings if finding.quantity == "power")
    return verdict


def _refined(seen: Seen) -> str:
    """Runs of two models, each also in twice the step; 0.2 ms from the start in motion."""
    at = seen.arm, seen.drive, seen.laws
    harmed = tuple(build(seen.model, *_short(at, step)).simulate() for step in STEPS_S)
    (finding,) = judged.refined(
        "planted", _short(at, STEPS_S[0]), harmed, short_runs(seen.against, at), [seen.quantity]
    )
    return finding.verdict


STEPS_S = 1e-6, 2e-6


@lru_cache
def short_runs(name: str, at: tuple[str, str, Laws]) -> tuple[xr.Dataset, ...]:
    """Of a model that is never harmed."""
    return tuple(build(name, *_short(at, step)).simulate() for step in STEPS_S)


def _short(at: tuple[str, str, Laws], step_s: float) -> Case:
    grid = {"duration_s": 2e-4, "step_s": step_s, "record_every": round(2e-5 / step_s)}
    case = experiment(*at)
    return case._replace(scenario=case.scenario.model_copy(update=grid))


def _joints(seen: Seen) -> str:
    """Joints between bodies that stay closed."""
    return joint_gaps(_at_rest(seen)).verdict


def _wrenches(seen: Seen) -> str:
    """What the teeth do to every body."""
    model = _at_rest(seen)
    return wrenches(model, PinocchioGears(model.arm, model.scenario, model.switches)).verdict


def _at_rest(seen: Seen) -> ExudynBodies:
    """Its motors."""
    case = experiment(seen.arm, seen.drive, seen.laws)
    settings = ("scenario.drive.torque_N_m=0.0",)
    still = load_case("paper-labelled", "constant-torque", {}, settings).scenario
    return ExudynBodies(case.arm, still, case.switches)


def _tiers(seen: Seen) -> str:
    """Exudyn's two models at states of mixed arms, over the largest entry."""
    off = 0.0
    for name in MIXED:
        pairs = zip(
            _tier_answers(seen.model, name, seen.quantity),
            unharmed_answers(seen.against, name, seen.quantity),
            strict=True,
        )
        off = max(off, *(float(abs(one - other).max() / abs(one).max()) for one, other in pairs))
        if off > 1e-8:
            break
    # Deflections near 1e-4 m out of places near 1 m.
    return _judged(off, 1e-11, 1e-8)


def _tier_answers(name: str, arm: str, quantity: str) -> Iterator[np.ndarray]:
    model = build(name, MIXED[arm], scenario([30.0, -20.0, 10.0][: len(MIXED[arm].joints)]))
    for q, v in random_states(model.layout, 3):
        yield getattr(model, quantity)(*((q,) if quantity == "mass_matrix" else (0.1, q, v)))


@lru_cache
def unharmed_answers(name: str, arm: str, quantity: str) -> list[np.ndarray]:
    """Of a model that is never harmed."""
    return list(_tier_answers(name, arm, quantity))


def _judged(off: float, rounding: float, seen: float) -> str:
    return "agree" if off < rounding else "differ" if off > seen else "unclear"


def _planets(seen: Seen) -> str:
    """What single planets must do, from first principles."""
    arm = planet_laws.ARMS[seen.arm]()
    run = scenario(
        duration_s=3e-6, record_every=1, start=planet_laws.OFFSETS if seen.arm == UNLIKE else {}
    )
    model = build(seen.model, arm, run, usual_switches(arm, **dict(seen.laws)))
    measure, *limits = PLANETS[seen.quantity]
    return _judged(measure(model), *limits)


def _reactions_off(model: ExudynBodies) -> float:
    """Torque that a mesh leaves over, of its forces: action and reaction, wherever bodies are."""
    draw, off = np.random.default_rng(5), 0.0
    for toothed in (of for sides in model.meshes for side in sides for of in side):
        pose, velocity = draw.normal(size=(2, 3 * len(toothed.bodies)))
        found = contact.mesh_forces(toothed.mesh, 0.2, pose, velocity).reshape(-1, 3)
        x, y = pose.reshape(-1, 3)[:, :2].T
        turning = x * found[:, 1] - y * found[:, 0] + found[:, 2]
        off = max(off, float(abs(turning.sum()) / abs(found).max()))
    return off


UNLIKE = "unlike planets"
# How far a model is off, what of it is rounding, and from where on it is a fault.
PLANETS = {
    "force": (planet_laws.force_off, 1e-11, 1e-6),
    "motion": (planet_laws.motion_off, 1e-10, 1e-6),
    "in step": (planet_laws.in_step_off, 1e-10, 1e-6),
    "start": (planet_laws.start_off, 1e-16, 1e-9),  # [m]
    "records": (planet_laws.records_off, 1e-10, 1e-6),
    "modes": (planet_laws.modes_off, 1e-6, 1e-4),  # the engine differentiates by differences
    "reactions": (_reactions_off, 1e-13, 1e-6),  # arms of a few metres
}


def _ask_guard(seen: Seen) -> str:
    """A guard of the check by the quantity, which lists what is wrong."""
    return judge_guard(GUARDS[seen.check][seen.quantity](seen.arm))


@lru_cache
def _right_cost(name: str) -> ShortcutCosts:
    """Worked out before any fault is planted; views show it."""
    return cost_guard.found_cost(name, engines=True)


def _wrong_motions(name: str) -> Iterator[str]:
    for seed in range(2):
        yield from cost_guard.wrong_motion(cost_guard.robot(name), seed)


Guard = Callable[[str], Iterable[str]]  # of the arm or robot that a fault is seen on


def _of_none(guards: Mapping[str, Callable[[], Iterable[str]]]) -> dict[str, Guard]:
    """Guards that have arms and robots of their own."""
    return {name: lambda _, guard=guard: guard() for name, guard in guards.items()}


GUARDS: dict[str, Mapping[str, Guard]] = {
    "cost": {
        "numbers": lambda name: cost_guard.wrong_numbers(name, cost_guard.found_cost(name, runs=0)),
        "runs": lambda name: cost_guard.wrong_numbers(name, cost_guard.found_cost(name)),
        "tip": cost_guard.wrong_tip,
        "motion": _wrong_motions,
        "picture": lambda name: cost_views.wrong_picture(_right_cost(name)),
        "limits": lambda _: cost_guard.wrong_limits(),
        "states": lambda _: cost_guard.wrong_states(),
        "given motion": lambda _: cost_guard.wrong_given(),
        "steps": lambda _: cost_guard.wrong_steps(),
        "verdicts": lambda _: cost_judge.wrong_verdicts(),
        "condition": lambda _: cost_judge.wrong_condition(),
    },
    "judge": _of_none(judge_limits.GUARDS),
    "precise steps": {
        "": lambda _: precise_steps.wrong_steps(),
        "impacts": lambda _: precise_steps.wrong_impacts(),
        "works": lambda _: precise_steps.wrong_works(),
    },
    "trial": _of_none(trial_views.GUARDS),
    "study signals": {"": lambda _: wrong_signals()},
    "study drawings": {"": lambda _: wrong_drawings()},
    "view": _of_none(VIEW_PROBLEMS),
}
CHECKS: dict[str, Callable[[Seen], str]] = {
    "states": _states,
    "corners": lambda seen: judged.compare_corners("planted", _pair(seen), STATES, SEED)[0].verdict,
    "same-step": _same_step,
    "energy": _energy,
    "power": _power,
    "refined": _refined,
    "joints": _joints,
    "wrenches": _wrenches,
    "tiers": _tiers,
    "planets": _planets,
    "bits": same_bits,
    "fused": fused_as_written,
    "robots": robots_agree,
    "traced": traced_is_kanes,
    "measured": numbers_agree,
    "text": judge_views,
    **dict.fromkeys(GUARDS, _ask_guard),
}
# These need compiled functions, or have none.
COMPILED = {*GUARDS, "refined", "bits", "fused", "robots", "traced", "measured", "text"} - {
    "precise steps"
}
