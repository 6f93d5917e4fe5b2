"""Simulations are kept by everything that they depend on, and by nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from crosscheck.paper.fluctuation import excess_acceleration
from crosscheck.studies import study as study_module
from crosscheck.studies.sources import code_hash
from crosscheck.studies.study import Numbers, Study, Variant, clear_cache, simulate
from models.errors import InputError

SHORT = Variant(scenario="constant-torque", duration_s=0.002)


def final_angle(run: xr.Dataset) -> Numbers:
    """Of the shoulder."""
    return {"theta_1": float(run["theta"].values[-1, 0])}


def largest_excess(run: xr.Dataset) -> Numbers:
    """Of both joints."""
    return {"excess": float(np.abs(excess_acceleration(run)).max())}


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return Study(tmp_path)


def test_a_finished_simulation_is_found_again(study: Study):
    first = study.measures([SHORT], final_angle)
    second = study.measures([SHORT], final_angle)
    assert first == second
    assert (study.made, study.found) == (1, 1)


def test_an_interrupted_study_makes_only_what_is_missing(study: Study, tmp_path: Path):
    study.measures([SHORT], final_angle)
    other = Variant(scenario="constant-torque", duration_s=0.002, zeta=0.02)
    resumed = Study(tmp_path)
    resumed.measures([SHORT, other], final_angle)
    assert (resumed.made, resumed.found) == (1, 1)


@pytest.mark.parametrize(
    "change",
    [
        {"zeta": 0.0500001},
        {"phase": "omega_t"},
        {"arm": "paper-swapped"},
        {"seed": 1},
        {"settings": ("arm.joints.0.backlash_m=51e-6",)},
        {"duration_s": 0.003},
        {"record_every": 1},
        {"model": "analytic:energies"},
    ],
    ids=lambda change: next(iter(change)),
)
def test_every_input_is_part_of_the_key(change: dict[str, object]):
    changed = Variant(**{"scenario": "constant-torque", "duration_s": 0.002, **change})
    assert study_module._key(changed) != study_module._key(SHORT)


def test_another_measure_has_another_key():
    keys = {study_module._key(SHORT, measure) for measure in (None, final_angle, largest_excess)}
    assert len(keys) == 3


def test_code_and_versions_are_part_of_the_key(monkeypatch: pytest.MonkeyPatch):
    before = study_module._key(SHORT)
    monkeypatch.setattr(study_module, "code_hash", lambda *modules: "changed")
    changed_code = study_module._key(SHORT)
    monkeypatch.undo()
    monkeypatch.setattr(study_module, "_versions", lambda: ("numpy 0.0",))
    assert len({before, changed_code, study_module._key(SHORT)}) == 3


def test_the_code_of_a_model_reaches_what_it_imports():
    # The kernel is imported by the model, the engine's models are not.
    assert code_hash("analytic.model") != code_hash("analytic.kernel")
    assert code_hash("analytic.model") == code_hash("analytic.model", "analytic.kernel")
    assert code_hash("analytic.model") != code_hash("analytic.model", "models.exudyn_tree")


def test_a_kept_run_is_the_run(study: Study):
    kept = study.runs([SHORT])[SHORT]
    again = study.runs([SHORT])[SHORT]
    fresh = simulate(SHORT)
    for run in (kept, again):
        assert np.array_equal(run["theta"].values, fresh["theta"].values)


def test_a_diverging_run_is_a_number_not_a_crash(study: Study):
    wild = Variant(
        scenario="constant-torque",
        duration_s=0.1,
        settings=("scenario.step_s=1e-3",),
        record_every=1,
    )
    (numbers,) = study.measures([wild], final_angle)
    assert 0 < numbers["diverged_s"] <= 0.1


def test_seeds_move_the_start_by_less_than_a_picometre():
    start = Variant(seed=3).case().scenario.start
    offsets = np.array([start.sun_planet_offset_m, start.planet_ring_offset_m])
    assert 0 < np.abs(offsets).max() <= 1e-12
    assert Variant(seed=3).case() == Variant(seed=3).case()
    assert Variant(seed=3).case() != Variant(seed=4).case()


@dataclass(frozen=True)
class Square:
    """A question without a simulation."""

    number: float
    cost: float = 0.0

    @property
    def inputs(self) -> str:
        return repr(self.number)

    def answer(self) -> float:
        return self.number**2


def test_an_answer_is_worked_out_once_for_its_inputs(study: Study):
    assert study.answers([Square(2.0), Square(3.0)], "squares") == [4.0, 9.0]
    assert study.answers([Square(3.0), Square(4.0)], "squares") == [9.0, 16.0]
    assert (study.made, study.found) == (3, 1)


def test_a_damaged_file_is_named(study: Study):
    study.answers([Square(2.0)], "squares")
    (kept,) = study.folder.glob("*.json")
    kept.write_text("4.", encoding="utf-8")
    with pytest.raises(InputError, match=f"{kept.name}.*cache clear"):
        study.answers([Square(2.0)], "squares")


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="file/cache: cannot be written"):
        Study(tmp_path / "file" / "cache").answers([Square(2.0)], "squares")


def test_clearing_removes_what_was_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    Study(study_module.cache_folder()).measures([SHORT], final_angle)
    assert clear_cache() == 1
    assert clear_cache() == 0
