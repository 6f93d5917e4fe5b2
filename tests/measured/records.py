"""Records made of a rigid level: a stated motion, the torques that it needs, and white noise."""

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.interface import Model
from crosscheck.planning.sizing import make_rest_scenario
from crosscheck.recordings.compare import RecordComparison, compare
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
    sizes = amplitude / (1 + 3 * np.array(FREQUENCIES))
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
    step_s: float = 1e-3,
    amplitude: float = 0.3,
    time: np.ndarray | None = None,
) -> Record:
    """A record of a model's torques along the motion."""
    rng = np.random.default_rng(seed)
    time = np.arange(rows) * step_s if time is None else time
    angles, rates, accelerations = motion(len(model.arm.joints), time, amplitude)
    torques = model.inverse_dynamics(angles, rates, accelerations)
    noisy = angles + ANGLE_NOISE * rng.normal(size=angles.shape)
    return Record(
        "a record", time, noisy, None, torques + TORQUE_NOISE * rng.normal(size=angles.shape)
    )


def compared(record: Record, arm: Arm, **tolerances: float) -> RecordComparison:
    """Of engines that agree, without a word of progress."""
    found = compare(record, arm, None, tolerances, lambda *doing: None)
    assert isinstance(found, RecordComparison)
    return found
