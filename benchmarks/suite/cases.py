"""The arms and runs that the parts share."""

from __future__ import annotations

from typing import Literal

from crosscheck.analytic.model import PhysicalModel
from crosscheck.cli.files.template import example_arm
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import load_arm, load_case, load_scenario

Counted = Literal["lumped", "free"]
RECORDS = 10


def build_long_run(joints: int, counted: Counted, steps: int) -> PhysicalModel:
    """The paper's arm under PD control, or the template's of so many joints under constant torque.

    Steps of 1 us, so that every mesh is resolved and nothing grows.
    """
    paper = joints == 2
    arm = load_arm("paper-labelled") if paper else example_arm("template", joints)
    step_s = 1e-6
    update = {
        "duration_s": steps * step_s,
        "step_s": step_s,
        "record_every": steps // RECORDS,
    }
    scenario = load_scenario("pd" if paper else "constant-torque").model_copy(update=update)
    return PhysicalModel(arm, scenario, switches(planets=counted))


def build_pd_run(damping_ratio: float, start_moved_m: float = 0.0) -> PhysicalModel:
    """PD control of the paper's arm for 3 s by steps of 10 us, recorded every 100.

    start_moved_m [m]: what every sun mesh is displaced at the start.
    """
    settings = (
        f"arm.joints.*.*_mesh.damping_ratio={damping_ratio}",
        f"scenario.start.sun_planet_offset_m={start_moved_m}",
        "scenario.step_s=1e-5",
        "scenario.record_every=10",
    )
    return PhysicalModel(*load_case("paper-labelled", "pd", settings=settings))
