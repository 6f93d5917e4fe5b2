"""Simulations are kept by everything that they depend on, and by nothing else."""

import pickle
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments import study as study_module
from crosscheck.audit.experiments.ensembles import SIGNALS, CoursesQuestion, simulate_courses
from crosscheck.audit.experiments.study import Question, Records, Study, question_key
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.run_signals import extract_signals
from crosscheck.models.errors import Diverged, InputError, Unfinished
from crosscheck.models.files import HERE
from crosscheck.models.loading import load_arm
from crosscheck.registry import MODELS
from crosscheck.runner.outcomes import Failure
from tests.abreast import run_models
from tests.audit.runs import simulate

SHORT = Variant(scenario="constant-torque", duration_s=0.002)


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return Study(tmp_path)


def test_an_interrupted_study_makes_only_what_is_missing(study, tmp_path):
    first = simulate_courses(study, [SHORT], "runs")[SHORT]
    resumed = Study(tmp_path)
    again = simulate_courses(resumed, [SHORT], "runs")[SHORT]
    simulate_courses(resumed, [replace(SHORT, zeta=0.02)], "runs")
    assert (resumed.computed_count, resumed.cached_count) == (1, 1)
    assert again.case == first.case
    fresh = extract_signals(simulate(SHORT))
    for name in SIGNALS:
        assert np.array_equal(getattr(first, name), getattr(again, name))
    assert np.array_equal(again.theta, fresh.theta)


@pytest.mark.parametrize(
    "change",
    [
        {"zeta": 0.0500001},
        {"phase": "omega_t"},
        {"arm": "paper-swapped"},
        {"seed": 1},
        {"settings": ("arm.joints.0.*_mesh.backlash_m=51e-6",)},
        {"duration_s": 0.003},
        {"record_every": 1},
        {"model": "analytic:energies"},
    ],
    ids=lambda change: next(iter(change)),
)
def test_every_input_is_part_of_the_key(change):
    changed = CoursesQuestion((replace(SHORT, **change),))
    assert question_key(changed) != question_key(CoursesQuestion((SHORT,)))


def test_code_and_versions_are_part_of_the_key(monkeypatch):
    asked = CoursesQuestion((SHORT,))
    before = question_key(asked)
    monkeypatch.setattr(study_module, "compute_code_hash", lambda *names: "changed")
    changed_code = question_key(asked)
    monkeypatch.undo()
    seen: list[str] = []

    def versions(*packages: str) -> tuple[str, ...]:
        seen.extend(packages)
        return ("numpy 0.0",)

    monkeypatch.setattr(study_module, "_versions", versions)
    assert len({before, changed_code, question_key(asked)}) == 3
    assert set(seen) >= {"numpy", "llvmlite", "xarray"}


def test_runs_side_by_side_are_those_that_run_alone():
    """Whatever stands beside a run, be it one that diverges; bit for bit."""
    starts = [replace(SHORT, seed=seed, zeta=0.01 * seed) for seed in range(1, 11)]
    wild = replace(SHORT, meshes=("arm.joints.*.*_mesh.stiffness.mean_N_per_m=1e12",))
    beside = [*starts, wild, replace(starts[0], record_every=5)]
    models = [PhysicalModel(*variant.case()) for variant in beside]
    *together, diverged, seldom = run_models(models)
    assert isinstance(diverged, Diverged)
    for variant, found in zip([*starts, beside[-1]], [*together, seldom], strict=True):
        assert simulate(variant).identical(found)


def test_a_longer_run_of_a_slower_model_costs_more():
    slow = replace(SHORT, model="exudyn:tree")
    costs = [CoursesQuestion((one,)).cost for one in (SHORT, slow)]
    assert costs == [200 * MODELS[one.model].call_s for one in (SHORT, slow)]


def test_a_diverging_run_is_raised_after_all_others_are_kept(study):
    settings = ("scenario.step_s=1e-3",)
    wild = Variant("constant-torque", duration_s=0.1, settings=settings, record_every=1)
    with pytest.raises(Diverged) as raised:
        study.answer_questions([CoursesQuestion((one,)) for one in (wild, SHORT)], "runs")
    assert 0 < raised.value.time_s <= 0.1
    again = Study(study.folder)
    simulate_courses(again, [SHORT], "runs")
    assert (again.computed_count, again.cached_count) == (0, 1)


