"""Members side by side: nobody depends on a neighbour."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

from crosscheck.analytic import ensemble
from crosscheck.analytic.ensemble import Group, group_models
from crosscheck.analytic.kernel.batch import Records
from crosscheck.analytic.model import AnalyticModel
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_arm
from crosscheck.models.trajectory import recorded_times
from crosscheck.registry import build, model_names
from tests.abreast import run_models
from tests.arms import random_arm
from tests.mixed_arms import scenario as scenario_of

MEMBERS = 40  # two groups, the second not full, its last block neither
GEARED = "analytic:physical"
ARMS = {
    "lumped": (load_arm("probe"), {}),
    "free": (load_arm("planets-apart"), {"mesh_work": "conservative"}),
    "mixed": (random_arm(87, 5), {"phase": "omega_t", "damping": "contact"}),
}
FAR_TOO_STIFF = 1e12  # N m/rad: the step is far beyond its stability


@dataclass(frozen=True)
class Member:
    """What a member has of its own."""

    payload_kg: float
    target_rad: float
    stiffness: float
    offset_m: float


def members(count: int) -> list[Member]:
    """Of payload, controller and start each its own."""
    draw = np.random.default_rng(7)
    least, most = [1.0, -1.0, 100.0, -2e-6], [9.0, 1.0, 2000.0, 2e-6]
    return [Member(*row) for row in draw.uniform(least, most, (count, 4)).tolist()]


def scenario(member: Member, steps: int = 30, **more: Any) -> Scenario:
    drive = {
        "kind": "pd",
        "target_rad": member.target_rad,
        "proportional_N_m_per_rad": member.stiffness,
        "derivative_N_m_s_per_rad": 20.0,
    }
    start = {"theta_rad": -member.target_rad, "sun_planet_offset_m": member.offset_m}
    fields = {"record_every": 5, "drive": drive, "start": start, **more}
    return scenario_of(duration_s=steps * 1e-5, step_s=1e-5, **fields)


def model_of(kind: str, member: Member, **more: Any) -> AnalyticModel:
    arm, laws = ARMS[kind]
    own = arm.model_copy(update={"payload_mass_kg": member.payload_kg})
    found = build(GEARED, own, scenario(member, **more), usual_switches(own, **laws))
    assert isinstance(found, AnalyticModel)
    return found


@pytest.fixture(scope="module", params=ARMS)
def models(request: pytest.FixtureRequest) -> list[AnalyticModel]:
    return [model_of(request.param, member) for member in members(MEMBERS)]


@pytest.fixture(scope="module")
def right(models: list[AnalyticModel]) -> list[xr.Dataset]:
    """Runs of each with no neighbour."""
    return [run for model in models for run in run_models([model])]


def same(left: xr.Dataset | Diverged, right: xr.Dataset | Diverged) -> bool:
    """Bit for bit."""
    assert isinstance(left, xr.Dataset)
    assert isinstance(right, xr.Dataset)
    return all(
        values.values.tobytes() == right[name].values.tobytes() for name, values in left.items()
    )


def test_members_differ_from_each_other(right):
    assert len({run["x_sp"].values.tobytes() for run in right}) == MEMBERS


@pytest.mark.parametrize("count", [2, 7, 8, 9, 31, 32, 33, MEMBERS])
def test_a_member_is_the_same_whoever_stands_beside_it(models, right, count):
    chosen = np.random.default_rng(count).permutation(MEMBERS)[:count]
    found = run_models([models[place] for place in chosen])
    wrong = [p for p, run in zip(chosen, found, strict=True) if not same(run, right[p])]
    assert wrong == []


def test_groups_run_by_several_threads_are_the_same(models, right):
    assert len(group_models(models)) > 1
    found = run_models(models, threads=3)
    assert all(same(run, one) for run, one in zip(found, right, strict=True))


def test_chunks_of_any_size_make_the_same_run(models, right, monkeypatch):
    monkeypatch.setattr(ensemble, "CHUNK", 1)
    found = run_models(models[:9])
    assert all(same(run, right[place]) for place, run in enumerate(found))


def test_a_member_is_the_run_alone_bit_for_bit(models, right):
    assert same(models[0].simulate(), right[0])


def test_groups_are_of_one_structure_and_grid(models):
    other_step = model_of("lumped", members(1)[0], steps=15)
    other_arm = model_of("lumped", members(1)[0])
    found = group_models([other_step, *models, other_arm])
    places = [place for group in found for place in group.members]
    assert sorted(places) == list(range(MEMBERS + 2))
    assert (0,) in [group.members for group in found]
    for group in found:
        assert len({(m.equations.structure, m.layout, m.scenario.steps) for m in group.models}) == 1


def test_every_record_is_in_one_chunk(models, right, monkeypatch):
    monkeypatch.setattr(ensemble, "CHUNK", 1)
    (group,) = group_models(models[:5])
    chunks = list(group.chunks())
    time = np.concatenate([chunk.time for chunk in chunks])
    np.testing.assert_array_equal(time, recorded_times(models[0].scenario))
    assert len(chunks) > 2
    for name in ("theta", "theta_dot", "theta_ddot", "torque"):
        found = np.concatenate([getattr(chunk, name) for chunk in chunks])
        for place in range(5):
            np.testing.assert_array_equal(found[:, :, place], right[place][name])
    for name in ("x_sp", "x_pr", "x_sp_dot", "x_pr_dot", "F_sp", "F_pr"):
        found = np.concatenate([getattr(chunk, name) for chunk in chunks])
        for place in range(5):
            whole, planets = right[place][name].values, found.shape[2]
            assert planets in (1, whole.shape[2])  # lumped, one planet stands for all
            # Free displacements are added in another order.
            np.testing.assert_allclose(found[..., place], whole[:, :, :planets], rtol=1e-15, atol=0)


@pytest.mark.parametrize("place", [0, 3, 8])
def test_who_diverges_disturbs_nobody(place):
    calm = [model_of("lumped", member) for member in members(8)]
    stiff = model_of("lumped", Member(5.0, 0.5, FAR_TOO_STIFF, 0.0))
    found = run_models([*calm[:place], stiff, *calm[place:]])
    wild = found.pop(place)
    assert isinstance(wild, Diverged)
    assert all(same(run, one) for run, one in zip(found, run_models(calm), strict=True))


@pytest.mark.parametrize("chunk", [1, ensemble.CHUNK])
@pytest.mark.parametrize("lanes", [1, 8])
def test_divergence_is_flagged_with_its_time(lanes, chunk, monkeypatch):
    monkeypatch.setattr(ensemble, "CHUNK", chunk)
    wild = model_of("lumped", Member(5.0, 0.5, FAR_TOO_STIFF, 0.0), steps=300)
    group = Group((0,), [wild], lanes=lanes)
    chunks = list(group.chunks())
    records = [np.concatenate(parts) for parts in zip(*(c.records for c in chunks), strict=True)]
    q, v, a, forces = (each[:, :, 0] for each in records)
    time = np.concatenate([c.time for c in chunks])
    first = int(np.argmax(time == group.diverged_s[0]))
    assert 0 < first < time.size - 1
    assert np.isfinite(q[:first]).all()
    assert np.isfinite(v[:first]).all()
    for values in (q, v, a, forces):
        assert np.isnan(values[first:]).all()


def test_a_member_has_no_records_from_its_divergence_on():
    group = Group((0, 1), [model_of("lumped", each) for each in members(2)])
    records = Records(*np.zeros((4, 3, 6, 2)))
    records.q[1:, 2, 1] = np.inf
    group._mark(np.arange(3.0), records)
    assert group.diverged_s == pytest.approx([np.nan, 1.0], nan_ok=True)
    for values in records:
        assert (np.isnan(values).all(axis=1) == [[False] * 2, [False, True], [False, True]]).all()


def test_a_run_alone_that_diverges_says_when():
    wild = model_of("lumped", Member(5.0, 0.5, FAR_TOO_STIFF, 0.0))
    with pytest.raises(Diverged, match="diverged at t = "):
        wild.simulate()


@lru_cache
def other_model(name: str) -> AnalyticModel:
    """Of an arm with stiffness by a table, or one of the paper's own forms."""
    arm = load_arm("direct-between" if name == "table" else "paper-labelled")
    model = GEARED if name == "table" else name
    return build(model, arm, scenario(members(1)[0]), usual_switches(arm))


