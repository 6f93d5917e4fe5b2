"""Evidence 6: one stage under `angle`, run up through its mesh modes; Floquet theory of k_a."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crosscheck import signals
from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.question import Answer, Question, Records
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.measures.stage import set_constant_stiffness
from crosscheck.audit.measures.undefined import float_or_none
from crosscheck.audit.phase.linear import linear_step
from crosscheck.audit.phase.runs import (
    RIGID_STEP_S,
    Plant,
    build_plant,
    simulate_motion,
    simulate_rigid_arm,
)
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import ConstantDrive
from crosscheck.models.loading import Case, load_case
from crosscheck.signals import envelope
from crosscheck.studies.members.starts import perturb_start

FASTEST_RAD_PER_S, RAMP_S = 330.0, 2.0  # the highest mode is met at some 290 rad/s
RAMP_ZETAS = (0.005, 0.02)
ZETAS = (0.003, 0.005, 0.007, 0.02, 0.05)  # of the tongues
SPEEDS = np.linspace(15.0, 600.0, 400)  # rad/s
STEP_S = 5e-6  # RK4's own damping of the highest mode stays below 0.1 1/s
EVERY = 5  # steps of the run-up
STARTS = 8  # a block of the kernel
BINS = 900  # of what is kept of a run-up, for its drawing
BELOW_RAD_PER_S = (20.0, 60.0)  # slower than any resonance
FAR = 5.0  # times the fastest speed
TONGUE_PER_S = 1.0  # growth that counts


@dataclass(frozen=True)
class StageModes:
    """Mesh modes [Hz] of one stage, its carrier locked, ascending; teeth: mesh cycles per turn."""

    modes_Hz: tuple[float, ...]
    teeth: float

    @property
    def speeds(self) -> tuple[float, ...]:
        """Carrier speeds [rad/s] at which teeth pass at the frequency of each mode."""
        return tuple(2 * np.pi * mode / self.teeth for mode in self.modes_Hz)


class Peak(NamedTuple):
    """The largest vibration [rad/s^2] near a speed, and at which [rad/s]; None: not that fast."""

    speed: float | None
    size: float | None


@dataclass(frozen=True)
class RunUpResult:
    """What run-ups of several starts show: of each a peak per mode, and the vibration below them.

    below: [rad/s^2] of every start; drawn_speed [rad/s], drawn_size [rad/s^2]: the first start's
    largest vibration of every bin.
    """

    peaks: tuple[tuple[Peak, ...], ...]
    below: tuple[float | None, ...]
    drawn_speed: tuple[float, ...]
    drawn_size: tuple[float, ...]


class _StageQuestion(Question[Answer]):
    """A question that is asked of the shoulder's stage at a damping ratio."""

    def records(self) -> Records:
        cases = [load_case("paper-labelled", name) for name in ("constant-torque", "pd")]
        return [record for case in cases for record in case]


@dataclass(frozen=True)
class RunUp(_StageQuestion[RunUpResult]):
    """A question: the stage run up through its modes, or as far as the duration lets it.

    Planets free.
    """

    cost = 2.0

    zeta: float
    duration_s: float
    seeds: tuple[int, ...]

    def answer(self) -> RunUpResult:
        speeds, vibrations = (x.T for x in _run_up(self.zeta, self.duration_s, self.seeds))
        pairs = list(zip(speeds, vibrations, strict=True))
        slow = [size[signals.window(speed, *BELOW_RAD_PER_S)] for speed, size in pairs]
        drawn_speed, drawn_size = np.empty(0), np.empty(0)
        if speeds[0].size >= BINS:
            _, low, high = envelope(*pairs[0], BINS)
            drawn_speed = np.linspace(speeds[0][0], speeds[0][-1], low.size)
            drawn_size = np.maximum(np.abs(low), np.abs(high))
        return RunUpResult(
            peaks=tuple(tuple(_peak(*pair, met) for met in stage_modes().speeds) for pair in pairs),
            below=tuple(float_or_none(signals.amplitude(sizes)) for sizes in slow),
            drawn_speed=tuple(drawn_speed.tolist()),
            drawn_size=tuple(drawn_size.tolist()),
        )


