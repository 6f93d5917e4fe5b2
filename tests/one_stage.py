"""One joint alone, its planets free and its teeth plain: all that its meshes do is k x."""

from typing import Any

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.interface import Model
from crosscheck.registry import build
from tests.mixed_arms import scenario

Data = dict[str, Any]


def arm_of_stage(joint: Data, link: Data, payload_kg: float) -> Arm:
    """One joint and link, without weight."""
    return Arm.model_validate(
        {
            "schema_version": 2,
            "name": "one-stage",
            "payload_mass_kg": payload_kg,
            "joints": [joint],
            "links": [link],
        }
    )


def plain_mesh(stiffness: Data | list[Data], phase_rad: float | str) -> Data:
    """A mesh's fields, without play, error or damping."""
    teeth = {"backlash_m": 0.0, "tooth_error_m": 0.0, "damping_ratio": 0.0}
    return {"stiffness": stiffness, "phase_rad": phase_rad, **teeth}


def sine(mean: float, amplitude: float) -> Data:
    """The paper's law of stiffness."""
    return {"law": "sine", "mean_N_per_m": mean, "amplitude_N_per_m": amplitude}


def free_model(name: str, arm: Arm) -> Model:
    """In coordinates of single planets, without drive."""
    return build(name, arm, scenario(0.0, start={"mesh": "centre"}), switches(planets="free"))
