"""The Python API: what notebooks and the command line both use."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from crosscheck.models.errors import CannotDo, InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.interface import Model
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.models.mechanism import Mechanism, adopt_mechanism
from crosscheck.models.robot.file import load_robot
from crosscheck.registry import build

if TYPE_CHECKING:
    import xarray as xr

    from crosscheck.report.summary import CheckResult


__all__ = [
    "build",
    "check",
    "load_arm",
    "load_robot",
    "load_scenario",
    "require_stable_step",
    "simulate",
]

TIGHTEST_RTOL, LOOSEST_RTOL = 1e-13, 1e-2  # rounding; what still follows the mesh modes


def simulate(model: Model, *, force: bool = False, rtol: float | None = None) -> xr.Dataset:
    """Run a model's scenario from its start.

    Args:
        model: A model that has ``simulate`` among its ``abilities``, or, for ``rtol``, ``precise``.
        force: Whether to run although the scenario's step is too large for the mesh modes.
        rtol: Relative tolerance, 1e-13 to 1e-2, of adaptive steps in place of the scenario's fixed
            one; they end where contacts change.

    Returns:
        The run, over ``time`` [s] and ``joint``, and ``planet`` for mesh variables: angles [rad]
        relative to the previous link, their derivatives, torques [N m] on the output side,
        energies [J] and, of geared models, mesh displacements [m] and forces [N].

    Raises:
        InputError: The model cannot do so, ``rtol`` is out of its range, or the step is too large.
        Diverged: The run left the range in which its numbers mean anything.
    """
    if rtol is not None:
        if not TIGHTEST_RTOL <= rtol <= LOOSEST_RTOL:
            raise InputError("--rtol", "", rtol, f"must be {TIGHTEST_RTOL:g} to {LOOSEST_RTOL:g}")
        try:
            return model.precise(rtol)
        except CannotDo as error:
            raise InputError("--rtol", "", rtol, str(error)) from None
    if "simulate" not in model.abilities:
        raise InputError("model", "", model.name, "has states only, it cannot simulate")
    if not force:
        require_stable_step(model)
    return model.simulate()


def require_stable_step(model: Model) -> None:
    """Raise InputError unless the scenario's step is within the integrator's stability limit."""
    limit, scenario = model.largest_stable_step(), model.scenario
    if scenario.step_s > limit:
        allowed = f"the largest stable step of {model.name} is {limit:.3g} s (--force goes on)"
        raise InputError(scenario.name, "step_s", scenario.step_s, allowed)


def check(
    arm: Mechanism | str = "paper-labelled",
    *,
    scenarios: Sequence[Scenario | str] = (),
    quick: bool = False,
    jobs: int = 1,
    seed: int = 0,
) -> CheckResult:
    """Run every check on an arm or a robot: states, trajectories, levels.

    Args:
        arm: An arm or a robot, or the built-in name or TOML file of one, or a URDF.
        scenarios: What to run in place of the usual experiments, which are the paper's or sized to
            the arm or robot: scenarios, or their built-in names or files.
        quick: Whether to check fewer states, and shorter experiments.
        jobs: How many processes run models side by side.
        seed: Seed of the random states, 0 to 4294967295.

    Returns:
        The findings of all comparisons, with the exit code that the command has for them.

    Raises:
        InputError: Arm, robot or scenarios cannot be read or run, or do not fit each other.
        Unfinished: Models that prepare the experiments do not answer.
    """
    from crosscheck.planning.plan import request_cross_check
    from crosscheck.report.summary import CheckResult
    from crosscheck.run import run_cross_check

    request = request_cross_check(adopt_mechanism(arm, scenarios), quick, seed)
    checked = run_cross_check(request, jobs=jobs)
    return CheckResult(**vars(checked.agreement), cross_check=checked)