@dataclass(frozen=True)
class FloquetRates:
    """Growth rates [1/s] of a mesh vibration over SPEEDS, and at one slow speed."""

    growth: tuple[float, ...]
    slow: float

    @property
    def largest(self) -> tuple[float, float]:
        """The largest growth [1/s], and at which speed [rad/s]."""
        at = int(np.argmax(self.growth))
        return self.growth[at], float(SPEEDS[at])

    @property
    def lowest_open(self) -> float | None:
        """The lowest speed [rad/s] with growth that counts; None if there is none."""
        open_at = SPEEDS[np.array(self.growth) > TONGUE_PER_S]
        return float(open_at[0]) if open_at.size else None


@dataclass(frozen=True)
class Tongue(_StageQuestion[FloquetRates]):
    """A question: the ``FloquetRates`` at a damping ratio and one slow speed [rad/s]."""

    cost = 1.0

    zeta: float
    slow: float

    def answer(self) -> FloquetRates:
        (slow,) = compute_floquet_growth(self.zeta, np.array([self.slow]))
        return FloquetRates(tuple(compute_floquet_growth(self.zeta, SPEEDS).tolist()), float(slow))


@dataclass(frozen=True)
class Speeds:
    """The rigid arm's fastest joint speed [rad/s] in the paper's scenarios."""

    pd: float
    constant_torque: float
    back_and_forth: float


@dataclass(frozen=True)
class Resonance:
    """Results of run-ups and growth rates by damping ratio, the modes, and the paper's speeds."""

    modes: StageModes
    speeds: Speeds
    run_ups: dict[float, RunUpResult]
    tongues: dict[float, FloquetRates]

    @property
    def supports(self) -> bool:
        """Whether the slowest resonance lies far above the fastest speed of the PD run."""
        return bool(self.modes.speeds[0] > FAR * self.speeds.pd)

    @property
    def lowest_open(self) -> float | None:
        """Lowest speed [rad/s] at which stiffness alone makes a vibration grow; None for none."""
        lowest_speeds = [rates.lowest_open for rates in self.tongues.values()]
        return min((speed for speed in lowest_speeds if speed is not None), default=None)


def run_resonance_test(study: Study, scale: Scale) -> Resonance:
    """Results of run-ups of one stage, Floquet theory of the stiffness, and the paper's speeds."""
    speeds = Speeds(
        largest_carrier_speed("pd"),
        largest_carrier_speed("constant-torque"),
        largest_carrier_speed("back-and-forth"),
    )
    seeds = scale.seeds[: scale.limit_starts(STARTS)]
    ramps = {zeta: RunUp(zeta, scale.limit_duration(RAMP_S), seeds) for zeta in RAMP_ZETAS}
    growth = {zeta: Tongue(zeta, speeds.pd) for zeta in ZETAS}
    run_ups = study.answer_by_key(ramps, "phase: run-up")
    return Resonance(stage_modes(), speeds, run_ups, study.answer_by_key(growth, "phase: tongues"))


def stage_modes() -> StageModes:
    """The mesh modes of the labelled arm's shoulder; its damping is excluded."""
    plant = build_plant(_model(_single_stage_arm(RAMP_ZETAS[0]), 0.0, 1.0))
    mass, stiffness = _mass_and_stiffness(plant)
    squares = np.linalg.eigvals(np.linalg.solve(mass, np.diag(stiffness)))
    modes_Hz = np.sort(np.sqrt(squares.real)) / (2 * np.pi)
    return StageModes(tuple(map(float, modes_Hz)), float(plant.gears.rate[0]))


def _single_stage_arm(zeta: float) -> Arm:
    """The labelled arm cut to its shoulder and first link, the payload at the link's end."""
    arm = load_case("paper-labelled", "pd", {}, [f"arm.joints.*.*_mesh.damping_ratio={zeta!r}"]).arm
    return arm.model_copy(update={"joints": arm.joints[:1], "links": arm.links[:1]})


def _model(arm: Arm, torque: float, duration_s: float) -> PhysicalModel:
    scenario = load_case("paper-labelled", "constant-torque").scenario
    drive = ConstantDrive(kind="constant", torque_N_m=torque)
    update = {"drive": drive, "duration_s": duration_s, "record_every": EVERY}
    angle = load_case("paper-labelled", "pd", {"phase": "angle"}).switches
    case = Case(arm, scenario.model_copy(update=update), angle)
    return PhysicalModel(*case)


