"""How often 95 % intervals of `crosscheck compare` hold the truth, on simulated recordings.

    python -m benchmarks.bench_coverage [REGIME ...] [--draws 100] [--seed 0]

Each draw is a recording of 1 kHz with its own motion (sums of sines) and noise, of a mechanism
whose numbers are known. A regime says of which mechanism, how long, how noisy (positions and
torques, in parts of each joint's rms), how lively and with how much friction (in parts of each
joint's rms torque, half of it Coulomb's). A row of the table is a kind of number in a regime: how
many intervals were stated, the share that holds the truth, how many estimates depend on the band
and have none, how many were not named, rms and largest of the errors in standard errors, and the
median half-width. Regimes are those whose names have all of the words given; REGIME may be several
words joined by commas.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from crosscheck.identification import compare
from crosscheck.identification.mechanism import ComparedMechanism, PlanarArm, SpatialRobot
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Level, remove_friction
from crosscheck.recordings.record import Record
from crosscheck.registry import build_robot_model
from tests.measured import robots

FREQUENCIES = np.array([0.2, 0.5, 0.9, 1.3])  # [Hz] of the first joint, a tenth more for each next
STEP_S = 1e-3
FRICTION = 0.2  # of each joint's rms torque, where a regime has it
TILT_DEG = 3.0
COLUMNS = (
    "regime, band [Hz], number: stated, % hold, on band, not named, rms z, largest z, half-width"
)


class Subject(NamedTuple):
    """A mechanism, its level, and the factor that is missing in one number of its file."""

    mechanism: ComparedMechanism
    level: Level
    path: str
    factor: float


@cache
def load_subject(name: str) -> Subject:
    """A planar arm of two joints, or a robot of three or six."""
    if name == "arm":
        arm = PlanarArm(load_arm("paper-labelled"))
        return Subject(arm, "coupled", "arm.payload_mass_kg", 1.02)
    if name == "tilted-arm":
        return Subject(PlanarArm(load_arm("three-unlike")), "coupled", "", 1.0)
    if name == "six":
        robot = SpatialRobot(load_robot("six-joint"))
        return Subject(robot, "armature", "robot.links.forearm.mass_kg", 1.1)
    robot = SpatialRobot(robots.arm())
    path = "" if name.startswith("tilted") else "robot.links.c.mass_kg"
    return Subject(robot, "armature", path, 1.1)


class Regime(NamedTuple):
    """Recordings of a kind: amplitude [rad] and pace of the motion; noise and friction in parts."""

    subject: str
    rows: int
    noise: float
    amplitude: float
    pace: float
    friction: float


def list_regimes() -> Iterator[tuple[str, Regime]]:
    """Every regime by its name."""
    for subject in ("arm", "three", "six", "tilted-arm", "tilted-robot"):
        for exponent in (4, 5, 6):
            for noise in (2, 3, 4, 5):
                for motion, (amplitude, pace) in (("lively", (0.5, 1.0)), ("quiet", (0.1, 0.25))):
                    for rubs in ("smooth", "rubbing"):
                        name = f"{subject},1e{exponent},1e-{noise},{motion},{rubs}"
                        friction = FRICTION if rubs == "rubbing" else 0.0
                        yield (
                            name,
                            Regime(subject, 10**exponent, 10.0**-noise, amplitude, pace, friction),
                        )


REGIMES = dict(list_regimes())
USUAL = (
    *(f"arm,1e4,1e-{noise},lively,rubbing" for noise in (2, 3, 4, 5)),
    "arm,1e4,1e-3,lively,smooth",
    "arm,1e4,1e-3,quiet,rubbing",
    "arm,1e5,1e-2,quiet,rubbing",
    "arm,1e5,1e-5,quiet,rubbing",
    *(f"three,1e4,1e-{noise},lively,rubbing" for noise in (2, 3, 5)),
    "three,1e4,1e-4,quiet,rubbing",
    "three,1e5,1e-4,quiet,rubbing",
    "six,1e4,1e-3,lively,rubbing",
    "tilted-arm,1e4,1e-3,lively,rubbing",
    "tilted-robot,1e4,1e-3,lively,rubbing",
)


def make_motion(regime: Regime, joints: int, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Angles, rates and accelerations (rows, joints)."""
    time = np.arange(regime.rows) * STEP_S
    moved = np.zeros((3, regime.rows, joints))
    for joint in range(joints):
        for frequency in FREQUENCIES:
            rate = 2 * np.pi * regime.pace * (1 + 0.1 * joint) * frequency
            size = regime.amplitude * rng.uniform(0.7, 1.3) / (1 + 3 * frequency)
            turned = rate * time + rng.uniform(0, 2 * np.pi)
            moved[0, :, joint] += size * np.sin(turned)
            moved[1, :, joint] += size * rate * np.cos(turned)
            moved[2, :, joint] -= size * rate**2 * np.sin(turned)
    return tuple(moved)


def tilt_base(mechanism: ComparedMechanism) -> ComparedMechanism:
    """The same on a base that is turned about an axis across gravity, the plane's of an arm."""
    axis = [0.0, 0.0, 1.0] if isinstance(mechanism, PlanarArm) else [0.6, -0.8, 0.0]
    turned = pin.exp3(np.radians(TILT_DEG) * np.array(axis))
    return mechanism.turn(turned.T @ mechanism.robot.gravity)


