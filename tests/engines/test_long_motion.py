"""Sized motions of several joints, through many a mesh period: symbols against Exudyn's tree.

Both take the same Runge-Kutta steps, so that all that may part them is rounding.
"""

import numpy as np
import pytest
import xarray as xr

from crosscheck.cli.files.template import example_arm
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import MESHES
from crosscheck.models.loading import load_arm
from crosscheck.planning.sizing import compute_sizes, make_pd_scenario
from crosscheck.registry import build, find_same_integrator_models

# Of the largest stable step. How well a step follows the motion is no question here: both take the
# same ones. Exudyn needs 0.2 ms a step for three joints, 0.7 ms for six.
MARGIN, RECORDS = 1.25, 1000
MESH_TOLERANCE_M = 1e-13


def motion(arm: Arm, duration_s: float) -> list[xr.Dataset]:
    """The controlled motion sized to an arm, its beginning, by each model with that integrator."""
    sized = make_pd_scenario(compute_sizes(arm))
    names = find_same_integrator_models()
    longest = min(build(name, arm, sized).largest_stable_step() for name in names) / MARGIN
    stride = int(np.ceil(duration_s / longest / RECORDS))
    step = duration_s / (stride * RECORDS)
    settings = {"duration_s": duration_s, "step_s": step, "record_every": stride}
    scenario = sized.model_copy(update=settings)
    return [build(name, arm, scenario).simulate() for name in names]


def apart(runs: list[xr.Dataset], variable: str) -> float:
    """Largest difference of a variable over the whole run."""
    one, other = (run[variable].values for run in runs)
    return float(np.nanmax(np.abs(one - other)))


# The arm, how long it moves [s], how far each joint turns at least, what rounding grows to [rad].
MOTIONS = {
    "three joints under weight": (load_arm("three-unlike"), 0.5, 0.15, 1e-10),
    "planets apart": (load_arm("planets-apart"), 0.5, 0.15, 1e-10),
    "six joints": (example_arm("six", 6), 0.2, 0.15, 1e-9),
    "direct joint between": (load_arm("direct-between"), 0.1, 0.05, 1e-10),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MOTIONS)
def test_both_models_move_together_through_many_mesh_periods(name):
    arm, duration_s, turned_rad, theta_tolerance_rad = MOTIONS[name]
    runs = motion(arm, duration_s)
    theta, force = runs[0]["theta"].values, runs[0]["F_sp"].values
    assert (np.ptp(theta, axis=0) > turned_rad).all()
    for joint in np.flatnonzero(~np.isnan(force[0, :, 0])):
        assert {*(force[:, joint, 0] == 0)} == {True, False}  # teeth have parted and touched
    if name == "planets apart":
        assert np.ptp(runs[0]["x_pr"].values[:, 1], axis=1).max() > 1e-5
    assert apart(runs, "theta") < theta_tolerance_rad
    for mesh in MESHES:
        assert apart(runs, mesh) < MESH_TOLERANCE_M
