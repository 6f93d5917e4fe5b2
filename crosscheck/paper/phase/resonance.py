"""Evidence 6: where tooth error would resonate, and where stiffness would open tongues, under
`angle`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from analytic import kernel
from analytic.model import PhysicalModel
from crosscheck.envelope import envelope
from crosscheck.paper import signals
from crosscheck.paper.phase.experiments import FILTER_EDGE_S, STRIDE, vibration
from crosscheck.paper.phase.plant import Plant, accelerations_along, integrate, plant_of
from crosscheck.paper.phase.verdict import FAR, Evidence, is_far
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import defined, shown
from crosscheck.registry import build
from crosscheck.report.figures import legend, log_y, new_figure, to_svg
from crosscheck.report.fragments import COLOURS, figure, heading, paragraph, table
from crosscheck.studies.study import Question, Study
from models.arm import Arm
from models.loading import Case, load_case
from models.scenario import ConstantDrive

FASTEST_RAD_PER_S, RAMP_S = 330.0, 2.0  # the highest mode is met at some 290 rad/s
RAMP_ZETAS = (0.005, 0.02)
ZETAS = (0.003, 0.005, 0.007, 0.02, 0.05)  # of the tongues
SPEEDS = np.linspace(15.0, 600.0, 400)  # rad/s
STEP_S = 5e-6  # RK4's own damping of the highest mode stays below 0.1 1/s
TONGUE_PER_S = 1.0  # growth that counts
BINS = 900  # of what is kept of a run-up, for its drawing
SCENARIOS = ("pd", "constant-torque", "back-and-forth")


class Ramp(NamedTuple):
    """Carrier speed [rad/s] and vibration [rad/s^2] of the one-stage arm run up, (times,)."""

    speed: np.ndarray
    fast: np.ndarray


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

    def answer(self) -> dict[str, Any]:
        ramp, arm = _run_up(self.zeta, self.duration_s), _one_stage(self.zeta)
        away = ramp.fast[signals.window(ramp.speed, 20.0, 60.0)]
        speed, size = _drawn(ramp)
        return {
            "peaks": [_peak(ramp, 2 * np.pi * mode / _rate(arm)) for mode in _modes(arm)],
            "away_rad_per_s2": defined(signals.amplitude(away)),
            "drawn_speed": speed.tolist(),
            "drawn_size": size.tolist(),
        }


@dataclass(frozen=True)
class Tongue:
    """Floquet growth [1/s] over SPEEDS and at one slow speed [rad/s], at a damping ratio."""

    zeta: float
    slow: float

    @property
    def inputs(self) -> str:
        return f"{self!r}\n{_files()}"

    @property
    def cost(self) -> float:
        return 1.0

    def answer(self) -> dict[str, Any]:
        (slow,) = tongues(self.zeta, np.array([self.slow]))
        return {"growth": tongues(self.zeta, SPEEDS).tolist(), "slow": float(slow)}


def _files() -> str:
    cases = [load_case("paper-labelled", name) for name in ("constant-torque", "pd")]
    return "\n".join(record.model_dump_json() for case in cases for record in case)


def resonance(study: Study, scale: Scale) -> Evidence:
    """A run-up of one stage, Floquet theory of the stiffness, and the paper's own speeds."""
    arm = _one_stage(RAMP_ZETAS[0])
    ratio, modes = _rate(arm), _modes(arm)
    speeds = {name: _fastest(name) for name in SCENARIOS}
    asked: list[Question] = [
        *(RunUp(zeta, scale.seconds(RAMP_S)) for zeta in RAMP_ZETAS),
        *(Tongue(z, speeds["pd"]) for z in ZETAS),
    ]
    found = study.answers(asked, "phase: run-up and tongues")
    ramps = dict(zip(RAMP_ZETAS, found, strict=False))
    growth = dict(zip(ZETAS, found[len(RAMP_ZETAS) :], strict=True))
    records = [
        *(_ramp_record(zeta, ramp) for zeta, ramp in ramps.items()),
        *(_tongue_record(zeta, rates) for zeta, rates in growth.items()),
        {"id": "resonance/speeds", **{f"{n}_rad_per_s": s for n, s in speeds.items()}},
        {"id": "resonance/modes", "modes_Hz": [float(m) for m in modes], "teeth": ratio},
    ]
    lowest = 2 * np.pi * modes[0] / ratio
    text = [
        heading("6. Where would tooth error resonate under angle?"),
        paragraph(_statement(speeds, modes, ratio, records)),
        table(_HEAD, [_row(n, m, ratio, speeds, ramps) for n, m in enumerate(modes)]),
        table(_TONGUE_HEAD, [_tongue_row(r) for r in records if r["id"].startswith("tongue")]),
        figure(_figure(ramps, growth, modes, ratio, speeds["pd"]), _caption()),
    ]
    return Evidence("\n".join(text), records, is_far(float(lowest), speeds["pd"]))


