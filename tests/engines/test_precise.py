"""Runs by steps of chosen length, precise and reference, beside SciPy's and beside themselves."""

import numpy as np
import pytest

from crosscheck.analytic.kernel.adaptive_kernel import integrate_precisely, integrate_reference
from crosscheck.analytic.model import PhysicalModel
from crosscheck.models.loading import load_case
from tests.engines.precise_steps import compare_works
from tests.engines.scipy_runs import integrate_by_scipy

ARMS = [
    ("paper-labelled", {"planets": "lumped"}),
    ("paper-labelled", {"phase": "omega_t", "damping": "contact"}),
    ("paper-labelled", {"dead_zone": "tanh"}),
    ("planets-apart", {"planets": "free", "mesh_work": "conservative"}),
    ("direct-between", {}),  # with a table of stiffnesses
]


def model_of(arm: str, switches: dict[str, str], duration_s: float = 0.02) -> PhysicalModel:
    settings = [f"scenario.duration_s={duration_s}", "scenario.start.planet_ring_offset_m=-2e-5"]
    return PhysicalModel(*load_case(arm, "constant-torque", switches, settings))


@pytest.mark.parametrize(("arm", "switches"), ARMS)
def test_runs_agree_with_scipy_as_well_as_scipy_with_itself(arm, switches):
    """SciPy steps over contact changes: it is off by what a hundredfold tolerance moves it."""
    model = model_of(arm, switches, 0.004)
    (fine, work), (coarse, _) = (integrate_by_scipy(model, rtol) for rtol in (1e-11, 1e-9))
    allowed = np.maximum(np.abs(coarse - fine).max(axis=0), 1e-9 * np.abs(fine).max(axis=0))
    reference = integrate_reference(model, model.term_equations, 1e-11)
    for run in (reference, integrate_precisely(model, 1e-11)):
        assert (np.abs(run.records.q - fine).max(axis=0) <= allowed).all()
    assert list(compare_works(reference.works, work)) == []
    trajectory = model.reference(1e-11)
    for name, column in (("work", 0), ("work_turned_over", 1)):
        np.testing.assert_array_equal(trajectory[name].values, reference.works[:, column])


def test_no_contact_comes_and_goes_within_a_step():
    model = model_of("planets-apart", {"planets": "free"}, 0.1)
    changes = [integrate_precisely(model, rtol).changes for rtol in (1e-3, 1e-5, 1e-12)]
    assert changes == [121] * 3
