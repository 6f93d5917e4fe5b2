"""What the arm stands on and flies in: the free base of Section 2, gravity."""

from __future__ import annotations

import numpy as np
import xarray as xr

from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.measures.stage import PaperStage
from crosscheck.audit.statics.teeth import virtual_work
from crosscheck.checks.first_principles.weights import joint_mass, link_mass
from crosscheck.checks.trajectories import tip_position
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import ConstantDrive
from crosscheck.models.loading import Case, load_case, load_scenario
from crosscheck.models.pinocchio.floating import FloatingBase, PinocchioFloating
from crosscheck.registry import build

EVERY = "scenario.record_every=1000"  # 10 ms
FIXED_TOLERANCE = 1e-10  # relative, of the fixed arm's run
BASE_MASSES = ("5", "50", "500", "5000")  # over the arm's mass
CONSTANT = "constant-torque"
# The Earth's gravity parameter [m^3/s^2], and a low orbit's radius [m], 400 km up.
EARTH, ORBIT_M = 3.986e14, 6.771e6


def compute_base_errors(arm: str) -> Numbers:
    """Largest distance [mm] of the tip from where a fixed base would have it, by the base's mass.

    In the inertial frame, over the PD motion and over the constant torque's; the base is a
    homogeneous 2 m cube that shifts and turns.
    """
    cases = [load_case(arm, scenario, None, [EVERY]) for scenario in ("pd", CONSTANT)]
    errors = np.max([_tip_errors_m(case) for case in cases], axis=0)
    pairs = zip(BASE_MASSES, errors, strict=True)
    return {f"base_tip_{text}_mm": 1e3 * float(error) for text, error in pairs}


def _tip_errors_m(case: Case) -> list[float]:
    """The largest error of the tip [m] for every mass of the base."""
    fixed = build("pinocchio:coupled", *case).reference(FIXED_TOLERANCE)
    carried = arm_mass(case)
    bases = [FloatingBase(carried * float(ratio)) for ratio in BASE_MASSES]
    flights = (PinocchioFloating(case.arm, case.scenario, base).simulate() for base in bases)
    return [float(tip_error(flight, fixed, case).max()) for flight in flights]


def arm_mass(case: Case) -> float:
    """Mass [kg] of all that the base carries."""
    return PinocchioFloating(case.arm, case.scenario, FloatingBase(1.0)).arm_mass_kg


def tip_error(free: xr.Dataset, fixed: xr.Dataset, case: Case) -> np.ndarray:
    """Distance [m] (times,) in the inertial frame between the tips on the two bases."""
    local = tip_position(free, case.arm).values
    x, y, angle = free["base"].values.T
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    flying = np.column_stack([x, y]) + np.einsum("ijt,tj->ti", turn, local)
    return np.linalg.norm(flying - tip_position(fixed, case.arm).values, axis=1)


def compute_neglected_torques(arm: Arm, stage: PaperStage) -> Numbers:
    """Torques that Section 2.4's energies leave out, over the 100 N m of Section 3.1 [1]."""
    drive = load_scenario(CONSTANT).drive
    assert isinstance(drive, ConstantDrive)
    torque = float(np.max(drive.torque_N_m))
    return {
        "gravity_share": gravity_gradient(arm) / torque,
        "virtual_work_share": virtual_work(stage, torque) / torque,
    }


def gravity_gradient(arm: Arm) -> float:
    """Largest torque [N m] on the stretched arm in a low orbit about its shoulder: 3/2 w^2 I.

    I of its masses at their centres.
    """
    inner, outer = arm.links
    elbow, tip = inner.length_m, inner.length_m + outer.length_m
    places = [inner.com_m, elbow + outer.com_m, elbow, tip]
    masses = [*map(link_mass, arm.links), joint_mass(arm.joints[1]), arm.payload_mass_kg]
    inertia = float(np.dot(masses, np.square(places)))
    return 1.5 * EARTH / ORBIT_M**3 * inertia
