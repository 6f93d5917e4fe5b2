"""Records made of a rigid level: a stated motion, the torques that it needs, and white noise."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from crosscheck.identification.compare import (
    RecordComparison,
    _BandSamples,
    _Problem,
    _select_torques,
    compare,
    remove_friction,
)
from crosscheck.identification.mechanism import ComparedMechanism, PlanarArm
from crosscheck.identification.restrictions import FileJudgement
from crosscheck.models.arm.arm import Arm
from crosscheck.models.interface import Model
from crosscheck.models.loading import make_rest_scenario
from crosscheck.models.robot.robot import Robot
from crosscheck.recordings.record import Record
from crosscheck.registry import build

# Of every joint, a sum of sines: frequencies [Hz] of the first joint, a tenth higher for each next.
FREQUENCIES = (0.2, 0.5, 0.9, 1.3)
ANGLE_NOISE, TORQUE_NOISE = 1e-5, 0.1  # [rad], [N m]


def level(arm: Arm, name: str) -> Model:
    """The analytic model of a rigid level."""
    return build(f"analytic:{name}", arm, make_rest_scenario())


def motion(joints: int, time: np.ndarray, amplitude: float) -> tuple[np.ndarray, ...]:
    """Angles, rates and accelerations (rows, joints) at times [s]."""
    phases = np.random.default_rng(0).uniform(0, 2 * np.pi, (joints, len(FREQUENCIES)))
    rates = 2 * np.pi * np.outer(1 + 0.1 * np.arange(joints), FREQUENCIES)
    return sum_sines(time, amplitude / (1 + 3 * np.array(FREQUENCIES)), rates, phases)


def sum_sines(
    time: np.ndarray, sizes: np.ndarray, rates: np.ndarray, phases: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sums of sines of every joint, their rates and accelerations (rows, joints)."""
    turned = rates * time[:, None, None] + phases
    return (
        (sizes * np.sin(turned)).sum(axis=2),
        (sizes * rates * np.cos(turned)).sum(axis=2),
        -(sizes * rates**2 * np.sin(turned)).sum(axis=2),
    )


def record_of(
    model: Model,
    seed: int = 0,
    *,
    rows: int = 4000,
    amplitude: float = 0.3,
    time: np.ndarray | None = None,
    coulomb: float = 0.0,
    encoder: float = 0.0,
    noise: float = 1.0,
) -> Record:
    """A record of a model's torques along the motion.

    coulomb [N m]: friction of every joint; encoder [rad]: its steps; noise: times the usual one.
    """
    rng = np.random.default_rng(seed)
    time = np.arange(rows) * 1e-3 if time is None else time
    angles, rates, accelerations = motion(len(model.arm.joints), time, amplitude)
    torques = model.inverse_dynamics(angles, rates, accelerations) + coulomb * np.sign(rates)
    angles = angles + noise * ANGLE_NOISE * rng.normal(size=angles.shape)
    if encoder:
        angles = encoder * np.round(angles / encoder)
    return Record(
        "a record", time, angles, torques + noise * TORQUE_NOISE * rng.normal(size=angles.shape)
    )


def write_table(path: Path, columns: Mapping[str, np.ndarray]) -> Path:
    """Write a CSV file of columns, all digits of theirs."""
    table = np.column_stack([*columns.values()])
    head = ",".join(columns)
    np.savetxt(path, table, delimiter=",", header=head, comments="", fmt="%.17g")
    return path


def name_columns(record: Record) -> dict[str, np.ndarray]:
    """A record's columns, named as commands want them."""
    assert record.motor_torque is not None
    named = (("theta_{}_rad", record.position), ("torque_{}_N_m", record.motor_torque))
    joints = [
        (name.format(n), column) for name, signal in named for n, column in enumerate(signal.T, 1)
    ]
    return {"t_s": record.time, **dict(joints)}


def compared(
    record: Record, mechanism: ComparedMechanism | Arm, **tolerances: float
) -> RecordComparison:
    """Of engines that agree, without a word of progress."""
    own = mechanism if isinstance(mechanism, ComparedMechanism) else PlanarArm(mechanism)
    turns = np.eye(record.position.shape[1])
    comparison = compare(own, [record], turns, lambda *doing: None, tolerances=tolerances)
    assert comparison.engines_agree
    return comparison


def first_problem(robot: Robot, given: Record) -> _Problem:
    """What is estimated of the first side that a recording has."""
    side, torques = _select_torques([given])[0]
    own, shared = remove_friction(robot), np.zeros((0, len(robot.coordinate_names)))
    samples = _BandSamples(own, [given], torques, shared)
    return _Problem(own, samples, side)


def judged(record: Record, mechanism: ComparedMechanism | Arm) -> FileJudgement:
    """What the record says of the files' numbers, without all that a comparison asks beside."""
    own = mechanism if isinstance(mechanism, ComparedMechanism) else PlanarArm(mechanism)
    problem = first_problem(own.robot, record)
    return problem.fit_file(own, problem.choose_bandwidth()).judge(own.levels)


def list_explanations(judgement: FileJudgement) -> list[tuple[str, str]]:
    """Level and path of the number of each explanation, no path where none is changed."""
    return [
        (each.level, each.parameter.path if each.parameter else "")
        for each in judgement.explanations
    ]
