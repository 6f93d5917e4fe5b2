"""Arms with few numbers alike: geared and direct joints, every law."""

from collections.abc import Sequence

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout
from crosscheck.models.experiment.scenario import Scenario

Data = dict[str, object]
State = tuple[np.ndarray, np.ndarray]
GRAVITY, NONE = (3.1, -9.2), (0.0, 0.0)
TEETH = {"sun_teeth": 30, "planet_teeth": 30, "ring_teeth": 90, "planet_count": 4}
R_S = R_P = 0.0025 * 30 / 2 * np.cos(np.radians(20))
SUN_J, PLANET_M = 4.5e-4, 0.7
LAWS: dict[str, Data] = {
    "sine": {"law": "sine", "mean_N_per_m": 8e7, "amplitude_N_per_m": 1.5e7},
    "fourier": {
        "law": "fourier",
        "mean_N_per_m": 9e7,
        "cosine_N_per_m": [1e7, -3e6, 2e6],
        "sine_N_per_m": [6e6],
    },
    "square": {
        "law": "square",
        "contact_ratio": 1.6,
        "least_N_per_m": 6e7,
        "largest_N_per_m": 1e8,
        "harmonics": 7,
    },
    "table": {
        "law": "table",
        "phase_cycles": [0.0, 0.13, 0.2, 0.45, 0.7, 0.86, 1.0],
        "stiffness_N_per_m": [8e7, 9.5e7, 1e8, 7e7, 6e7, 8.5e7, 8e7],
    },
}


def geared(sun: str = "sine", ring: str = "sine", **changes: object) -> Data:
    sun_mesh = {
        "stiffness": LAWS[sun],
        "backlash_m": 4e-5,
        "tooth_error_m": 2e-5,
        "phase_rad": 0.9,
        "damping_ratio": 0.06,
        "tanh_sharpness_per_m": 3e4,
    }
    ring_mesh = {
        "stiffness": LAWS[ring],
        "backlash_m": 3e-5,
        "tooth_error_m": 1e-5,
        "phase_rad": -0.4,
        "damping_ratio": 0.04,
        "tanh_sharpness_per_m": 2e4,
    }
    return {
        "kind": "planetary",
        **TEETH,
        "module_m": 0.0025,
        "pressure_angle_deg": 20.0,
        "sun_inertia_kg_m2": SUN_J,
        "planet_equivalent_mass_kg": PLANET_M,
        "carrier_inertia_kg_m2": 0.03,
        "sun_mass_kg": 0.36,
        "planet_mass_kg": 0.52,
        "carrier_mass_kg": 5.5,
        "ring_mass_kg": 8.0,
        "ring_inertia_kg_m2": 0.11,
        "sun_mesh": sun_mesh,
        "ring_mesh": ring_mesh,
        **changes,
    }


def direct(**changes: object) -> Data:
    return {"kind": "direct", "motor_mass_kg": 2.5, "rotor_inertia_kg_m2": 0.07, **changes}


ROD: Data = {"length_m": 0.9, "com_m": 0.4, "cross_section_m2": 0.004, "density_kg_per_m3": 2700.0}
BODY: Data = {"length_m": 0.7, "com_m": 0.25, "mass_kg": 6.0, "inertia_kg_m2": 0.5}
ROD_MASS = 0.9 * 0.004 * 2700
PAYLOAD = 3.0


def arm_of(
    *joints: Data,
    links: Sequence[Data] | None = None,
    payload_kg: float = PAYLOAD,
    gravity: tuple[float, float] = GRAVITY,
    name: str = "arm",
) -> Arm:
    """Of these joints and links; if none are given, rod and body take turns."""
    if links is None:
        links = [(ROD, BODY)[place % 2] for place in range(len(joints))]
    return Arm.model_validate(
        {
            "schema_version": 2,
            "name": name,
            "payload_mass_kg": payload_kg,
            "gravity_m_per_s2": gravity,
            "joints": joints,
            "links": links,
        }
    )


def scenario(torque: float | list[float] = 0.0, **changes: object) -> Scenario:
    return Scenario.model_validate(
        {
            "schema_version": 1,
            "name": "test",
            "duration_s": 1e-4,
            "step_s": 1e-6,
            "record_every": 10,
            "drive": {"kind": "constant", "torque_N_m": torque},
            **changes,
        }
    )


MIXED = {
    "direct-geared": arm_of(direct(friction_N_m_s_per_rad=4.0), geared("table", "square")),
    "geared-direct": arm_of(geared("fourier", "table"), direct()),
    "geared-direct-geared": arm_of(
        geared("square", "sine", friction_N_m_s_per_rad=9.0),
        direct(friction_N_m_s_per_rad=2.0),
        geared("sine", "fourier", planet_count=3),
    ),
    "direct-direct": arm_of(direct(), direct(friction_N_m_s_per_rad=3.0)),
}


def random_states(layout: Layout, count: int, seed: int = 3) -> list[State]:
    """Every mesh in or around its play, joints about a radian and a radian per second."""
    draw, scale = np.random.default_rng(seed), np.where(layout.angular, 1.0, 1e-4)
    return [
        (scale * draw.normal(size=scale.size), scale * draw.normal(size=scale.size))
        for _ in range(count)
    ]
