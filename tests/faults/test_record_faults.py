"""Faults in what a run records, seen by the same-step comparison of whole records."""

from __future__ import annotations

import pytest

from tests.faults.faults import OMEGA_T, Fault, assert_seen, edit
from tests.faults.test_analytic_faults import template

FIRST = "first_stage(at(w, block * BLOCK), t, sqrt(t), table"
PARTNER = {"analytic:physical": "exudyn:tree", "exudyn:tree": "analytic:physical"}
TRAJECTORY = "crosscheck.models.exudyn.tree.tree:ExudynTree._trajectory"
TORQUES = "crosscheck.models.exudyn.tree.tree:ExudynTree._torques"
RECORDS = {
    "analytic:physical": [
        Fault(
            "rates recorded of the meshes",
            edit(
                "crosscheck.analytic.model:AnalyticModel.recorded",
                '"theta_dot": v[:, theta]',
                '"theta_dot": v[:, theta - 1]',
            ),
            "same-step/theta_dot",
        ),
        Fault(
            "accelerations recorded without the clock",
            template(FIRST, FIRST.replace("t, sqrt(t)", "0.0, 0.0")),
            "same-step/theta_ddot",
            OMEGA_T,
            kernel="terms",
        ),
        Fault(
            "torques recorded without the clock",
            edit(
                "crosscheck.models.experiment.drive:torques_along",
                "time[:, None]",
                "0 * time[:, None]",
            ),
            "same-step/torque",
            (),
            "sinusoid",
        ),
    ],
    "exudyn:tree": [
        Fault(
            "rates recorded of the suns",
            edit(TRAJECTORY, "theta_dot=theta_dot", "theta_dot=2 * theta_dot"),
            "same-step/theta_dot",
        ),
        Fault(
            "accelerations recorded of the next bodies",
            edit(TRAJECTORY, "a[:, links]", "a[:, [link + 1 for link in links]]"),
            "same-step/theta_ddot",
        ),
        Fault(
            "torques recorded with the shoulder's gains",
            edit(TORQUES, "law.gains[joint]", "law.gains[0]"),
            "same-step/torque",
        ),
        Fault(
            "twice the kinetic energy recorded",
            edit(
                "crosscheck.models.exudyn.tree.tree:ExudynTree.simulate", "mass @ v / 2", "mass @ v"
            ),
            "same-step/kinetic_energy",
        ),
    ],
}


@pytest.mark.parametrize(
    ("model", "fault"),
    [
        pytest.param(model, fault, id=f"{model}: {fault.name}")
        for model, faults in RECORDS.items()
        for fault in faults
    ],
)
def test_fault_in_a_record_turns_its_check_red(model: str, fault: Fault):
    assert_seen(fault, model, PARTNER[model])