@dataclass(frozen=True)
class Root:
    """An answer that is a record."""

    value: float | None
    of: tuple[float, ...]


@dataclass(frozen=True)
class Roots(Question[list[Root]]):
    """Answered in records."""

    numbers: tuple[float, ...]

    cost = 0.0

    def records(self) -> Records:
        return ()

    def answer(self) -> list[Root]:
        return [Root(n**0.5 if n >= 0 else None, (n, 0.1 * n)) for n in self.numbers]


def test_an_answer_is_worked_out_once_for_its_inputs_and_comes_back_in_records(study):
    """It is kept as JSON."""
    two, less, three = (Roots((number,)) for number in (2.0, -1.0, 3.0))
    assert study.answer_questions([two, less], "roots") == [two.answer(), less.answer()]
    again = Study(study.folder)
    assert again.answer_questions([less, three], "roots") == [less.answer(), three.answer()]
    assert (again.computed_count, again.cached_count) == (1, 1)


@dataclass(frozen=True)
class Broken(Question[None]):
    """Its answer raises."""

    error: type[Exception]

    cost = 0.0

    def records(self) -> Records:
        return ()

    def answer(self) -> None:
        raise self.error("m", 1.0) if self.error is Diverged else self.error("two\nlines")


def test_what_has_no_result_is_one_clear_error(study):
    with pytest.raises(Unfinished, match=r"^roots: Broken: ValueError: two lines$"):
        study.answer_questions([Roots((2.0,)), Broken(ValueError)], "roots")
    kept = Study(study.folder)
    kept.answer_questions([Roots((2.0,))], "roots")
    assert (kept.computed_count, kept.cached_count) == (0, 1)
    with pytest.raises(Diverged, match="m: diverged at t = 1 s"):
        study.answer_questions([Broken(Diverged)], "roots")


def test_a_worker_that_died_is_one_clear_error(study, monkeypatch):
    ended = Failure("Died", "ended by SIGKILL")
    monkeypatch.setattr(
        study_module.Workers,
        "stream_longest_first",
        lambda workers, tasks: [(task.key, ended) for task in tasks],
    )
    with pytest.raises(Unfinished, match=r"^runs: CoursesQuestion: Died: ended by SIGKILL$"):
        simulate_courses(study, [SHORT], "runs")


@pytest.mark.parametrize("error", [InputError("file", "field", 1, "allowed"), Diverged("m", 1.0)])
def test_errors_come_whole_out_of_another_process(error):
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), vars(again)) == (str(error), vars(error))


def test_an_arms_own_damping_stays_unless_another_is_given(tmp_path):
    text = (HERE / "arms" / "paper-labelled.toml").read_text(encoding="utf-8")
    direct = "damping_N_s_per_m = 7.0"
    for name, damping in (("ratio", "damping_ratio = 0.03"), ("direct", direct)):
        changed = text.replace("damping_ratio = 0.05", damping)
        assert changed != text
        (tmp_path / f"{name}.toml").write_text(changed, encoding="utf-8")
        file = str(tmp_path / f"{name}.toml")
        assert Variant(arm=file).case().arm == load_arm(file)
        for joint in Variant(arm=file, zeta=0.2).case().arm.joints:
            for mesh in (joint.sun_mesh, joint.ring_mesh):
                assert (mesh.damping_ratio, mesh.damping_N_s_per_m) == (0.2, None)
    assert Variant(zeta=0.05).case() == Variant().case()


def test_a_file_of_a_variant_is_read_again_once_it_has_changed(tmp_path):
    """Also where it is as long as before."""
    text, file = (HERE / "arms" / "paper-labelled.toml").read_text(), tmp_path / "arm.toml"
    variant = replace(SHORT, arm=str(file))
    for mass in ("10.0", "12.0"):
        file.write_text(re.sub(r"(?m)^(payload_mass_kg = )[\d.]+", rf"\g<1>{mass}", text))
        assert variant.case().arm.payload_mass_kg == float(mass)
