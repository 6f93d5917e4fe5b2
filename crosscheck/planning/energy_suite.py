"""Whole runs without dampers: kinetic, spring and weight's energy against the motors' work."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from crosscheck.checks import energy
from crosscheck.checks.scales import geared_joints, largest_torques
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.meshes import replace_damping
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import Comparison, make_comparison
from crosscheck.planning.plan import SHORT_RESOLVED, Experiment, remove_backlash, resolved_step
from crosscheck.planning.sizing import make_bent_scenario
from crosscheck.registry import (
    find_covering_models,
    find_same_integrator_models,
    reference_model,
    select_with_method,
)
from crosscheck.runner.tasks import RunKey, Simulation

if TYPE_CHECKING:
    import xarray as xr

Judge = Callable[[Subject, Any, Case], Finding]
STEPS, RECORDS = 2000, 50
# Leaves 2e-11 of the work turned over where teeth meet, 1e-10 leaves 2e-8. One step in some
# thousand may leap over an edge of play that its error estimate does not see, which costs 1e-8.
RTOL, FINER_RTOL = 1e-12, 3e-13
METRIC = "largest change of kinetic, spring and weight's energy less the motors' work"


def plan_energy_comparisons(arm: Arm, first: Experiment, limit_s: float) -> Iterator[Comparison]:
    """Energy balances of all models that run without backlash, and of the adaptive reference.

    A step across the edge of the backlash costs a fixed-step integrator more than the check allows;
    the adaptive one sees the edge. The energy that the paper's law makes out of nothing is measured
    beside. first: the experiment whose torques are tried; limit_s: largest stable step [s] of the
    arm's models.
    """
    if not geared_joints(arm):
        return
    step = resolved_step(first, limit_s, SHORT_RESOLVED)
    torques = largest_torques(arm, first.case.scenario)
    scenario = make_bent_scenario("energy", STEPS, RECORDS, step, torques)
    free = usual_switches(arm, planets="free")
    smooth_joints = tuple(
        joint.model_copy(update={"friction_N_m_s_per_rad": 0.0})
        for joint in replace_damping(arm, 0.0).joints
    )
    lossless = arm.model_copy(update={"joints": smooth_joints})
    springs = free.model_copy(update={"mesh_work": "conservative"})
    smooth = Experiment("energy", Case(remove_backlash(lossless), scenario, springs))
    # For integrators of second order: half as long, at a quarter of the step.
    half = {"duration_s": scenario.duration_s / 2, "step_s": scenario.step_s / 4}
    finer = smooth.case._replace(scenario=scenario.model_copy(update=half))
    fine = Experiment("energy-fine", finer)
    for model in select_with_method("simulate", find_covering_models("geared", lossless, springs)):
        experiment = smooth if model in find_same_integrator_models() else fine
        yield _plan_balance(experiment, energy.check_energy_conservation, experiment.run(model))
    impacts = Experiment("energy-impacts", Case(lossless, scenario, springs))
    again = _reference(impacts, "-finer", FINER_RTOL)
    yield _plan_balance(impacts, energy.check_energy_conservation, _reference(impacts), again)
    papers = Experiment("energy-paper", impacts.case._replace(switches=free))
    yield _plan_balance(papers, energy.measure_energy_drift, _reference(papers))


def _reference(experiment: Experiment, variant: str = "", rtol: float = RTOL) -> Simulation:
    return Simulation(
        RunKey(experiment.name, reference_model(), f"reference{variant}"), experiment.case, rtol
    )


def _plan_balance(experiment: Experiment, judge: Judge, *runs: Simulation) -> Comparison:
    """The energy balance of a run, or the best of several: what a law makes it makes in all."""
    key = ComparisonKey("invariants", experiment.name, "energy", runs[0].model)
    about = Subject(key, "J", METRIC, "first principles")

    def judge_runs(about: Subject, *runs: xr.Dataset) -> Finding:
        findings = [judge(about, each, experiment.case) for each in runs]
        return min(findings, key=lambda finding: finding.relative or 0.0)

    return make_comparison(about, runs, judge_runs)