@pytest.mark.parametrize("name", ["table", *model_names("form")])
def test_forms_and_tables_run_alone_as_among_others(name):
    model = other_model(name)
    one, other = run_models([model, model])
    assert same(one, other)
    assert same(model.simulate(), one)


def test_different_structures_stand_in_one_question():
    lumped = [model_of("lumped", member) for member in members(2)]
    asked = [lumped[0], other_model("table"), lumped[1], other_model("table")]
    found = run_models(asked)
    assert len(group_models(asked)) == 2
    assert same(found[1], found[3])
    assert same(found[2], run_models(lumped)[1])


def test_members_under_unlike_tables_of_torques_keep_their_own():
    tables = ([1.0, 9.0], [1.0, -9.0], [1.0, 9.0])
    drives = [{"kind": "table", "time_s": [0.0, 1e-3], "torque_N_m": [each] * 2} for each in tables]
    models = [model_of("lumped", members(1)[0], drive=drive) for drive in drives]
    first, turned, again = run_models(models)
    assert same(first, again)
    assert same(turned, models[1].simulate())
    ends = [run["torque"].values[-1, 0] for run in (first, turned)]  # three tenths of the way
    assert ends == pytest.approx([1.0 + 0.3 * 8.0, 1.0 - 0.3 * 10.0])


def test_nobody_is_nobody():
    assert run_models([]) == group_models([]) == []
