"""Arms of any number of joints, for identities that hold for all of them."""

from __future__ import annotations

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
