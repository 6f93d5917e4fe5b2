"""Models that are not the program's own: of installed packages, and registered for a while."""

import io
import json
import sys
from dataclasses import replace
from inspect import signature

import numpy as np
import pytest
import xarray as xr

from crosscheck import mechanisms, registry
from crosscheck.analytic.model import RigidLinks
from crosscheck.checks.answers import Setting, mass_matrix
from crosscheck.cli.simulation import SimulationRequest
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.loading import Selection, load_arm, load_case
from crosscheck.models.robot.file import load_robot
from crosscheck.planning.arms import plan_experiment_comparisons
from crosscheck.planning.comparison import Plan
from crosscheck.planning.plan import CrossCheckRequest, Experiment
from crosscheck.planning.robots import plan_robot
from crosscheck.provenance import record_provenance
from crosscheck.run import run_cross_check
from crosscheck.runner.tasks import Evaluation
from crosscheck.runner.workers import perform_all
from crosscheck.trial.trial import TrialSubject
from tests.judged import plan_states
from tests.loops import require_items
from tests.processes import command_line
from tests.tool.packages import ENTRY, offer

ARM = load_arm("probe")
CASE = load_case("probe", "pd")
EXPERIMENT = Experiment("pd", CASE)


def test_an_installed_packages_model_is_listed(tmp_path):
    """And its distribution counts for its results."""
    path = offer(tmp_path, ENTRY.format(", ('some-engine',), title='as a test [x]'"), "models")
    answer = command_line("list", env={"PYTHONPATH": path, "COLUMNS": "200"})
    assert (answer.returncode, answer.stderr) == (0, "")
    (line,) = (line.split() for line in answer.stdout.splitlines() if " guest " in line)
    assert line == ["guest", "states", "only,", "as", "a", "test", "[x]"]
    code = "from crosscheck.registry import MODELS; print(*MODELS['guest'].versioned_packages)"
    answer = command_line(env={"PYTHONPATH": path}, python=("-c", code))
    assert {"numpy", "some-engine", "guest-engine"} <= set(answer.stdout.split())


UNUSABLE = {
    "no import": ("import no_such_engine", "ModuleNotFoundError: No module named 'no_such_engine'"),
    "leaves at import": ("raise SystemExit('of\\nits own')", "SystemExit: of its own"),
    "nothing": ("", "AttributeError: module 'guest' has no attribute 'it'"),
    "a number": ("it = 3", "must be a crosscheck.registry.Entry, is int"),
    "a title that is no text": (ENTRY.format(", title=3"), "title is an int"),
    "no promises": (ENTRY.format("").replace("STATES)", "None)"), "promises is a NoneType"),
    "a role of its own": (ENTRY.format("").replace('"geared"', '"odd"'), "role is 'odd'"),
}


@pytest.mark.parametrize("case", UNUSABLE)
def test_an_unusable_offer_is_refused_by_the_name_of_its_package(tmp_path, case, monkeypatch):
    text, said = UNUSABLE[case]
    monkeypatch.syspath_prepend(offer(tmp_path, text, "models"))
    monkeypatch.delitem(sys.modules, "guest", raising=False)
    with pytest.raises(
        InputError, match="package guest-engine: entry point guest = 'guest:it'"
    ) as e:
        registry.add_installed_models(registry.BUILT_IN)
    assert said in str(e.value)


