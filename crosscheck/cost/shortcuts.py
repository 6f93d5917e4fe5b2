"""Costs of a robot's shortcuts: torques along a motion, the end effector, and the reasons."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crosscheck.analytic.robot.springs import stage_rotors
from crosscheck.checks.robot_states import sample_states
from crosscheck.cost.meshes import GearedCost, compute_geared_cost, motor_torques, tip_distances
from crosscheck.cost.motion import (
    RobotMotion,
    State,
    find_exceeded_limits,
    make_excitation,
    release_passive,
)
from crosscheck.findings import Finding
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot, Rotor
from crosscheck.planning.robots import compare_engines
from crosscheck.registry import build_robot_model, reference_engine
from crosscheck.runner.progress_update import ProgressCallback

SHORTCUTS: tuple[Level, ...] = ("links", "armature")
NEGLIGIBLE = 0.01  # largest negligible cost, over a joint's largest torque
# Factors on all ratios: coupling that is negligible at the least is so at any, and none is larger
# than the most, as of a joint without any torque.
LEAST_FACTOR, MOST_FACTOR = 1e-4, 1e4


@dataclass(frozen=True)
class SamplingPlan:
    """The amount to compute: random states, instants of the motion, runs, their steps per second.

    most_steps: largest number of steps per second for which a run with meshes is made.
    """

    states: int
    instants: int
    runs: int
    steps: int
    most_steps: int


FULL, QUICK = SamplingPlan(100, 2000, 8, 250, 2500), SamplingPlan(20, 400, 2, 100, 1000)


@dataclass(frozen=True)
class TorqueCost:
    """A shortcut's torque error in one joint [N m or N]: largest, rms, share of largest torque."""

    joint: str
    level: Level
    largest: float
    rms: float
    share: float


@dataclass(frozen=True)
class TipCost:
    """Distances [m] of the end effector from the plan after a second of feed-forward, run by run.

    Infinite where the run diverged.
    """

    level: Level
    distances: np.ndarray


@dataclass(frozen=True)
class CoupledPair:
    """Rms torque [N m or N] that joint `at` needs, by coupling, for the acceleration of joint `by`.

    share: of the largest torque of joint `at`.
    """

    at: str
    by: str
    rms: float
    share: float


@dataclass(frozen=True)
class RotorShare:
    """The largest share that a gear's coupling alone has of any joint's largest torque.

    The gear is a rotor, or a stage's sun and planets. at: that joint; enough: the magnitude of the
    ratio above which the share is below NEGLIGIBLE, at the same reflected inertia.
    """

    joint: str
    ratio: float
    at: str
    share: float
    enough: float


@dataclass(frozen=True)
class ShortcutCosts:
    """Costs of the shortcuts of a robot along a motion.

    beyond: a line for each limit of the robot that the motion exceeds; n: of joints with a motor;
    time (instants,) [s]; torques (instants, n) of the coupled level, N m or N; errors: by shortcut,
    of the same shape; largest (n,): of the torques; by_rates (n,): rms of the coupling torque due
    to rates alone; factor: scale of all ratios at which the coupling is below NEGLIGIBLE in every
    joint; geared: None if no rotor has a mesh, or if planets move independently.
    """

    robot: Robot
    seed: int
    extent: SamplingPlan
    motion: RobotMotion
    beyond: tuple[str, ...]
    agreement: tuple[Finding, ...]
    time: np.ndarray
    torques: np.ndarray
    errors: dict[Level, np.ndarray]
    by_joint: tuple[TorqueCost, ...]
    tips: tuple[TipCost, ...]
    pairs: tuple[CoupledPair, ...]
    by_rates: np.ndarray
    ratios: tuple[RotorShare, ...]
    factor: float
    geared: GearedCost | None

    @property
    def joints(self) -> tuple[int, ...]:
        """Numbers of the joints whose torques are judged: free ones that have a motor."""
        return tuple(self.robot.coordinates[place] for place in self.robot.motors)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of these joints."""
        return tuple(self.robot.joints[number].name for number in self.joints)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each joint's torque or force: N m or N."""
        turns = [self.robot.joints[number].kind == "revolute" for number in self.joints]
        return tuple("N m" if each else "N" for each in turns)

    @property
    def largest(self) -> np.ndarray:
        """The largest torque of each joint along the motion, shape (n,) [N m or N]."""
        return np.abs(self.torques).max(axis=0)

    @property
    def agrees(self) -> bool:
        """Whether all engines agree on everything."""
        return all(each.verdict == "agree" for each in self.agreement)


