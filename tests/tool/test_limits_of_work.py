"""How long work may take, and how fine its steps must be: decided by numbers alone."""

import numpy as np
import pytest
import xarray as xr

from crosscheck.checks.answers import bias
from crosscheck.checks.scales import acceptance_limit
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import Case, load_case, load_scenario
from crosscheck.planning import preparation
from crosscheck.planning.plan import Experiment
from crosscheck.planning.preparation import _is_fine
from crosscheck.runner.cpu_limit import CpuTimeLimit
from crosscheck.runner.tasks import RunKey, Simulation, ask_model
from tests.arms import arm_of

CASE = Case(arm_of(1), load_scenario("constant-torque"), switches())
EXPERIMENT = Experiment("constant-torque", CASE)


@pytest.mark.parametrize(("diverging", "fine"), [("", True), ("coarse", False)])
def test_only_a_finer_step_is_sought_where_one_may_help(monkeypatch, diverging, fine):
    def runs(task: Simulation) -> None:
        assert task.key.variant in ("", diverging)
        if task.key.variant == diverging:
            raise Diverged(task.model, 0.1)

    monkeypatch.setattr(preparation, "_run", runs)
    assert _is_fine(EXPERIMENT) is fine


# How much smaller than what means something an uncertainty must be, 3 times a difference.
MARGINS = {"coarse": 2.0, "coarse-2": 1.1, "coarse-3": 1.1}


@pytest.mark.parametrize("quantity", ["theta", "x_sp", "x_pr"])
@pytest.mark.parametrize("variant", MARGINS)
def test_a_step_is_fine_where_each_coarser_run_is_near_enough(monkeypatch, variant, quantity):
    limit = acceptance_limit(quantity, CASE.arm, CASE.scenario, 1.0).value
    for part, fine in ((0.98, True), (1.02, False)):

        def run(task: Simulation, part: float = part) -> xr.Dataset:
            off = part * limit / (3 * MARGINS[variant]) * (task.key.variant == variant)
            values = {name: off * (name == quantity) for name in ("theta", "x_sp", "x_pr")}
            data = {name: ("time", np.array([0.0, value])) for name, value in values.items()}
            return xr.Dataset(data, {"time": [0.0, 1.0]})

        monkeypatch.setattr(preparation, "_run", run)
        assert _is_fine(EXPERIMENT) is fine


def watch(limit: CpuTimeLimit, clock: list[float], looks: int, use: float, each: float) -> str:
    """What is said after so many looks, some seconds apart, if a process uses so much in each."""
    said = limit.stop_reason({7: 30.0})  # from here on it counts
    for look in range(looks):
        clock[0] += each
        said = limit.stop_reason({7: 30.0 + use * (look + 1), 8: 0.0})
    return said


def test_work_has_a_minute_and_fifty_times_its_cost_of_processor_time(clock):
    """It had used 30 s before: 60 s + 50 x 0.2 s are over after 70 looks."""
    stopped = "stopped after 71 s of processor time, about 0.2 s expected"
    assert watch(CpuTimeLimit(7, 0.2), clock, 70, 1.0, 1.0) == ""
    assert watch(CpuTimeLimit(7, 0.2), clock, 71, 1.0, 1.0) == stopped
    # threads that wait busily use twice of what passes, which alone counts
    assert watch(CpuTimeLimit(7, 0.2), clock, 70, 2.0, 1.0) == ""
    assert watch(CpuTimeLimit(7, 0.2), clock, 71, 2.0, 1.0) == stopped
    # nobody looked for a minute in each look: two seconds of it count
    assert watch(CpuTimeLimit(7, 0.2), clock, 35, 60.0, 60.0) == ""
    assert watch(CpuTimeLimit(7, 0.2), clock, 36, 60.0, 60.0).startswith(
        "stopped after 72 s of processor"
    )


def test_work_that_uses_no_processor_is_stopped_after_a_minute(clock):
    stopped = "stopped after 61 s without any processor time"
    assert watch(CpuTimeLimit(7, 1.0), clock, 60, 1e-3, 1.0) == ""
    assert watch(CpuTimeLimit(7, 1.0), clock, 61, 1e-3, 1.0) == stopped
    # work before the last minute is none in it
    hung = CpuTimeLimit(7, 1.0)
    assert watch(hung, clock, 10, 1.0, 1.0) == ""
    for _ in range(61):
        clock[0] += 1.0
        said = hung.stop_reason({7: 40.0})
    assert said == stopped
    # a fifth of a second in a minute is work
    assert watch(CpuTimeLimit(7, 1.0), clock, 200, 0.2 / 59, 1.0) == ""
    # of a process that is not among the times, what passes counts as used
    elsewhere = CpuTimeLimit(9, 0.2)
    assert watch(elsewhere, clock, 71, 0.0, 1.0).startswith("stopped")
    assert elsewhere.begun == 0.0


def test_the_longest_work_is_begun_first():
    """Runs by their steps, four times as long where steps are chosen; questions by their states."""
    case = load_case("probe", "pd")
    key = RunKey("pd", "exudyn:tree")
    longer = case._replace(
        scenario=case.scenario.model_copy(update={"duration_s": 2 * case.scenario.duration_s})
    )
    once = Simulation(key, case).cost
    assert Simulation(key, longer).cost == pytest.approx(2 * once)
    assert Simulation(key, case, 1e-9).cost == pytest.approx(4 * once)
    one, many = (ask_model("exudyn:tree", case, bias, count).cost for count in (1, 101))
    more = ask_model("analytic:physical", case, bias, 101).cost
    assert many > more > 0
    assert (many - one) / 100 == pytest.approx(once / case.scenario.steps * 10)
