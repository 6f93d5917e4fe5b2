"""One stage under `angle`: run up through its mesh modes, and Floquet theory of its stiffness."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np

from analytic import kernel
from analytic.model import PhysicalModel
from crosscheck import signals
from crosscheck.envelope import envelope
from crosscheck.paper.numbers import defined
from crosscheck.paper.phase.experiments import FILTER_EDGE_S, RIGID_STEP_S, STRIDE, vibration
from crosscheck.paper.phase.motion import motion
from crosscheck.paper.phase.plant import Plant, plant_of
from crosscheck.paper.phase.rigid import rigid_motion
from crosscheck.paper.record import JsonObject, Record
from crosscheck.paper.stage import with_steady_stiffness
from models.arm import Arm
from models.loading import Case, load_case
from models.scenario import ConstantDrive
from models.switches import Switches

FASTEST_RAD_PER_S, RAMP_S = 330.0, 2.0  # the highest mode is met at some 290 rad/s
RAMP_ZETAS = (0.005, 0.02)
ZETAS = (0.003, 0.005, 0.007, 0.02, 0.05)  # of the tongues
SPEEDS = np.linspace(15.0, 600.0, 400)  # rad/s
STEP_S = 5e-6  # RK4's own damping of the highest mode stays below 0.1 1/s
BINS = 900  # of what is kept of a run-up, for its drawing


class Ramp(NamedTuple):
    """Carrier speed [rad/s] and vibration [rad/s^2] of the one-stage arm run up, (times,)."""

    speed: np.ndarray
    fast: np.ndarray


@dataclass(frozen=True)
class StageModes(Record):
    """Mesh modes [Hz] of one stage, its carrier locked; teeth: mesh cycles per turn of it."""

    modes_Hz: tuple[float, ...]
    teeth: float

    @property
    def id(self) -> str:
        return "resonance/modes"

    @property
    def speeds(self) -> tuple[float, ...]:
        """Carrier speed [rad/s] at which teeth pass at the frequency of each mode."""
        return tuple(2 * np.pi * mode / self.teeth for mode in self.modes_Hz)


class Peak(NamedTuple):
    """The largest vibration [rad/s^2] near a speed, and at which [rad/s]; None: not that fast."""

    speed: float | None
    size: float | None


@dataclass(frozen=True)
class Resonances:
    """What a run-up shows: a peak per mode, the vibration [rad/s^2] below them, and its drawing.

    drawn_speed [rad/s], drawn_size [rad/s^2]: largest vibration of every bin.
    """

    peaks: tuple[Peak, ...]
    away_rad_per_s2: float | None
    drawn_speed: tuple[float, ...]
    drawn_size: tuple[float, ...]


@dataclass(frozen=True)
class RunUp:
    """The stage run up through both modes at a damping ratio, or as far as the duration lets it."""

    zeta: float
    duration_s: float

    @property
    def inputs(self) -> str:
        return f"{self!r}\n{_files()}"

    @property
    def cost(self) -> float:
        return self.duration_s

    def answer(self) -> JsonObject:
        ramp = _run_up(self.zeta, self.duration_s)
        away = ramp.fast[signals.window(ramp.speed, 20.0, 60.0)]
        speed, size = _drawn(ramp)
        found = Resonances(
            peaks=tuple(_peak(ramp, met) for met in stage_modes().speeds),
            away_rad_per_s2=defined(signals.amplitude(away)),
            drawn_speed=tuple(speed.tolist()),
            drawn_size=tuple(size.tolist()),
        )
        return asdict(found)


@dataclass(frozen=True)
class FloquetRates:
    """Growth [1/s] of a mesh vibration over SPEEDS, and at one slow speed."""

    growth: tuple[float, ...]
    slow: float


@dataclass(frozen=True)
class Tongue:
    """The ``FloquetRates`` at a damping ratio and one slow speed [rad/s]."""

    zeta: float
    slow: float

    @property
    def inputs(self) -> str:
        return f"{self!r}\n{_files()}"

    @property
    def cost(self) -> float:
        return 1.0

    def answer(self) -> JsonObject:
        (slow,) = tongues(self.zeta, np.array([self.slow]))
        return asdict(FloquetRates(tuple(tongues(self.zeta, SPEEDS).tolist()), float(slow)))


def _files() -> str:
    cases = [load_case("paper-labelled", name) for name in ("constant-torque", "pd")]
    return "\n".join(record.model_dump_json() for case in cases for record in case)


def stage_modes() -> StageModes:
    """Of the labelled arm's shoulder; its damping has no say."""
    arm = _one_stage(RAMP_ZETAS[0])
    return StageModes(tuple(map(float, _modes(arm))), _rate(arm))


def _one_stage(zeta: float) -> Arm:
    """Shoulder and first link, the payload at its end."""
    arm = load_case("paper-labelled", "pd", {}, [f"arm.joints.*.damping_ratio={zeta!r}"]).arm
    return arm.model_copy(update={"joints": arm.joints[:1], "links": arm.links[:1]})


def _model(arm: Arm, torque: float, duration_s: float) -> PhysicalModel:
    scenario = load_case("paper-labelled", "constant-torque").scenario
    drive = ConstantDrive(kind="constant", torque_N_m=torque)
    update = {"drive": drive, "duration_s": duration_s, "record_every": STRIDE}
    case = Case(arm, scenario.model_copy(update=update), _angle())
    return PhysicalModel(*case)