def compute_costs(
    robot: Robot,
    seed: int,
    extent: SamplingPlan,
    progress: ProgressCallback,
    given: RobotMotion | None = None,
) -> ShortcutCosts:
    """Compute a robot's shortcut costs by the project's derivation, after a check of all engines.

    seed: of the random states, and of the motion if none is given.
    """
    progress("comparing the engines", 0, 4)
    agreement = compare_engines(robot, sample_states(robot, extent.states, seed))
    progress("moving the robot", 1, 4)
    exact = build_robot_model(reference_engine(), robot, "coupled")
    motion, motors = given or release_passive(exact, make_excitation(exact, seed)), robot.motors
    time = motion.instants(extent.instants)
    state = motion.at(time)
    torques = exact.inverse_dynamics(*state)[:, motors]
    shortcuts = {level: build_robot_model(reference_engine(), robot, level) for level in SHORTCUTS}
    errors = {
        level: model.inverse_dynamics(*state)[:, motors] - torques
        for level, model in shortcuts.items()
    }
    largest = np.abs(torques).max(axis=0)
    names = [robot.coordinate_names[place] for place in motors]
    progress("running feed-forward", 2, 4)
    tips = _compute_tip_costs(exact, shortcuts, motion, extent)
    progress("varying the ratios", 3, 4)
    ratios, factor = _compute_rotor_shares(robot, state, largest, names)
    coupling = exact.mass_matrix(state[0]) - shortcuts["armature"].mass_matrix(state[0])
    coupling = coupling[:, motors][:, :, motors]
    by_rates = (exact.bias(*state[:2]) - shortcuts["armature"].bias(*state[:2]))[:, motors]
    geared = None
    if "geared" in robot.levels and not any(stage.has_free_planets for stage in robot.stages):
        model = build_robot_model(reference_engine(), robot, "geared")
        sizes = extent.instants, extent.runs, extent.most_steps
        geared = compute_geared_cost(exact, model, motion, *sizes)
    progress("done", 4, 4)
    return ShortcutCosts(
        robot=robot,
        seed=seed,
        extent=extent,
        motion=motion,
        beyond=tuple(find_exceeded_limits(robot, state, torques)),
        agreement=tuple(agreement),
        time=time,
        torques=torques,
        errors=errors,
        by_joint=tuple(
            TorqueCost(name, level, most, float(_rms(error)), _share(most, float(whole)))
            for level, of_level in errors.items()
            for name, error, whole in zip(names, of_level.T, largest, strict=True)
            for most in [float(np.abs(error).max())]
        ),
        tips=tuple(tips),
        pairs=tuple(_find_coupled_pairs(coupling, state[2][:, motors], largest, names)),
        by_rates=_rms(by_rates),
        ratios=tuple(ratios),
        factor=factor,
        geared=geared,
    )


def _rms(values: np.ndarray) -> np.ndarray:
    """Root mean square over the first axis."""
    return np.sqrt((values**2).mean(axis=0))


def _share(part: float, whole: float) -> float:
    """The ratio of part to whole, 0 where both are 0."""
    return part / whole if part else 0.0


