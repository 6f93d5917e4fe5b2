"""Planted worlds: made-up runs, measured as real ones are, that a claim may be true or false of.

No run is simulated: a run's record (a Course) is made by hand from a few choices, and the audit's
own measures read it. A world gives each experiment of a claim one of these records.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.pd import measure_whole_pd
from crosscheck.audit.experiments.samples import judge_third_fluctuation
from crosscheck.audit.experiments.torque import (
    measure_back_and_forth,
    measure_constant_torque,
    mesh_phase,
)
from crosscheck.audit.judging.quantities import Sample
from crosscheck.audit.judging.rule import Answer
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.models.loading import Case, load_case
from crosscheck.registry import RIGID_LEVELS

PD_CASE = load_case("paper-labelled", "pd", {"phase": "omega_t"}, [])
TORQUE_CASE = load_case("paper-labelled", "constant-torque", {}, [])
SHAKEN_CASE = load_case("paper-labelled", "back-and-forth", {}, [])
TARGET = np.pi / 6
RUNS = {"pd": 100, "constant torque": 120, "back and forth": 60}
Numbers = dict[str, float | None]


class Choice:
    """Draws the properties of a made-up run, one after the other."""

    def __init__(self, seed: int) -> None:
        self.generator = np.random.default_rng(seed)

    def of(self, *values: float) -> float:
        """One of these, now and then with a little more or less."""
        value = values[int(self.generator.integers(len(values)))]
        return value * (1 + 0.02 * float(self.generator.integers(0, 2)))


def pool(kind: str) -> Sample:
    """The numbers of many made-up runs of one kind of experiment, each (runs,)."""
    maker = {"pd": pd_run, "constant torque": torque_run, "back and forth": shaken_run}[kind]
    found = [maker(Choice(1000 + seed)) for seed in range(RUNS[kind])]
    names = dict.fromkeys(name for numbers in found for name in numbers)
    numbers = {
        name: np.array([np.nan if one[name] is None else one[name] for one in found], float)
        for name in names
    }
    return Sample(numbers, np.zeros(len(found), dtype=bool))


def pd_run(choice: Choice) -> Numbers:
    """30 degrees under PD control: impacts, fluctuations, contact and the way, all made up."""
    step_s = 1e-4
    time = np.arange(0, 3, step_s)
    met_s, return_s = choice.of(0.31, 0.35, 0.42), choice.of(1.4, 1.5, 1.8)
    left_s = met_s - choice.of(0.002, 0.01, 0.05)
    excess = np.zeros(time.size)
    for begin_s, end_s, sizes in (
        (0.0, 0.25, (0.3, 8.0, 25.0, 60.0)),
        (met_s - choice.of(0.0, 0.0, 0.08), 0.5, (0.0, 0.3, 8.0, 25.0, 200.0)),
        (return_s, return_s + 0.1, (0.0, 0.5, 20.0)),
    ):
        excess += _impact(choice, time, begin_s, end_s, choice.of(*sizes))
    excess += _third(choice, time)
    excess += choice.of(0.0, 0.01, 1.5) * choice.generator.standard_normal(time.size)
    force = _contact(choice, time, left_s, met_s, return_s)
    reach = choice.of(0.01, 1.0, 1.0, 1.03, 1.2)
    way = reach * TARGET * _way(choice, time)
    theta = np.column_stack([way, way])
    gap = choice.of(0.0, 1e-6, 5e-3) * np.exp(-choice.of(0.0, 3.0) * time)
    rigid_way = theta - (gap * np.sin(choice.of(3.0, 600.0) * time))[:, None]
    ripple = choice.of(0.0, 0.02, 2.0) * np.sin(2 * np.pi * 1500 * time) * (time > 0.5)
    rate = np.gradient(theta, time, axis=0) * (1 + ripple[:, None])
    shaken = excess[:, None] * (1.0, choice.of(1.0, 4.0))
    torque = 50 * np.exp(-3 * time) + choice.of(0.0, 1.0) * np.roll(excess, int(choice.of(0, 500)))
    x = choice.of(50e-6, 50e-6, 3e-3) * np.sign(force)
    x = x + choice.of(0.0, 0.0, 1e-5) * np.sin(2 * np.pi * 1500 * time)
    outer = np.column_stack([force, force])
    still = np.full(theta.shape, choice.of(0.01, 0.5, 30.0))
    run = RunSignals(
        PD_CASE,
        time,
        theta,
        rate,
        still + shaken,
        np.column_stack([torque, torque]),
        x,
        x,
        force,
        force,
        outer,
    )
    return measure_whole_pd(run, replace(run, theta=rigid_way, theta_ddot=still))


def _impact(
    choice: Choice, time: np.ndarray, begin_s: float, end_s: float, size: float
) -> np.ndarray:
    """A vibration from an event on: it dies, stays or grows."""
    rate = choice.of(-8.0, 0.0, 30.0, 300.0)
    part = (time >= begin_s) & (time < end_s)
    course = np.exp(-rate * (time - begin_s)) / max(1.0, np.exp(-rate * (end_s - begin_s)))
    return np.where(part, size * course * np.sin(2 * np.pi * 1500 * time), 0.0)


def _third(choice: Choice, time: np.ndarray) -> np.ndarray:
    """A vibration between 0.5 and 1.2 s, of one or more lines, with a beginning."""
    size = choice.of(0.0, 0.3, 5.0, 30.0, 90.0, 150.0, 300.0, 700.0)
    frequency = choice.of(200.0, 1100.0, 1500.0, 1500.0, 2500.0)
    begin_s = choice.of(0.5, 0.62, 0.8)
    multiples = choice.of(0, 0, 1)
    wave = np.sin(2 * np.pi * frequency * time) + 0.2 * multiples * sum(
        np.sin(2 * np.pi * n * frequency * time) for n in (2, 3)
    )
    if choice.of(0, 0, 0, 1):  # of no frequency at all
        wave = 0.3 * choice.generator.standard_normal(time.size)
    return np.where((time >= begin_s) & (time < 1.15), size * wave, 0.0)


def _contact(
    choice: Choice, time: np.ndarray, left_s: float, met_s: float, return_s: float
) -> np.ndarray:
    """The mesh force [N]: one side, flight, the other side, back; or bouncing, or hardly ever."""
    load = choice.of(100.0, 1000.0, 5000.0)
    if choice.of(0, 0, 0, 0, 0, 1):  # never lets go
        return np.full(time.size, load)
    force = np.where((time < left_s) | (time > return_s), load, 0.0)
    force = force - load * ((time >= met_s) & (time < return_s - 0.005))
    bounce = (time > met_s) & (time < met_s + choice.of(0.0, 0.02, 0.08))
    force = np.where(bounce & (np.sin(2 * np.pi * 800 * time) > 0), 0.0, force)
    if choice.of(0, 0, 1):  # from side to side in the third window
        shaken = (time > 0.5) & (time < 1.2)
        force = np.where(shaken, load * np.sin(2 * np.pi * choice.of(60, 800) * time), force)
    if choice.of(0, 0, 1):  # mostly on the first side after the change
        force = np.where((time > met_s + 0.15) & (time < return_s - 0.1), load, force)
    if choice.of(0, 0, 1):  # hardly ever in contact
        kept = np.abs(np.diff(force, prepend=load)) > 0
        force = np.where(kept | (time < 0.001), force, 0.0)
    if choice.of(0, 0, 1):  # apart now and then at the start
        force = np.where((time > 0.01) & (time < 0.02), 0.0, force)
    if choice.of(0, 0, 1):  # a bumpy load
        force = force * (1 + 0.5 * np.sin(2 * np.pi * 1500 * time) * (time > 0.5))
    return force


def _way(choice: Choice, time: np.ndarray) -> np.ndarray:
    """From 0 to about 1: quickly, slowly, at one speed, past it and back, or with a setback."""
    if choice.of(0, 0, 1):
        return time / time[-1]
    way = 1 - np.exp(-choice.of(1.0, 4.0, 6.0) * time)
    way = way + choice.of(0.0, 0.0, 0.1) * np.sin(np.pi * time / 3)
    return way - choice.of(0.0, 0.03) * np.sin(2 * np.pi * 4 * time) * (time < 0.5)


def torque_run(choice: Choice) -> Numbers:
    """100 N m for 0.5 s."""
    time = np.arange(0, 0.5, 1e-4)
    bend = choice.of(1.0, 1.0, -1.0)  # speeding up or slowing down
    course = time**2 if bend > 0 else 0.5 * time - 0.5 * time**2
    # As the arm does: the elbow's torque drives the shoulder back.
    theta = np.column_stack([-choice.of(0.6, 1.0, 8.0) * course, choice.of(2.0, 9.0) * course])
    rate = np.gradient(theta, time, axis=0)
    gaps = [choice.of(1e-6, 0.005, 0.06, 0.12, 0.5) for _ in RIGID_LEVELS]
    growing = choice.of(0.2, 1.0, 2.0)
    rigids = [
        RunSignals(
            TORQUE_CASE, time, theta * (1 + gap * time[:, None] ** growing), *[rate] * 3, *_NONE
        )
        for gap in gaps
    ]
    run = RunSignals(TORQUE_CASE, time, theta, rate, rate, np.full(theta.shape, 100.0), *_NONE)
    ring = choice.of(0.0, 20.0, 200.0) * np.exp(-choice.of(0.0, 5.0, 100.0) * time)
    ringing = ring * np.sin(2 * np.pi * 1700 * time)
    wave = choice.of(0.0, 0.5, 1.0) * np.sin(mesh_phase(run))
    mean = choice.of(100.0, 200.0)
    start = choice.of(0.0, 1.0)
    force = (mean + ringing) * (1 + 0.2 * wave) * np.where(time < 1e-4, start, 1.0)
    swing = choice.of(0.0, 2e-6, 4.9e-6, 5e-6, 9e-6)
    phase = 2 * np.pi * (choice.of(0.0, 4.0) * time + choice.of(-18.0, 1.0, 20.0) * time**2)
    x = choice.of(30e-6, 52e-6) + swing * np.sin(phase)
    others = np.column_stack(
        [mean + choice.of(0.0, 1.0) * ringing + choice.of(0.0, 3.0) * wave] * 2
    )
    run = replace(run, x_sp=x, x_pr=x, F_sp=force, F_pr=force, F_outer=others)
    return measure_constant_torque(run, *rigids)


_NONE = [np.empty(0)] * 5


def shaken_run(choice: Choice) -> Numbers:
    """2 s back and forth: an error that grows on, stays, shrinks, or comes and goes."""
    time = np.arange(0, 2, 1e-3)
    theta = np.zeros((time.size, 2))
    parts = [RunSignals(SHAKEN_CASE, time, *[theta] * 4, *_NONE) for _ in range(3)]
    swing = np.sin(2 * np.pi * 10 * time)
    courses = (
        1e-5 * np.exp(choice.of(-2.0, 0.0, 3.0, 8.0) * time),
        1e-6 * np.exp(choice.of(0.0, 2.0, 8.0) * time),
    )
    wavy = 1 + choice.of(0.0, 0.9) * np.sin(2 * np.pi * 1.3 * time)
    error, own = (
        replace(parts[0], theta=np.column_stack([size * swing] * 2))
        for size in (courses[0] * wavy * choice.of(0.1, 0.5, 1.0, 10.0), courses[1])
    )
    return measure_back_and_forth(error, parts[1], own)


@cache
def pools() -> dict[str, Sample]:
    """Of every kind."""
    return {kind: pool(kind) for kind in RUNS}


def third(*sizes: float) -> Answer:
    """The third fluctuation of starts of these sizes [rad/s^2]."""
    sample = Sample({"third": np.array(sizes)}, np.zeros(len(sizes), bool))
    return judge_third_fluctuation(sample)


class ContinuedModel(PhysicalModel):
    """A model that starts from any state q, v (n,)."""

    def __init__(self, case: Case, q: np.ndarray, v: np.ndarray) -> None:
        super().__init__(*case)
        self.state = q, v

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        return self.state
