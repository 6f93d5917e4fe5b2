"""How often stated 95 % intervals of `crosscheck compare` hold the truth.

    python -m benchmarks.bench_coverage [REGIME ...] [--draws 100] [--seed 0]

Each draw is a record of its own motion (sums of sines) and noise, of a mechanism whose numbers are
known; a regime says how long, how lively and how noisy. A row of the table is a kind of number:
how many intervals were stated and how many hold the truth, how many estimates depend on the band,
the rms of the errors in standard errors, and the median of the half-widths over the truth. Without
a regime all of them are drawn.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from crosscheck.identification import compare
from crosscheck.identification.mechanism import ComparedMechanism, PlanarArm, SpatialRobot
from crosscheck.identification.terms import TermEstimate
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.recordings.record import Record
from crosscheck.registry import build_robot_model
from tests.measured import robots

FREQUENCIES = np.array([0.2, 0.5, 0.9, 1.3])  # [Hz] of the first joint, a tenth higher for each next


@dataclass(frozen=True)
class Subject:
    """A mechanism, its file's number that is wrong, and that number's share in what is recorded."""

    mechanism: ComparedMechanism
    path: str
    level: str = "coupled"
    factor: float = 1.02


@cache
def load_subject(name: str) -> Subject:
    """The planar arm, or a robot of three or six joints."""
    if name == "arm":
        return Subject(PlanarArm(load_arm("paper-labelled")), "arm.payload_mass_kg")
    if name == "three":
        return Subject(SpatialRobot(robots.arm()), "robot.links.c.mass_kg", "armature", 1.1)
    return Subject(SpatialRobot(load_robot("six-joint")), "", "armature", 1.1)


@dataclass(frozen=True)
class Regime:
    """Records of a kind.

    noise: white, of positions and of torques, in parts of each joint's rms; amplitude [rad] and
    pace: of the motion; coulomb, viscous: friction in parts of each joint's rms torque; tilt: of
    the base [degrees], in place of the wrong number.
    """

    subject: str
    rows: int = 10_000
    noise: float = 1e-3
    amplitude: float = 0.5
    pace: float = 1.0
    coulomb: float = 0.0
    viscous: float = 0.0
    tilt: float = 0.0
    step: float = 1e-3
    torque_noise: float | None = None


LIVELY: dict[str, float] = {}
QUIET: dict[str, float] = {"amplitude": 0.1, "pace": 0.25}
RUBBING: dict[str, float] = {"coulomb": 0.1, "viscous": 0.1}


def list_regimes() -> Iterator[tuple[str, Regime]]:
    for subject in ("arm", "three", "six"):
        for rows in (10_000, 100_000):
            for noise in (1e-2, 1e-3, 1e-4, 1e-5):
                for pace, motion in (("lively", LIVELY), ("quiet", QUIET)):
                    for rubs, friction in (("smooth", {}), ("rubbing", RUBBING)):
                        name = f"{subject}-{rows:.0e}-{noise:.0e}-{pace}-{rubs}".replace("+0", "")
                        yield name.replace("-0", "-"), Regime(subject, rows, noise, **motion, **friction)


REGIMES = dict(list_regimes())


def make_record(regime: Regime, seed: int) -> tuple[Record, dict[str, float]]:
    """A record, and what is true of it by names of terms and paths of numbers."""
    rng = np.random.default_rng([seed, 17])
    subject = load_subject(regime.subject)
    value = {each.path: each.value for each in subject.mechanism.parameters}.get(subject.path, 0.0)
    truth = {subject.path: subject.factor * value}
    changed = subject.mechanism.change(truth) if subject.path else subject.mechanism
    (level,) = (each for each in changed.levels if each.name == subject.level)
    n = len(level.robot.coordinate_names)
    time = np.arange(regime.rows) * regime.step
    rates = 2 * np.pi * regime.pace * np.outer(1 + 0.1 * np.arange(n), FREQUENCIES)
    sizes = regime.amplitude * rng.uniform(0.7, 1.3, rates.shape) / (1 + 3 * FREQUENCIES)
    phases = rng.uniform(0, 2 * np.pi, rates.shape)
    angles, speeds, gains = np.zeros((3, regime.rows, n))
    for joint in range(n):
        for rate, size, phase in zip(rates[joint], sizes[joint], phases[joint], strict=True):
            turned = rate * time + phase
            angles[:, joint] += size * np.sin(turned)
            speeds[:, joint] += size * rate * np.cos(turned)
            gains[:, joint] -= size * rate**2 * np.sin(turned)
    model = build_robot_model("analytic", compare.remove_friction(level.robot), level.level)
    torques = model.inverse_dynamics(angles, speeds, gains)
    strength = np.sqrt((torques**2).mean(axis=0))
    coulomb = regime.coulomb * strength
    viscous = regime.viscous * strength / np.sqrt((speeds**2).mean(axis=0))
    torques = torques + coulomb * np.sign(speeds) + viscous * speeds
    for number, name in enumerate(level.robot.coordinate_names):
        truth |= {f"coulomb of {name}": coulomb[number], f"viscous of {name}": viscous[number]}
        truth[f"armature of {name}"] = 0.0
    for rotor in level.robot.rotors:
        name = level.robot.joints[rotor.joint].name
        share = 1.0 if level.level == "armature" else (rotor.ratio - 1) / rotor.ratio
        truth[f"armature of {name}"] = share * rotor.ratio**2 * rotor.inertia
    truth["delay of all torques"] = 0.0
    shaken = regime.noise * np.sqrt(((angles - angles.mean(axis=0)) ** 2).mean(axis=0))
    share = regime.noise if regime.torque_noise is None else regime.torque_noise
    angles = angles + shaken * rng.normal(size=angles.shape)
    torques = torques + share * strength * rng.normal(size=torques.shape)
    return Record("drawn", time, angles, torques), truth


@dataclass
class Count:
    """Of a kind of number: errors in half-widths and in standard errors, relative half-widths."""

    missed: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    widths: list[float] = field(default_factory=list)
    bands: int = 0
    unnamed: int = 0

    def add(self, each: TermEstimate, truth: float) -> None:
        if each.doubled is not None:
            self.bands += 1
            return
        self.missed.append(abs(each.value - truth) / each.half_width)
        self.errors.append((each.value - truth) / each.error)
        self.widths.append(each.half_width)

    def describe(self) -> str:
        stated = len(self.missed)
        if not stated:
            return f"{0:5d} {'':5} {self.bands:5d} {self.unnamed:5d}"
        held = int((np.array(self.missed) <= 1).sum())
        rms = float(np.sqrt(np.mean(np.square(self.errors))))
        return (
            f"{stated:5d} {100 * held / stated:5.1f} {self.bands:5d} {self.unnamed:5d} {rms:6.2f}"
            f" {max(map(abs, self.errors)):6.1f} {np.median(self.widths):10.3g}"
        )


def estimate(regime: Regime, record: Record) -> compare.SideResult:
    subject = load_subject(regime.subject)
    robot = compare.remove_friction(subject.mechanism.robot)
    n = len(robot.coordinate_names)
    shared = compare.shared_motors(np.eye(n))
    samples = compare._BandSamples(robot, [record], [record.motor_torque], shared)
    problem = compare._Problem(robot, samples, compare.LINK_KINDS["identified"])
    bandwidth = problem.choose_bandwidth()
    judged = compare._judge_side(problem, "motor", "identified", bandwidth, compare.NOTHING_ELSE)
    if subject.path:
        judgement = compare._judge_file(problem, subject.mechanism, "motor", bandwidth)
        judged = replace(judged, judgement=judgement)
    return judged


def count_regime(name: str, draws: int, seed: int) -> dict[str, Count]:
    regime, counts = REGIMES[name], dict[str, Count]()
    subject = load_subject(regime.subject)
    for draw in range(seed, seed + draws):
        print(f"\r{name}: {draw - seed} of {draws}", end="", file=sys.stderr, flush=True)
        record, truth = make_record(regime, draw)
        side = estimate(regime, record)
        for each in side.estimates:
            kind = each.term.kind
            if each.term.name in truth:
                counts.setdefault(kind, Count()).add(each, truth[each.term.name])
        if side.judgement is not None:
            number = counts.setdefault("number", Count())
            for each in side.judgement.changes:
                if each.level == subject.level and each.parameter.path == subject.path and each.is_fitting:
                    number.add(each.estimate, truth[subject.path])
                    break
            else:
                number.unnamed += 1
        counts.setdefault("band", Count()).widths.append(side.bandwidth)
    print("\r", end="", file=sys.stderr)
    return counts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("regimes", nargs="*")
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    for name in REGIMES:
        if not options.regimes or any(part in name for part in options.regimes):
            counts = count_regime(name, options.draws, options.seed)
            band = np.median(counts.pop("band").widths)
            for kind, count in counts.items():
                print(f"{name:36} {band:5.2f} {kind:10} {count.describe()}", flush=True)


if __name__ == "__main__":
    main()
