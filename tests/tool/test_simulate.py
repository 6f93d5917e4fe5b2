"""`crosscheck simulate` and the file that it writes."""

import json

import numpy as np
import pytest
import xarray as xr

from crosscheck.models.loading import load_case

UNITS = {
    "theta": "rad",
    "theta_dot": "rad s-1",
    "theta_ddot": "rad s-2",
    "torque": "N m",
    "x_sp": "m",
    "x_pr": "m",
    "F_sp": "N",
    "F_pr": "N",
}
MESH = {"x_sp", "x_pr", "F_sp", "F_pr"}


def written(folder) -> xr.Dataset:
    """The trajectory, which must be all that a command left in its folder."""
    assert [path.name for path in folder.iterdir()] == ["run.nc"]
    return xr.load_dataset(folder / "run.nc", engine="h5netcdf")


@pytest.mark.parametrize("model", ["analytic:physical", "exudyn:tree"])
def test_geared_run_is_written_with_dimensions_and_units(short, tmp_path, model):
    answer = short(model=model)
    assert (answer.code, answer.err) == (0, "")
    run = written(tmp_path)
    assert dict(run.sizes) == {"time": 21, "joint": 2, "planet": 3}
    for name, units in UNITS.items():
        dims = ("time", "joint", "planet") if name in MESH else ("time", "joint")
        assert (run[name].dims, run[name].attrs["units"]) == (dims, units)
        assert run[name].attrs["long_name"]
        assert np.isfinite(run[name]).all()
    assert run["time"].attrs["units"] == "s"
    assert run.attrs["Conventions"].startswith("CF-")


@pytest.mark.parametrize("model", ["analytic:coupled", "pinocchio:coupled"])
def test_rigid_run_leaves_the_mesh_variables_out(short, tmp_path, model):
    assert short(model=model).code == 0
    run = written(tmp_path)
    assert dict(run.sizes) == {"time": 21, "joint": 2}
    assert MESH.isdisjoint(run.variables)
    assert UNITS.keys() - MESH <= set(run.variables)


def test_attributes_say_what_was_run(short, tmp_path):
    laws = ("switches.phase=omega_t", "switches.ring_rate=corrected")
    numbers = ("arm.joints.1.*_mesh.backlash_m=2e-5", "scenario.start.theta_rad=[0.5, 0.25]")
    short(settings=(*laws, *numbers))
    run = written(tmp_path)
    assert json.loads(run.attrs["switches"]) == {
        "phase": "omega_t",
        "ring_rate": "corrected",
        "dead_zone": "exact",
        "damping": "always",
        "planets": "lumped",
        "mesh_work": "paper",
    }
    joints = json.loads(run.attrs["arm"])["joints"]
    meshes = [joint[mesh] for joint in joints for mesh in ("sun_mesh", "ring_mesh")]
    assert [mesh["backlash_m"] for mesh in meshes] == [5e-5, 5e-5, 2e-5, 2e-5]
    np.testing.assert_array_equal(run["x_sp"][0].T, [[5e-5, 2e-5]] * 3)
    np.testing.assert_array_equal(run["theta"][0], [0.5, 0.25])
    assert json.loads(run.attrs["scenario"])["duration_s"] == 0.002
    assert run.attrs["model"] == "analytic:physical"
    assert run.attrs["schema_version"] == 1
    assert "--set switches.ring_rate=corrected" in run.attrs["command"]
    assert {"versions", "arm_sha256", "revision"} <= json.loads(run.attrs["provenance"]).keys()


def test_a_star_in_a_name_passes_over_joints_that_have_none():
    settings = ["arm.joints.*.*_mesh.backlash_m=1e-5"]
    joints = load_case("direct-between", "constant-torque", settings=settings).arm.joints
    meshes = [mesh for j in joints if j.kind != "direct" for mesh in (j.sun_mesh, j.ring_mesh)]
    assert [mesh.backlash_m for mesh in meshes] == [1e-5] * 4


def test_stage_with_fewer_planets_is_padded_with_nan(short, tmp_path):
    settings = ("arm.joints.1.sun_teeth=27", "arm.joints.1.planet_count=2")
    assert short(settings=settings).code == 0
    run = written(tmp_path)
    assert np.isnan(run["F_sp"][:, 1, 2]).all()
    assert np.isfinite(run["F_sp"][:, 1, :2]).all()
