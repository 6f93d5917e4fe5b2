"""Faults in the analytic model's single planets and conservative springs, and what sees each."""

from __future__ import annotations

import pytest

from tests.faults.faults import CONTACT, FORCE, MASS, Fault, assert_seen
from tests.faults.test_analytic_faults import F_SP, X_PR, X_SP, change

APART = "planets-apart"
CONSERVATIVE = (("mesh_work", "conservative"),)


def fault(name: str, function: str, old: str, new: str, check: str = FORCE, laws=()) -> Fault:
    return Fault(name, change(function, old, new), check, laws, arm=APART)


STATES = [
    fault(
        "sun that advances twice",
        "derivation.chain:Chain.sun_row",
        'self.row("x_s", joint)',
        '2 * self.row("x_s", joint)',
        MASS,
    ),
    fault(
        "sun feels one flank's sign",
        "derivation.efforts:_stage_rows",
        "x_pr - advance",
        "x_pr + advance",
    ),
    fault("ring pulls", "derivation.efforts:_stage_rows", "advance, -x_pr", "advance, x_pr"),
    fault(
        "first planet's sun mesh for all",
        "derivation.gears:_meshes_of",
        "sun_mesh.of_planet(planet)",
        "sun_mesh.of_planet(0)",
    ),
    fault(
        "first planet's ring mesh for all",
        "derivation.gears:_meshes_of",
        "ring_mesh.of_planet(planet)",
        "ring_mesh.of_planet(0)",
    ),
    fault(
        "every planet damps for all",
        "derivation.gears:_meshes_of",
        "if layout.free else 1\n        d_sp",
        "if not layout.free else 1\n        d_sp",
    ),
    fault(
        "first planet's damping",
        "derivation.gears:_meshes_of",
        "damping(joint, planet)",
        "damping(joint)",
    ),
    fault(
        "first planet's phase",
        "derivation.gears:_meshes_of",
        "mesh_phases(joint, planet)",
        "mesh_phases(joint, 0)",
    ),
    fault("planets the other way round", "paper.mesh_phasing:sun_lag", "joint.sun", "-joint.sun"),
    fault("ring's teeth come later", "paper.mesh_phasing:ring_lag", "-joint.ring", "joint.ring"),
    fault(
        "planet's other flank forgotten",
        "paper.mesh_phasing:ring_behind_sun",
        "else 0.5",
        "else 0.0",
    ),
    fault("odd planets half a tooth off", "paper.mesh_phasing:ring_behind_sun", "0.0 if", "0.5 if"),
    fault(
        "error in phase with the stiffness",
        "derivation.gears:gears",
        "entry.mesh.tooth_error_phase_rad",
        "0.0",
    ),
    fault("planets in their places", "derivation.gears:gears", "entry.mesh.static_error_m", "0.0"),
    fault(
        "error the other way",
        "kernel.numbers:_of_mesh",
        "gears.static[mesh]",
        "-gears.static[mesh]",
    ),
    fault("sun mesh without its planet", "kernel.text.terms:_forces", "if less >= 0", "if False"),
    fault(
        "planet's side of the damper lost",
        "kernel.text.terms:_taken",
        'f"D_{mesh}"',
        'f"0.0 * D_{mesh}"',
    ),
    fault(
        "contact judged without the planet",
        "kernel.text.meshes:_mesh",
        "abs(gap_{mesh})",
        "abs(gap_{mesh} + x_{mesh[:-1]}1)",
        FORCE,
        CONTACT,
    ),
    fault(
        "springs leave the angle alone",
        "kernel.text.terms:_taken",
        "if s.conservative",
        "if False",
        FORCE,
        CONSERVATIVE,
    ),
    fault(
        "stiffness does no work",
        "kernel.text.meshes:_on_angle",
        " - ({' + '.join(slopes)}) * travel * travel / 2.0",
        "",
        FORCE,
        CONSERVATIVE,
    ),
    fault(
        "error does no work",
        "kernel.text.meshes:_on_angle",
        "F_{mesh} * error_slope",
        "0.0",
        FORCE,
        CONSERVATIVE,
    ),
    fault(
        "springs push the other way",
        "kernel.text.meshes:_on_angle",
        "on_theta{j} + slope",
        "on_theta{j} - slope",
        FORCE,
        CONSERVATIVE,
    ),
    fault(
        "angle for phase",
        "kernel.text.meshes:_on_angle",
        "slope_{own} * on_phase",
        "on_phase",
        FORCE,
        CONSERVATIVE,
    ),
    fault(
        "slope of the first harmonic alone",
        "kernel.text.meshes:_on_angle",
        "{float(n)!r} * (",
        "(",
        FORCE,
        CONSERVATIVE,
    ),
]

RUNS = [
    fault("sun at the last contact", "model:AnalyticModel._place_teeth", ".min()", ".max()", X_SP),
    fault(
        "start without the standing error",
        "model:AnalyticModel._place_teeth",
        "(self.gears.static + self.gears.b)",
        "self.gears.b",
        X_PR,
    ),
    fault(
        "records of the first planet",
        "model:AnalyticModel._per_planet",
        "values[:, first:after]",
        "values[:, first : first + 1]",
        F_SP,
    ),
]


@pytest.mark.parametrize("fault", STATES, ids=lambda fault: fault.name)
def test_fault_turns_its_check_red(fault: Fault):
    assert_seen(fault, "analytic:physical", "pinocchio:gears")


@pytest.mark.parametrize("fault", RUNS, ids=lambda fault: fault.name)
def test_fault_in_a_run_turns_its_check_red(fault: Fault):
    assert_seen(fault, "analytic:physical", "exudyn:tree")
