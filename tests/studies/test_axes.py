"""Axes and members: what is drawn, what is put where, and what stays as the files say."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.audit.experiments.variant import perturb_start
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.loading import Case, load_case
from crosscheck.models.paths import assign
from crosscheck.studies.batches.batches import batch_size, make_batch_tasks
from crosscheck.studies.members.members import load_study
from tests.loops import require_items
from tests.studies.studies import study

BACKLASH = "arm.joints.*.*_mesh.backlash_m"
ROUNDED = 4 * np.spacing(100e-6)  # of the product and the sum, here and there
COUNTS = st.integers(1, 60)
SEEDS = st.integers(0, 2**32 - 1)


def _sampled(count: int, seed: int, *axes: dict[str, object]):
    return study(list(axes), samples={"count": count, "seed": seed}).axes


@given(COUNTS, SEEDS, st.booleans(), st.sampled_from(["linear", "log"]))
def test_a_latin_hypercube_has_one_sample_in_every_part(count, seed, each, spacing):
    low, high = 1e-6, 1e-4
    law = {"kind": "latin_hypercube", "low": low, "high": high, "spacing": spacing}
    (axis,) = _sampled(count, seed, {"path": BACKLASH, "each": each, **law})
    values = np.asarray(axis.values)
    assert values.shape == (count, 4 if each else 1)  # two joints of two meshes
    share = np.log(values / low) / np.log(high / low)
    if spacing == "linear":
        share = (values - low) / (high - low)
    assert (np.arange(count) == np.sort(np.floor(share * count), axis=0).T).all()


def test_axes_of_a_latin_hypercube_do_not_rise_together():
    """Of 400 independent draws correlations have a standard deviation of 0.05."""
    law = {"kind": "latin_hypercube", "low": 0.0, "high": 2.0}
    own = {"path": "arm.payload_mass_kg", **law}
    drawn = [axis.values for axis in _sampled(400, 3, {"path": BACKLASH, "each": True, **law}, own)]
    columns = np.column_stack([*drawn, np.arange(400)])
    assert np.abs(np.corrcoef(columns.T) - np.eye(6)).max() < 0.25


def test_an_axis_of_an_entry_of_a_list_has_the_lists_name():
    axis = {"path": "arm.gravity_m_per_s2.0", "kind": "list", "values": [0.0, 1.7]}
    assert study([axis], arm="three-unlike").axes[0].name == "gravity_m_per_s2"


@given(COUNTS, SEEDS, st.floats(0, 0.5))
def test_uniform_tolerances_stay_within(count, seed, tolerance):
    law = {"kind": "uniform", "relative_tolerance": tolerance}
    (axis,) = _sampled(count, seed, {"path": BACKLASH, "each": True, **law})
    assert (np.abs(np.asarray(axis.values) - 50e-6) <= tolerance * 50e-6 + ROUNDED).all()


@given(COUNTS, SEEDS, st.floats(0.5, 3))
def test_normal_draws_beyond_the_limit_are_drawn_again(count, seed, within):
    law = {"kind": "normal", "sd": 1e-6, "within_sd": within}
    (axis,) = _sampled(count, seed, {"path": BACKLASH, **law})
    assert (np.abs(np.asarray(axis.values) - 50e-6) <= within * 1e-6 + ROUNDED).all()


def test_normal_and_uniform_have_the_moments_that_they_should():
    count = 20_000
    normal, uniform = _sampled(
        count,
        1,
        {"path": BACKLASH, "kind": "normal", "relative_sd": 0.1},
        {"path": "arm.payload_mass_kg", "kind": "uniform", "tolerance": 2.0},
    )
    # five standard errors of a mean and of a standard deviation
    for values, mean, sd in ((normal.values, 50e-6, 5e-6), (uniform.values, 10, 2 / np.sqrt(3))):
        assert np.mean(values) == pytest.approx(mean, abs=5 * sd / np.sqrt(count))
        assert np.std(values) == pytest.approx(sd, rel=5 / np.sqrt(2 * count))


def test_an_axis_draws_the_same_whatever_stands_beside_it():
    backlash = {"path": BACKLASH, "kind": "normal", "relative_sd": 0.1}
    payload = {"path": "arm.payload_mass_kg", "kind": "uniform", "tolerance": 2.0}
    (alone,) = _sampled(10, 3, backlash)
    beside, other = _sampled(10, 3, backlash, payload)
    assert np.array_equal(alone.values, beside.values)
    deviations = (np.asarray(beside.values) / 50e-6 - 1) / 0.1, np.asarray(other.values) / 2 - 5
    assert abs(np.corrcoef(*(d.ravel() for d in deviations))[0, 1]) < 0.99


@pytest.mark.parametrize("each", [False, True])
def test_one_draw_serves_all_entries_or_each_has_its_own(each):
    made = study(
        [{"path": BACKLASH, "kind": "normal", "relative_sd": 0.1, "each": each}],
        samples={"count": 5},
    )
    for case in require_items(made.cases(0, 5)):
        geared = [joint for joint in case.mechanism.joints if isinstance(joint, Planetary)]
        meshes = [mesh for joint in geared for mesh in (joint.sun_mesh, joint.ring_mesh)]
        assert len({mesh.backlash_m for mesh in meshes}) == (len(meshes) if each else 1)


def test_one_draw_moves_unlike_entries_by_the_same_share():
    made = study(
        [{"path": "arm.links.*.length_m", "kind": "uniform", "relative_tolerance": 0.1}],
        samples={"count": 4},
    )
    lengths = np.asarray(made.axes[0].values)
    assert lengths.shape == (4, 2)
    assert lengths[:, 1] / lengths[:, 0] == pytest.approx(0.7, rel=1e-14)
    assert np.ptp(lengths[:, 0]) > 0


@pytest.mark.parametrize("spacing", ["linear", "log"])
def test_a_grid_has_both_ends(spacing):
    law = {"kind": "grid", "start": 1e-5, "stop": 1e-4, "count": 7, "spacing": spacing}
    (axis,) = study([{"path": BACKLASH, **law}]).axes
    values = np.asarray(axis.values)[:, 0]
    assert (values[0], values[-1]) == (1e-5, 1e-4)
    steps = np.diff(np.log(values) if spacing == "log" else values)
    assert steps == pytest.approx(steps[0], rel=1e-9)


def test_members_are_the_grid_in_c_order_with_samples_and_starts_innermost():
    made = study(
        [
            {"path": BACKLASH, "kind": "list", "values": [1e-5, 2e-5]},
            {"path": "switches.phase", "kind": "list", "values": ["angle", "omega_t"]},
            {"path": "arm.payload_mass_kg", "kind": "uniform", "tolerance": 1.0},
        ],
        samples={"count": 3},
        starts={"count": 2, "seed": 5},
    )
    assert made.dimensions == {"backlash_m": 2, "phase": 2, "sample": 3, "start": 2}
    cases = list(made.cases(0, made.count))
    payloads = np.asarray(made.axes[2].values)[:, 0]
    for place, case in enumerate(cases):
        b, phase, sample, start = np.unravel_index(place, made.shape)
        assert case.mechanism.joints[1].sun_mesh.backlash_m == [1e-5, 2e-5][b]
        assert case.switches.phase == ["angle", "omega_t"][phase]
        assert case.switches.ring_rate == ["corrected", "eq13"][phase]
        assert case.mechanism.payload_mass_kg == payloads[sample]
        alone = Case(*replace(case, scenario=made.base.scenario).experiment)
        assert case.scenario == perturb_start(alone, 5 + int(start)).scenario
    assert list(made.cases(7, 11)) == cases[7:11]


def test_nothing_but_the_named_paths_differs_from_the_files():
    made = study(
        [{"path": "arm.joints.1.*_mesh.damping_ratio", "kind": "list", "values": [0.02]}],
        arm="paper-swapped",
        settings={"arm.joints.0.*_mesh.damping_ratio": 0.013},
    )
    (case,) = made.cases(0, 1)
    settings = ["arm.joints.0.*_mesh.damping_ratio=0.013", "arm.joints.1.*_mesh.damping_ratio=0.02"]
    settings.append("scenario.duration_s=0.002")
    assert Case(*case.experiment) == load_case("paper-swapped", "pd", settings=settings)


def test_a_perturbed_start_adds_to_what_the_scenario_says():
    case = load_case("paper-labelled", "pd", settings=["scenario.start.sun_planet_offset_m=1e-6"])
    offsets = perturb_start(case, 1, 1e-9).scenario.start.sun_planet_offset_m
    assert isinstance(offsets, tuple)
    assert all(0 < abs(offset - 1e-6) <= 1e-9 for offset in offsets)


def test_the_digest_hangs_on_every_input_and_on_no_name():
    axis = {"path": BACKLASH, "kind": "list", "values": [1e-5]}
    one = study([axis])
    moved = json.loads(one.text)
    moved["definition"]["arm"], moved["file"] = "elsewhere.toml", "other.toml"
    assert load_study(json.dumps(moved)).digest == one.digest
    other = json.loads(one.text)
    assign(other["data"], ("arm", "payload_mass_kg"), 11.0)
    assert load_study(json.dumps(other)).digest != one.digest
    assert study([{**axis, "values": [2e-5]}]).digest != one.digest


@given(st.integers(1, 3000))
def test_batches_cover_every_member_once_in_full_lanes(count):
    made = study([{"path": BACKLASH, "kind": "grid", "start": 1e-5, "stop": 1e-4, "count": count}])
    cut = make_batch_tasks(made, "version")
    places = [task.arguments[1:] for task in cut]
    assert [places[0][0], places[-1][1]] == [0, count]
    assert all(left[1] == right[0] for left, right in pairwise(places))
    both = [task.key for each in ("version", "another") for task in make_batch_tasks(made, each)]
    assert len(set(both)) == 2 * len(cut)
    if count > 32:
        assert batch_size(made) % 32 == 0
