"""One joint alone, its planets free and its teeth plain: all that its meshes do is k x."""

from typing import Any, TypeVar

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.interface import Model
from crosscheck.registry import build
from tests.mixed_arms import scenario

SPRINGS_ONLY = (
    "arm.joints.*.*_mesh.stiffness.amplitude_N_per_m=0.0",
    "arm.joints.*.*_mesh.tooth_error_m=0.0",
    "arm.joints.*.*_mesh.damping_ratio=0.0",
    "scenario.drive.torque_N_m=0.0",
)
Of = TypeVar("Of", bound=Model)
Data = dict[str, Any]


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


def first_joint_only(model: Of) -> Of:
    """The same model of the arm's first joint and link alone."""
    arm = model.arm.model_copy(
        update={"joints": model.arm.joints[:1], "links": model.arm.links[:1]}
    )
    return type(model)(arm, model.scenario, model.switches)