def _one_stage(zeta: float, amplitude: float | None = None) -> Arm:
    """Shoulder and first link, the payload at its end; amplitude: another k_a [N/m]."""
    arm = load_case("paper-labelled", "pd", {}, [f"arm.joints.*.damping_ratio={zeta!r}"]).arm
    joint = arm.joints[0]
    if amplitude is not None:
        joint = joint.model_copy(update={"mesh_stiffness_amplitude_N_per_m": amplitude})
    return arm.model_copy(update={"joints": (joint,), "links": arm.links[:1]})


def _model(arm: Arm, torque: float, duration_s: float) -> PhysicalModel:
    scenario = load_case("paper-labelled", "constant-torque").scenario
    drive = ConstantDrive(kind="constant", torque_N_m=torque)
    update = {"drive": drive, "duration_s": duration_s}
    case = Case(arm, scenario.model_copy(update=update), _angle())
    return PhysicalModel(*case)


def _angle() -> Any:
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


def _fastest(scenario: str) -> float:
    """Largest carrier speed against the ring [rad/s] of either joint in a scenario of the paper."""
    case = load_case("paper-labelled", scenario, {}, ["scenario.step_s=1e-4"])
    rigid = build("analytic:coupled", case.arm, case.scenario).simulate()
    return float(np.abs(rigid["theta_dot"]).max())


def _run_up(zeta: float, duration_s: float) -> Ramp:
    """A constant torque that takes RAMP_S from rest through both modes; stiffness constant.

    So that tooth error is all that excites: k_a has tongues of its own.
    """
    arm = _one_stage(zeta, amplitude=0.0)
    inertia = float(_model(arm, 0.0, 1.0).mass_matrix(np.zeros(3))[2, 2])
    model = _model(arm, inertia * FASTEST_RAD_PER_S / RAMP_S, duration_s)
    plant, (q, v) = plant_of(model), model.start()
    step, steps = model.scenario.step_s, model.scenario.steps
    qs, vs = integrate(plant, 0.0, q, v, step, steps, STRIDE)
    time = step * STRIDE * np.arange(len(qs))
    return Ramp(vs[:, 2], vibration(time, accelerations_along(plant, time, qs, vs)[:, 2]))


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


def _peak(ramp: Ramp, speed: float) -> tuple[float | None, float | None]:
    """(speed [rad/s], vibration [rad/s^2]) of the largest vibration within 10 % of a speed.

    None where the stage does not get that fast.
    """
    part = slice(*np.searchsorted(ramp.speed, (0.9 * speed, 1.1 * speed)))
    if part.stop <= part.start:
        return None, None
    fast = np.abs(ramp.fast[part])
    return float(ramp.speed[part][np.argmax(fast)]), float(fast.max())


def _ramp_record(zeta: float, ramp: dict[str, Any]) -> dict[str, Any]:
    return {
        "id": f"run-up/{zeta:g}",
        "zeta": zeta,
        "peak_speeds_rad_per_s": [speed for speed, _ in ramp["peaks"]],
        "peaks_rad_per_s2": [size for _, size in ramp["peaks"]],
        "below_resonance_rad_per_s2": ramp["away_rad_per_s2"],
    }


def _tongue_record(zeta: float, rates: dict[str, Any]) -> dict[str, Any]:
    growth = np.array(rates["growth"])
    open_at = SPEEDS[growth > TONGUE_PER_S]
    return {
        "id": f"tongue/{zeta:g}",
        "zeta": zeta,
        "largest_growth_per_s": float(growth.max()),
        "at_rad_per_s": float(SPEEDS[np.argmax(growth)]),
        "lowest_open_rad_per_s": float(open_at[0]) if open_at.size else None,
        "at_the_pd_runs_fastest_per_s": rates["slow"],
    }


_HEAD = (
    "mode [Hz]",
    "met at carrier speed 2π f / c [rad/s]",
    "times the PD run's fastest",
    *(f"run-up, zeta {zeta:g}: peak at [rad/s], [rad/s²]" for zeta in RAMP_ZETAS),
)
_TONGUE_HEAD = (
    "zeta",
    "largest growth, 15 to 600 rad/s [1/s]",
    "at [rad/s]",
    "lowest speed with growth [rad/s]",
    "growth at the PD run's fastest [1/s]",
)


