"""The checks that planted faults must turn red: what each says of a model as it stands."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache

from crosscheck.checks.trajectories import Pair
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import Model
from crosscheck.models.loading import Case, load_arm
from crosscheck.planning.plan import nudged
from crosscheck.registry import MODELS, build
from tests.faults.planting import Laws, Seen
from tests.judged import compare_states, energy_over_run, invariants, same_step

STATES, SEED = 5, 0
DRIVES = {
    "pd": {
        "kind": "pd",
        "target_rad": [0.5, -0.3, 0.2],
        "proportional_N_m_per_rad": [1000.0, 800.0, 500.0],
        "derivative_N_m_s_per_rad": [400.0, 300.0, 60.0],
    },
    "sinusoid": {
        "kind": "sinusoid",
        "amplitude_N_m": [200.0, 150.0, 40.0],
        "rate_rad_per_s": [50.0, 70.0, 90.0],
        "argument": "time",
    },
    "root": {
        "kind": "sinusoid",
        "amplitude_N_m": [200.0, 150.0, 40.0],
        "rate_rad_per_s": [50.0, 70.0, 90.0],
        "argument": "sqrt_time",
    },
    "table": {  # of three joints
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
    """200 steps from a start in motion, off centre in every mesh, of up to three joints."""

    def of_joints(fields: Mapping[str, object]) -> dict[str, object]:
        return {k: v[:joints] if isinstance(v, list) else v for k, v in fields.items()}

    return Scenario.model_validate(
        {
            "schema_version": 1,
            "name": "probe",
            "duration_s": 2e-3,
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
    return Pair(*(build(name, *of).simulate() for of in (case, nudged(case))))


def _states(seen: Seen) -> str:
    """The answers of two models at random states."""
    at = seen.arm, seen.drive, seen.laws
    both = {
        seen.model: build(seen.model, *experiment(*at)),
        seen.against: unharmed(seen.against, *at),
    }
    models = [both[name] for name in MODELS if name in both]  # as in a cross-check
    (finding,) = compare_states("planted", models, [seen.quantity], STATES, SEED)
    return finding.verdict


def _same_step(seen: Seen) -> str:
    """Runs of two models in the same steps."""
    at = seen.arm, seen.drive, seen.laws
    case, pair = experiment(*at), unharmed_runs(seen.against, *at)
    run = build(seen.model, *case).simulate()
    (finding,) = same_step("planted", case, run, pair.run, pair, [seen.quantity])
    return finding.verdict


def _energy(seen: Seen) -> str:
    """Energy against work, over a run."""
    model = build(seen.model, *experiment(seen.arm, seen.drive, seen.laws))
    (finding,) = energy_over_run("planted", model.reference(1e-10))
    return finding.verdict


def _power(seen: Seen) -> str:
    """Power against the rate of the kinetic energy, at random states."""
    model = build(seen.model, *experiment(seen.arm, seen.drive, seen.laws))
    findings = invariants("planted", [model], STATES, SEED)
    (verdict,) = (finding.verdict for finding in findings if finding.quantity == "power")
    return verdict


CHECKS: dict[str, Callable[[Seen], str]] = {
    "states": _states,
    "same-step": _same_step,
    "energy": _energy,
    "power": _power,
}