def draw_record(regime: Regime, seed: int) -> tuple[Record, dict[str, float]]:
    """A recording, and what is true of it by names of terms and paths of numbers."""
    rng = np.random.default_rng([seed, 17])
    subject = load_subject(regime.subject)
    given = {each.path: each.value for each in subject.mechanism.parameters}
    truth = {subject.path: subject.factor * given[subject.path]} if subject.path else {}
    changed = subject.mechanism.change(truth) if truth else tilt_base(subject.mechanism)
    (level,) = (each for each in changed.levels if each.name == subject.level)
    robot = remove_friction(level.robot)
    names = robot.coordinate_names
    q, v, a = make_motion(regime, len(names), rng)
    torque = build_robot_model("analytic", robot, level.level).inverse_dynamics(q, v, a)
    strength = np.sqrt((torque**2).mean(axis=0))
    coulomb = regime.friction / 2 * strength
    viscous = coulomb / np.sqrt((v**2).mean(axis=0))
    torque = torque + coulomb * np.sign(v) + viscous * v
    for number, name in enumerate(names):
        truth |= {f"coulomb of {name}": coulomb[number], f"viscous of {name}": viscous[number]}
    for rotor in robot.rotors:
        truth[f"armature of {robot.joints[rotor.joint].name}"] = rotor.ratio**2 * rotor.inertia
    truth |= {"delay of all torques": 0.0, "tilt": TILT_DEG}
    spread = np.sqrt(((q - q.mean(axis=0)) ** 2).mean(axis=0))
    q = q + regime.noise * spread * rng.normal(size=q.shape)
    torque = torque + regime.noise * strength * rng.normal(size=q.shape)
    return Record("drawn", np.arange(regime.rows) * STEP_S, q, torque), truth


@dataclass
class Count:
    """Of a kind of number: errors over half-widths and over standard errors, and half-widths."""

    over_widths: list[float] = field(default_factory=list)
    over_errors: list[float] = field(default_factory=list)
    widths: list[float] = field(default_factory=list)
    band_dependent: int = 0
    unnamed: int = 0

    def add(self, error: float, standard_error: float, half_width: float) -> None:
        """Count an interval that is stated."""
        self.over_widths.append(abs(error) / half_width)
        self.over_errors.append(error / standard_error)
        self.widths.append(half_width)

    def describe(self) -> str:
        """A row of the table."""
        stated = len(self.widths)
        row = f"{stated:5d} {{}} {self.band_dependent:4d} {self.unnamed:4d}"
        if not stated:
            return row.format("    -")
        share = 100 * float((np.array(self.over_widths) <= 1).mean())
        z = np.abs(self.over_errors)
        sizes = f"{np.sqrt((z**2).mean()):6.2f} {z.max():5.1f} {np.median(self.widths):9.3g}"
        return f"{row.format(f'{share:5.1f}')} {sizes}"


def count_draw(
    regime: Regime, record: Record, truth: Mapping[str, float], counts: dict[str, Count]
) -> float:
    """Count the intervals that a recording's comparison states; returns its bandwidth [Hz]."""
    mechanism = load_subject(regime.subject).mechanism
    robot = remove_friction(mechanism.robot)
    shared = np.zeros((0, len(robot.coordinate_names)))
    torques = [record.motor_torque]
    samples = compare._BandSamples(robot, [record], torques, shared)
    problem = compare._Problem(robot, samples, "motor")
    bandwidth = problem.choose_bandwidth()
    if regime.subject.startswith("tilted"):
        _, tilt = compare._judge_gravity(problem, torques, bandwidth)
        angle = None if tilt is None else tilt.angle_deg
        if angle is None:
            counts["tilt"].unnamed += 1
        else:
            counts["tilt"].add(angle[0] - truth["tilt"], angle[1] / 2, angle[1])
        return bandwidth
    side = compare._judge_side(problem, bandwidth, compare.NOTHING_ELSE)
    judgement = compare._judge_file(problem, mechanism, side)
    level, path = load_subject(regime.subject).level, load_subject(regime.subject).path
    named = [
        replace(each.estimate, term=replace(each.estimate.term, name=path))
        for each in judgement.changes
        if each.estimate and each.parameter and (each.level, each.parameter.path) == (level, path)
    ]
    counts["number"].unnamed += not named
    for each in (*side.estimates, *named):
        if each.term.name not in truth:
            continue
        count = counts[each.term.kind]
        if each.doubled is None:
            count.add(each.value - truth[each.term.name], each.error, each.half_width)
        else:
            count.band_dependent += 1
    return bandwidth


def describe_regime(name: str, draws: int, seed: int) -> Iterator[str]:
    """The rows of a regime."""
    counts, bands = defaultdict[str, Count](Count), []
    for number in range(draws):
        print(f"\r{name}: {number} of {draws} ", end="", file=sys.stderr, flush=True)
        record, truth = draw_record(REGIMES[name], seed + number)
        bands.append(count_draw(REGIMES[name], record, truth, counts))
    print("\r", end="", file=sys.stderr)
    for kind, count in counts.items():
        yield f"{name:36} {np.median(bands):6.3g} {kind:9} {count.describe()}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("regimes", nargs="*")
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    asked = [
        name
        for name in (REGIMES if options.regimes else USUAL)
        if not options.regimes
        or any(set(each.split(",")) <= set(name.split(",")) for each in options.regimes)
    ]
    print(COLUMNS)
    for name in asked:
        for line in describe_regime(name, options.draws, options.seed):
            print(line, flush=True)


if __name__ == "__main__":
    main()
