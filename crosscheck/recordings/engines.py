"""Whether the engines agree on the torques of a recorded motion; without that nothing is judged."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crosscheck.checks.first_principles.christoffel import christoffel_force
from crosscheck.checks.first_principles.composite import arm_pose, build_parts, inertia, weight
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.interface import Model
from crosscheck.planning.sizing import make_rest_scenario
from crosscheck.registry import RIGID_LEVELS, build, find_covering_models, find_level_models
from crosscheck.runner.progress_update import CountCallback

# Of the sum of the sizes of a torque's terms, times the arm's reach over its shortest link: engines
# sum the same terms in another order, and a short link's are small beside those that pass it. 300
# random arms were 1.5e-15 apart at most, 40 with a first link of a thousand lengths 1.5e-13.
ROUNDINGS = 1000 * float(np.finfo(float).eps)
# First principles take differences of mass matrices in place of their slopes.
WITNESS_TOLERANCE = 1e-10
REFERENCE = "analytic"
Motion = tuple[np.ndarray, np.ndarray, np.ndarray]  # angles, rates, accelerations (rows, joints)


@dataclass(frozen=True)
class EngineDeviation:
    """How far an engine's torques are from the analytic ones along the whole record.

    measured: the largest difference in any joint, over the sum of the sizes of its torque's terms;
    infinite where the engine failed, and failure says how. alone: those of the two models whose
    torques differ from first principles where they differ most from each other.
    """

    name: str
    level: str
    rows: int
    measured: float
    tolerance: float
    failure: str = ""
    alone: tuple[str, ...] = ()

    @property
    def agrees(self) -> bool:
        """Whether the difference is within the tolerance; never where it is no number."""
        return self.measured <= self.tolerance


def build_rigid_model(level: str, arm: Arm, engine: str = REFERENCE) -> Model:
    """The model in an experiment without a drive: its inverse dynamics ask for motors' torques."""
    return build(f"{engine}:{level}", arm, make_rest_scenario())


def compare_engines(motion: Motion, arm: Arm, progress: CountCallback) -> list[EngineDeviation]:
    """The difference of every engine from the analytic model, level by level, at every row."""
    differences, rows = [], len(motion[0])
    lengths = [link.length_m for link in arm.links]
    tolerance = ROUNDINGS * sum(lengths) / min(lengths)
    able = set(find_covering_models("rigid", arm, usual_switches(arm)))
    for level in RIGID_LEVELS:
        reference = build_rigid_model(level, arm)
        torques = reference.inverse_dynamics(*motion)
        sizes = _term_sizes(reference, motion)
        for name in find_level_models(level):
            if name == reference.name or name not in able:
                continue
            progress(f"asking {name}", 0, rows)
            try:
                other = _compute_torques(build(name, arm, make_rest_scenario()), motion)
            except Exception as error:  # whatever an engine raises, it has not agreed
                failure = f"{type(error).__name__}: {error}"
                differences.append(EngineDeviation(name, level, rows, np.inf, tolerance, failure))
                continue
            shares = _shares(np.abs(other - torques), sizes)
            row = int(np.argmax(shares.max(axis=1)))
            difference = EngineDeviation(name, level, rows, float(shares.max()), tolerance)
            if not difference.agrees:
                given = {reference.name: torques[row], name: other[row]}
                alone = _find_disagreeing_models(given, arm, level, [part[row] for part in motion])
                difference = replace(difference, alone=alone)
            differences.append(difference)
    return differences


def _compute_torques(model: Model, motion: Motion) -> np.ndarray:
    """An engine's torques (rows, joints) [N m]. Raises ValueError where they are no such table."""
    torques = np.asarray(model.inverse_dynamics(*motion))
    if torques.shape != motion[0].shape or torques.dtype.kind != "f":
        raise ValueError(f"torques have shape {torques.shape}, must be {motion[0].shape} numbers")
    return torques


def _term_sizes(model: Model, motion: Motion) -> np.ndarray:
    """Largest sum over the rows of a torque's terms in size, weights, rates and accelerations."""
    angles, rates, accelerations = motion
    still = np.zeros_like(rates)
    weights = model.inverse_dynamics(angles, still, still)
    sizes = np.abs(weights) + np.abs(model.inverse_dynamics(angles, rates, still) - weights)
    for joint in range(angles.shape[1]):
        single = still.copy()
        single[:, joint] = accelerations[:, joint]
        sizes += np.abs(model.inverse_dynamics(angles, still, single) - weights)
    return np.asarray(sizes.max(axis=0))


def _shares(differences: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Differences over sizes; 0 for none, infinite where there is no size or no number."""
    shares = np.full(differences.shape, np.inf)
    np.divide(differences, sizes, out=shares, where=sizes > 0)
    return np.where(differences == 0, 0.0, np.where(np.isfinite(shares), shares, np.inf))


def _find_disagreeing_models(
    torques: dict[str, np.ndarray], arm: Arm, level: str, state: list[np.ndarray]
) -> tuple[str, ...]:
    """Names of the models whose torques (joints,) at a state differ from first principles."""
    angles, rates, accelerations = state
    content = arm.model_dump(mode="json")
    parts = build_parts(content, level)

    def mass_matrix(at: np.ndarray) -> np.ndarray:
        return inertia(parts, arm_pose(content, at), locked=False)

    friction = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])
    terms = (
        mass_matrix(angles) * accelerations,
        christoffel_force(mass_matrix, angles, rates, np.ones(len(angles), dtype=bool))[:, None],
        -weight(parts, arm_pose(content, angles), content)[:, None],
        (friction * rates)[:, None],
    )
    every = np.hstack(terms)
    expected, sizes = every.sum(axis=1), np.abs(every).sum(axis=1)
    return tuple(
        name
        for name, model_torques in torques.items()
        if not _shares(np.abs(model_torques - expected), sizes).max() <= WITNESS_TOLERANCE
    )
