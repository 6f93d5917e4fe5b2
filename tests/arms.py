"""Arms of any number of joints, for identities that hold for all of them."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from models.arm import Arm
from models.loading import load_arm

PAPER = load_arm("paper-labelled")


def arm_of(joints: int, scale: float = 1.0) -> Arm:
    """An arm of this many joints, all different from each other in mass and length."""
    shrink = [scale * (1 - 0.11 * number) for number in range(joints)]
    return PAPER.model_copy(
        update={
            "name": f"{joints}-joint",
            "joints": tuple(
                PAPER.joints[0].model_copy(
                    update={
                        "sun_equivalent_mass_kg": 0.5 * factor,
                        "planet_mass_kg": 0.61 * factor,
                        "ring_inertia_kg_m2": 0.18 * factor,
                        "mesh_stiffness_N_per_m": 1e8 * factor,
                    }
                )
                for factor in shrink
            ),
            "links": tuple(
                PAPER.links[0].model_copy(update={"length_m": f, "com_m": 0.4 * f}) for f in shrink
            ),
        }
    )


arms = st.builds(arm_of, st.integers(1, 4), st.floats(0.3, 3.0))


def random_arm(seed: int, most_joints: int = 4) -> Arm:
    """A valid arm of joints unlike one another, each number within a factor of the paper's arm."""
    draw = np.random.default_rng(seed)
    joints = int(draw.integers(1, most_joints + 1))

    def near(value: float, factor: float = 3.0) -> float:
        return float(value * factor ** draw.uniform(-1, 1))

    def joint() -> dict[str, object]:
        stiffness = near(1e8)
        return {
            **_gear_set(draw),
            "module_m": near(0.003, 2),
            "pressure_angle_deg": float(draw.uniform(14.5, 28)),
            "sun_equivalent_mass_kg": near(0.5),
            "planet_equivalent_mass_kg": near(0.66),
            "carrier_equivalent_mass_kg": near(5.8),
            "sun_mass_kg": near(0.4),
            "planet_mass_kg": near(0.6),
            "carrier_mass_kg": near(6.3),
            "ring_mass_kg": near(10),
            "ring_inertia_kg_m2": near(0.18) * int(draw.integers(2)),
            "backlash_m": near(5e-5) * int(draw.integers(8) > 0),
            "mesh_stiffness_N_per_m": stiffness,
            "mesh_stiffness_amplitude_N_per_m": stiffness * float(draw.uniform(0, 0.4)),
            "tooth_error_m": near(5e-6),
            "ring_mesh_phase_rad": float(draw.uniform(-3, 3)),
            "damping_ratio": near(0.05, 2),
        }

    def link() -> dict[str, object]:
        length = near(0.8, 2)
        return {
            "length_m": length,
            "com_m": length * float(draw.uniform(0.3, 0.7)),
            "cross_section_m2": near(0.01, 2),
            "density_kg_per_m3": near(2700, 2),
        }

    return Arm.model_validate(
        {
            "schema_version": 1,
            "name": f"random-{seed}",
            "payload_mass_kg": near(10),
            "joints": [joint() for _ in range(joints)],
            "links": [link() for _ in range(joints)],
        }
    )


def _gear_set(draw: np.random.Generator) -> dict[str, int]:
    """Teeth and planets that assemble and clear each other."""
    while True:
        sun, planet = (int(teeth) for teeth in draw.integers(15, 45, 2))
        count = int(draw.integers(2, 6))
        clear = (sun + planet) * np.sin(np.pi / count) > planet + 2
        if clear and (2 * sun + 2 * planet) % count == 0:
            return {
                "sun_teeth": sun,
                "planet_teeth": planet,
                "ring_teeth": sun + 2 * planet,
                "planet_count": count,
            }