def _mass_and_stiffness(plant: Plant) -> tuple[np.ndarray, np.ndarray]:
    """M (2, 2) [kg] and N k_m (2,) [N/m] of the mesh displacements, carrier locked."""
    where, n = plant.gears.x_index, plant.weights.shape[1]
    mass = plant.model.mass_matrix(np.zeros(n))
    planets = -plant.terms.mesh_map[where].diagonal()
    return mass[np.ix_(where, where)], planets * plant.gears.k_m


def largest_carrier_speed(scenario: str) -> float:
    """Largest carrier speed against the ring [rad/s] of either joint in a scenario of the paper."""
    case = load_case("paper-labelled", scenario)
    rigid = simulate_rigid_arm(case, RIGID_STEP_S, case.scenario.record_every)
    return float(np.abs(rigid["theta_dot"]).max())


def _run_up(zeta: float, duration_s: float, seeds: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Carrier speed [rad/s] and vibration [rad/s^2], (times, starts), in RAMP_S from rest.

    The torque is constant, so the rigid arm's acceleration is, which is subtracted. Stiffness is
    constant so that tooth error is all that excites: k_a has tongues of its own.
    """
    arm = set_constant_stiffness(_single_stage_arm(zeta))
    still = _model(arm, 0.0, 1.0)
    (theta,) = still.layout.theta
    inertia = float(still.mass_matrix(np.zeros(len(still.layout)))[theta, theta])
    steady = FASTEST_RAD_PER_S / RAMP_S
    lumped = _model(arm, inertia * steady, duration_s)
    switches = lumped.switches.model_copy(update={"planets": "free"})
    case = Case(arm, lumped.scenario, switches)
    run = simulate_motion([PhysicalModel(*perturb_start(case, seed)) for seed in seeds])
    return run.v[:, run.theta[0]], run.shoulder - steady


def compute_floquet_growth(zeta: float, speeds: np.ndarray) -> np.ndarray:
    """Growth rate [1/s] of the mesh vibration at constant carrier speeds [rad/s], (speeds,).

    Floquet theory of M x'' + D x' + N k(phi) x = 0, phi = c theta_c' t, carrier locked to its
    speed: the largest multiplier of the monodromy, (speeds, 4, 4), by RK4 in the phase.
    """
    plant = build_plant(_model(_single_stage_arm(zeta), 0.0, 1.0))
    mass, stiffness = _mass_and_stiffness(plant)
    swing = plant.gears.k_a / plant.gears.k_m
    damped = -np.linalg.solve(mass, np.diag(plant.gears.d))
    sprung, swinging = (-np.linalg.solve(mass, np.diag(k)) for k in (stiffness, stiffness * swing))
    steady = np.block([[np.zeros((2, 2)), np.eye(2)], [sprung, damped]])
    varying = np.block([[np.zeros((2, 4))], [swinging, np.zeros((2, 2))]])
    period = 2 * np.pi / (plant.weights[0, plant.gears.theta[0]] * speeds)
    count = int(np.ceil(period.max() / STEP_S))
    turn, h = 2 * np.pi / count, (period / count)[:, None, None]
    flow = np.repeat(np.eye(4)[None], period.size, axis=0)
    for k in range(count):
        rates = [steady + varying * np.sin((k + part) * turn) for part in (0.0, 0.5, 0.5, 1.0)]
        flow = linear_step(rates, flow, h)
    multipliers = np.linalg.eigvals(flow)
    return np.log(np.abs(multipliers).max(axis=1)) / period


def _peak(speeds: np.ndarray, vibration: np.ndarray, speed: float) -> Peak:
    """The largest vibration within 10 % of a speed [rad/s]."""
    part = slice(*np.searchsorted(speeds, (0.9 * speed, 1.1 * speed)))
    if part.stop <= part.start:
        return Peak(None, None)
    size = np.abs(vibration[part])
    return Peak(float(speeds[part][np.argmax(size)]), float(size.max()))