def _row(
    number: int, mode: float, ratio: float, speeds: dict[str, float], ramps: dict[float, Any]
) -> tuple[str, ...]:
    speed = 2 * np.pi * mode / ratio
    peaks = [ramp["peaks"][number] for ramp in ramps.values()]
    return (
        f"{mode:.1f}",
        f"{speed:.1f}",
        f"{speed / speeds['pd']:.0f}",
        *(f"{shown(at, '.1f')}, {shown(size)}" for at, size in peaks),
    )


def _tongue_row(record: dict[str, Any]) -> tuple[str, ...]:
    lowest = record["lowest_open_rad_per_s"]
    return (
        f"{record['zeta']:g}",
        f"{record['largest_growth_per_s']:.1f}",
        f"{record['at_rad_per_s']:.1f}",
        "none" if lowest is None else f"{lowest:.1f}",
        f"{record['at_the_pd_runs_fastest_per_s']:.1f}",
    )


def _statement(
    speeds: dict[str, float], modes: np.ndarray, ratio: float, records: list[dict[str, Any]]
) -> str:
    lowest = 2 * np.pi * modes[0] / ratio
    opened = [r["lowest_open_rad_per_s"] for r in records if r.get("lowest_open_rad_per_s")]
    tongue = f"{min(opened):.1f} rad/s" if opened else "no speed below 600 rad/s"
    return (
        "Question: tooth error does excite gears in earnest, when teeth pass at a mesh mode's"
        " frequency. Where is that for this arm? One stage with its link is run up by a constant"
        f" torque to {FASTEST_RAD_PER_S:g} rad/s in {RAMP_S:g} s (E = 5 µm, stiffness held"
        " constant so that nothing else excites); and for the time-variant stiffness Floquet"
        " theory gives the speeds at which a mesh vibration grows. The first resonance is at"
        f" {lowest:.1f} rad/s. The fastest joint speeds of the rigid arm are {speeds['pd']:.2f}"
        f" rad/s in the PD run, {speeds['constant-torque']:.1f} under constant torque and"
        f" {speeds['back-and-forth']:.1f} back and forth: the PD run's teeth pass at"
        f" {ratio * speeds['pd'] / (2 * np.pi):.1f} Hz at most,"
        f" {lowest / speeds['pd']:.0f} times too slowly. The lowest speed at which k_a lets a"
        f" vibration grow, at the smallest damping, is {tongue}. Verdict: the PD run"
        f" {'stays far from' if is_far(lowest, speeds['pd']) else 'comes near'} a resonance under"
        f" angle (limit: {FAR:g} times)."
    )


def _drawn(ramp: Ramp) -> tuple[np.ndarray, np.ndarray]:
    """Speed [rad/s] and largest vibration [rad/s^2] of every bin."""
    edge = signals.window(ramp.speed, 1.0, FASTEST_RAD_PER_S * (1 - FILTER_EDGE_S))
    if edge.stop <= edge.start:
        return np.empty(0), np.empty(0)
    _, low, high = envelope(ramp.speed[edge], ramp.fast[edge], BINS)
    speed = np.linspace(ramp.speed[edge][0], ramp.speed[edge][-1], low.size)
    return speed, np.maximum(np.abs(low), np.abs(high))


def _figure(
    ramps: dict[float, Any],
    growth: dict[float, Any],
    modes: np.ndarray,
    ratio: float,
    fastest: float,
) -> str:
    drawing, grid = new_figure(2, 1, 2.3)
    above, below = grid[:, 0]
    colours = dict(zip(ZETAS, COLOURS, strict=False))
    for zeta, ramp in ramps.items():
        above.plot(ramp["drawn_speed"], ramp["drawn_size"], color=colours[zeta])
    log_y(above)
    for zeta, rates in growth.items():
        below.plot(SPEEDS, rates["growth"], color=colours[zeta], label=f"zeta = {zeta:g}")
    legend(drawing, below)
    for mode in modes:
        above.axvline(2 * np.pi * mode / ratio, color="black", ls="--", lw=0.8)
    for axes in (above, below):
        axes.axvspan(0.0, fastest, color="#b03050", alpha=0.8)
        axes.set_xlim(-5.0, None)
    below.axhline(0.0, color="black", lw=0.6)
    above.set_ylabel("vibration, run-up [rad/s²]")
    below.set(xlabel="carrier speed [rad/s]", ylabel="Floquet growth rate [1/s]")
    return to_svg(drawing)


def _caption() -> str:
    return (
        "Above: run-up of one stage under angle, largest vibration per bin, dashed: teeth pass at a"
        " mesh mode. Below: growth of a mesh vibration by k_a = 0.2 k_m alone. Red strip at the"
        " left edge: all speeds of the PD run."
    )