def _angle() -> Switches:
    return load_case("paper-labelled", "pd", {"phase": "angle"}).switches


def _rate(arm: Arm) -> float:
    """Mesh cycles per turn of the carrier against the ring: c of the law, 99 here."""
    return float(_model(arm, 0.0, 1.0).gears.rate[0])


def _modes(arm: Arm) -> np.ndarray:
    """Mesh modes [Hz] of one stage with the carrier locked, ascending."""
    plant = plant_of(_model(arm, 0.0, 1.0))
    mass, stiffness = _meshes(plant)
    squares = np.linalg.eigvals(np.linalg.solve(mass, np.diag(stiffness)))
    return np.sort(np.sqrt(squares.real)) / (2 * np.pi)


def _meshes(plant: Plant) -> tuple[np.ndarray, np.ndarray]:
    """(M (2, 2) [kg], N k_m (2,) [N/m]) of the mesh displacements, carrier locked."""
    where, n = plant.gears.where, plant.weights.shape[1]
    mass = np.empty((n, n))
    kernel.mass_matrix(plant.terms, np.zeros(n), mass)
    planets = -plant.terms.mesh_map[where].diagonal()
    return mass[np.ix_(where, where)], planets * plant.gears.k_m


def fastest(scenario: str) -> float:
    """Largest carrier speed against the ring [rad/s] of either joint in a scenario of the paper."""
    case = load_case("paper-labelled", scenario)
    rigid = rigid_motion(case, RIGID_STEP_S, case.scenario.record_every)
    return float(np.abs(rigid["theta_dot"]).max())


def _run_up(zeta: float, duration_s: float) -> Ramp:
    """A constant torque that takes RAMP_S from rest through both modes; stiffness constant.

    So that tooth error is all that excites: k_a has tongues of its own.
    """
    arm = with_steady_stiffness(_one_stage(zeta))
    still = _model(arm, 0.0, 1.0)
    (theta,) = still.layout.theta
    inertia = float(still.mass_matrix(np.zeros(len(still.layout)))[theta, theta])
    model = _model(arm, inertia * FASTEST_RAD_PER_S / RAMP_S, duration_s)
    run = motion(model)
    return Ramp(run.v[:, theta], vibration(run.time, run.a[:, theta]))


def tongues(zeta: float, speeds: np.ndarray) -> np.ndarray:
    """Growth rate [1/s] of the mesh vibration at constant carrier speeds [rad/s], (speeds,).

    Floquet theory of M x'' + D x' + N k(phi) x = 0, phi = c theta_c' t, carrier locked to its
    speed: the largest multiplier of the monodromy.
    """
    plant = plant_of(_model(_one_stage(zeta), 0.0, 1.0))
    mass, stiffness = _meshes(plant)
    swing = plant.gears.k_a / plant.gears.k_m
    damped = -np.linalg.solve(mass, np.diag(plant.gears.d))

    sprung, swinging = (-np.linalg.solve(mass, np.diag(k)) for k in (stiffness, stiffness * swing))
    steady = np.block([[np.zeros((2, 2)), np.eye(2)], [sprung, damped]])
    varying = np.block([[np.zeros((2, 4))], [swinging, np.zeros((2, 2))]])

    def system(phase: float) -> np.ndarray:
        return steady + varying * np.sin(phase)

    period = 2 * np.pi / (plant.weights[0, plant.gears.theta[0]] * speeds)
    multipliers = np.linalg.eigvals(_monodromy(system, period))
    return np.log(np.abs(multipliers).max(axis=1)) / period


def _monodromy(system: Callable[[float], np.ndarray], period: np.ndarray) -> np.ndarray:
    """Of y' = A(2 pi t / T) y over every period T [s], (periods, 4, 4), by RK4 in the phase."""
    count = int(np.ceil(period.max() / STEP_S))
    turn, h = 2 * np.pi / count, (period / count)[:, None, None]
    flow = np.repeat(np.eye(4)[None], period.size, axis=0)
    for k in range(count):
        begin, middle, end = (system((k + part) * turn) for part in (0.0, 0.5, 1.0))
        k_1 = begin @ flow
        k_2 = middle @ (flow + h / 2 * k_1)
        k_3 = middle @ (flow + h / 2 * k_2)
        k_4 = end @ (flow + h * k_3)
        flow = flow + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
    return flow


def _peak(ramp: Ramp, speed: float) -> Peak:
    """Within 10 % of a speed [rad/s]."""
    part = slice(*np.searchsorted(ramp.speed, (0.9 * speed, 1.1 * speed)))
    if part.stop <= part.start:
        return Peak(None, None)
    fast = np.abs(ramp.fast[part])
    return Peak(float(ramp.speed[part][np.argmax(fast)]), float(fast.max()))


def _drawn(ramp: Ramp) -> tuple[np.ndarray, np.ndarray]:
    """Speed [rad/s] and largest vibration [rad/s^2] of every bin."""
    edge = signals.window(ramp.speed, 1.0, FASTEST_RAD_PER_S * (1 - FILTER_EDGE_S))
    if edge.stop <= edge.start:
        return np.empty(0), np.empty(0)
    _, low, high = envelope(ramp.speed[edge], ramp.fast[edge], BINS)
    speed = np.linspace(ramp.speed[edge][0], ramp.speed[edge][-1], low.size)
    return speed, np.maximum(np.abs(low), np.abs(high))