def test_an_offer_of_a_name_that_is_taken_is_refused(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(offer(tmp_path, ENTRY.format(""), "models", "exudyn:tree"))
    with pytest.raises(InputError, match=r"point exudyn:tree = 'guest:it'.* exists already"):
        registry.add_installed_models(registry.BUILT_IN)


def test_commands_without_models_do_not_look_at_it(tmp_path):
    path = offer(tmp_path, "import no_such_engine", "models")
    answer = command_line("--version", env={"PYTHONPATH": path})
    assert (answer.returncode, answer.stderr) == (0, "")


class Twice(RigidLinks):
    """Heavier than it should be."""

    name = "mine:twice"

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        return 2 * super().mass_matrix(q)


TWICE = replace(registry.MODELS["analytic:links"], made=Twice, packages=("pytest",))


def test_a_model_made_in_memory_takes_part_for_a_while():
    setting = Setting(CASE, "coupled", 2)
    task = Evaluation("mine:twice", setting, mass_matrix)
    whole = Evaluation("analytic:links", setting, mass_matrix)
    with registry.register("mine:twice", TWICE):
        assert isinstance(registry.build("mine:twice", ARM, CASE.scenario), Twice)
        assert registry.is_plugin("mine:twice")
        assert "pytest" in registry.packages()
        versions = record_provenance(ARM, 0, False, packages=registry.packages()).versions
        assert versions["pytest"] == pytest.__version__
        found = perform_all([task, whole], 2)
        np.testing.assert_array_equal(found[task], 2 * found[whole])
    assert "mine:twice" not in registry.MODELS
    assert not registry.is_plugin("mine:twice")


def test_provenance_has_what_was_asked_and_a_guests_distributions(monkeypatch):
    remarks, laws = ("known beforehand",), switches(phase="omega_t")
    scenario = CASE.scenario
    request = CrossCheckRequest(ARM, True, 7, (scenario,), laws)
    plan = Plan([], remarks, lambda results: iter(()))
    monkeypatch.setattr("crosscheck.planning.arms.plan_arm", lambda request, workers: plan)
    with registry.register("mine:twice", TWICE):
        whole = run_cross_check(request, jobs=1).agreement.provenance
        short = scenario.model_copy(update={"duration_s": 2 * scenario.step_s})
        run = SimulationRequest("mine:twice", Selection(ARM, (short,)), True).perform()
    assert whole is not None
    assert (whole.arm, whole.scenarios, whole.switches) == (ARM, (scenario,), laws)
    assert (whole.quick, whole.seed, whole.remarks) == (True, 7, remarks)
    assert isinstance(run, tuple)
    with xr.open_dataset(io.BytesIO(run[0]), engine="h5netcdf") as file:
        of_run = json.loads(file.attrs["provenance"])
    for versions in (whole.versions, of_run["versions"]):
        assert versions["pytest"] == pytest.__version__


def test_one_name_may_stand_for_one_model_after_another():
    task = Evaluation("mine", Setting(CASE, "coupled"), mass_matrix)
    with registry.register("mine", TWICE):
        first = task.perform()
    with registry.register("mine", replace(TWICE, made=RigidLinks)):
        np.testing.assert_array_equal(first, 2 * task.perform())


@pytest.mark.parametrize("name", ["exudyn:tree", "mine"])
def test_a_name_stands_for_one_model_at_a_time(name):
    with registry.register("mine", TWICE):
        with pytest.raises(InputError, match="exists already"), registry.register(name, TWICE):
            pass
        assert registry.MODELS["mine"] is TWICE


def compared(found: list, model: str) -> set[str]:
    """Families of comparisons between a model and another."""
    keys = [comparison.about.key for comparison in found]
    return {key.family for key in keys if key.right and model in (key.left, key.right)}


TREE, RUNS = registry.MODELS["exudyn:tree"], registry.BUILT_IN["analytic:links"].promises


@pytest.mark.parametrize(
    ("guest", "at_states", "of_runs"),
    [
        (registry.MODELS["pinocchio:gears"], {"states", "modes"}, set()),
        (replace(TREE, order=4), {"states"}, {"same-step"}),
        (replace(TREE, order=2), {"states"}, {"refined"}),
        (replace(TREE, order=None), {"states"}, {"refined"}),
        (replace(TWICE, promises=registry.STATES), {"states"}, set()),
        (
            replace(TWICE, promises=registry.BUILT_IN["analytic:links"].promises),
            {"states"},
            {"refined"},
        ),
    ],
)
def test_a_guest_is_compared_by_its_promises_its_integrator_and_its_level(
    guest, at_states, of_runs
):
    before = {c.about.key.id for c in plan_experiment_comparisons(EXPERIMENT)}
    with registry.register("mine", guest):
        assert registry.model_names(guest.role)[-1] == "mine"
        assert registry.second_engine() == "exudyn:tree"
        assert registry.find_same_integrator_models()[0] == "analytic:physical"
        found, states = plan_experiment_comparisons(EXPERIMENT), plan_states(ARM, 1, 0)
        assert compared(found, "mine") - {"at-2-s"} == of_runs
        families = compared(states, "mine")
        assert families == at_states if guest.role == "rigid" else families >= at_states
    after = {c.about.key.id for c in found}
    assert before < after if of_runs else before <= after


def test_a_guest_is_asked_about_what_it_covers_alone():
    lumped = replace(
        registry.MODELS["pinocchio:gears"], covers=lambda arm, chosen: chosen.planets == "lumped"
    )
    with registry.register("mine", lumped):
        free = usual_switches(ARM, planets="free")
        assert "mine" in registry.find_covering_models("geared", ARM, usual_switches(ARM))
        assert "mine" not in registry.find_covering_models("geared", ARM, free)
        tasks = [task for c in plan_states(ARM, 1, 0) for task in c.needs]
        asked = {task.setting.case.switches.planets for task in tasks if task.model == "mine"}
        assert asked == {"lumped"}


def test_a_robots_guest_is_asked_at_its_levels_alone():
    robot, planned = load_robot("sliding"), CrossCheckRequest(load_robot("sliding"), quick=True)
    guest = replace(registry.MODELS["pinocchio"], level="links", levels=("links", "coupled"))
    before = {each.about.key.id for each in plan_robot(planned).comparisons}
    with registry.register("mine", guest):
        assert registry.model_names("robot")[-1] == "mine"
        assert "mine" not in registry.select_covering(["mine"], load_arm("probe"), switches())
        found = plan_robot(planned)
        levels = {level for level in robot.levels if "mine" in registry.find_level_engines(level)}
        assert registry.find_robot_model("mine:coupled", robot) == ("mine", "coupled")
        with pytest.raises(InputError, match="sliding has the levels links, coupled in mine"):
            registry.find_robot_model("mine:armature", robot)
        with pytest.raises(InputError, match="must be ENGINE:LEVEL, ENGINE one of analytic, "):
            registry.find_robot_model("yours:links", robot)
    assert levels == {"links", "coupled"}
    own = {each.about.key.id for each in found.comparisons} - before
    assert {each.rpartition("mine:")[2] for each in own} == {"links", "coupled"}
    without = [remark for remark in found.remarks if remark.startswith("without mine")]
    assert without == [
        f"without mine at {level}: it does not have this level" for level in ("armature", "geared")
    ]


def test_sorts_of_mechanisms_supply_functions_that_take_the_same_arguments():
    """Each takes as many as the other needs, and the same ones by keyword alone."""
    for what in require_items(mechanisms.SUPPLIED):
        needed, taken, by_keyword = [], [], []
        for section in mechanisms.SECTIONS:
            supplied = mechanisms.supply(what, section)
            # Of equations under trial both classes have the methods of one, and make themselves.
            called = supplied.ask if supplied in TrialSubject.__subclasses__() else supplied
            given = signature(called).parameters
            placed = [each for each in given.values() if each.kind != each.KEYWORD_ONLY]
            required = {name for name, each in given.items() if each.default is each.empty}
            needed.append(sum(each.name in required for each in placed))
            taken.append(len(placed))
            by_keyword.append(required - {each.name for each in placed})
        assert max(needed) <= min(taken), what
        assert by_keyword[0] == by_keyword[1], what