def _find_coupled_pairs(
    coupling: np.ndarray, a: np.ndarray, largest: np.ndarray, names: list[str]
) -> list[CoupledPair]:
    """Pairs of coupled joints, the largest share first."""
    rms = _rms(coupling * a[:, None, :]).tolist()
    pairs = [
        CoupledPair(at, by, rms[i][j], _share(rms[i][j], float(largest[i])))
        for i, at in enumerate(names)
        for j, by in enumerate(names)
        if i != j and rms[i][j] > 0
    ]
    return sorted(pairs, key=lambda pair: -pair.share)


def _compute_rotor_shares(
    robot: Robot, state: State, largest: np.ndarray, names: list[str]
) -> tuple[list[RotorShare], float]:
    """Cost of each gear's coupling alone; the factor on all ratios that makes it negligible.

    With ratio k N and inertia J / k^2 the diagonal term stays the same, terms linear in the rotor's
    own spin scale with 1 / k, and all others with 1 / k^2: k = 1 and k = -1 give both.
    """

    def coupling(rotors: tuple[Rotor, ...], sign: int) -> np.ndarray:
        turned = tuple(replace(rotor, ratio=sign * rotor.ratio) for rotor in rotors)
        alone = replace(robot, rotors=turned, stages=())
        models = (
            build_robot_model(reference_engine(), alone, "coupled"),
            build_robot_model(reference_engine(), alone, "armature"),
        )
        exact, short = (model.inverse_dynamics(*state)[:, robot.motors] for model in models)
        return (exact - short) / np.maximum(largest, 1e-300)

    rotor_shares, linear, square = [], *np.zeros((2, len(state[0]), len(names)))
    gears = [*((rotor,) for rotor in robot.rotors), *(stage_rotors(robot, s) for s in robot.stages)]
    for rotors in gears:
        rotor, up, down = rotors[0], coupling(rotors, 1), coupling(rotors, -1)
        shares = np.abs(up).max(axis=0)
        linear, square = linear + (up - down) / 2, square + (up + down) / 2
        at = int(shares.argmax())
        enough = abs(rotor.ratio) * _negligible_factor((up - down) / 2, (up + down) / 2)
        name = robot.joints[rotor.joint].name
        rotor_shares.append(RotorShare(name, rotor.ratio, names[at], float(shares[at]), enough))
    return rotor_shares, _negligible_factor(linear, square)


def _negligible_factor(linear: np.ndarray, square: np.ndarray) -> float:
    """The least factor k beyond which |linear / k + square / k^2| stays below NEGLIGIBLE.

    It is the largest root of NEGLIGIBLE k^2 = linear k + square, and of the same with a minus
    sign; 0 where it is below LEAST_FACTOR.
    """
    linear, square = np.clip([linear, square], -1e100, 1e100)  # whose squares do not overflow
    factor = 0.0
    for sign in (1, -1):
        under_root = linear**2 + sign * 4 * NEGLIGIBLE * square
        roots = sign * linear + np.sqrt(np.maximum(under_root, 0.0))
        factor = max(factor, roots[under_root >= 0].max(initial=0.0) / (2 * NEGLIGIBLE))
    return float(min(factor, MOST_FACTOR)) if factor >= LEAST_FACTOR else 0.0


def _compute_tip_costs(
    exact: RobotModel, shortcuts: dict[Level, RobotModel], motion: RobotMotion, extent: SamplingPlan
) -> list[TipCost]:
    """The end effector's distances after a second under each level's torques, from several starts.

    The coupled level's own distance is the integration error.
    """
    starts = motion.instants(extent.runs, before_end=1.0)
    models = {**shortcuts, "coupled": exact}

    def torques(after: float) -> np.ndarray:
        planned = motion.at(starts + after)
        return np.concatenate([motor_torques(model, planned) for model in models.values()])

    q, v, _ = motion.at(np.tile(starts, len(models)))
    ends, _ = integrate(exact, q, v, torques, 1.0, extent.steps)
    planned = np.tile(exact.tip(motion.at(starts + 1.0)[0]), (len(models), 1))
    parts = tip_distances(exact, ends, planned).reshape(len(models), extent.runs)
    return [TipCost(level, part) for level, part in zip(models, parts, strict=True)]
