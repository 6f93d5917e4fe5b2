"""Numbers of many signals at once are those of each by itself, and of a run by itself."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from syrupy.assertion import SnapshotAssertion

from crosscheck import signals
from crosscheck.models.errors import InputError
from crosscheck.registry import build, reference_model
from crosscheck.studies.batches.batch import run_batch, run_check
from crosscheck.studies.definition import quantities as q
from crosscheck.studies.measures.columns import list_columns
from crosscheck.studies.measures.measurement import measure_values
from tests.loops import require_items
from tests.studies.studies import study

STEP = 1e-3


def _none(value: float | None) -> float:
    return np.nan if value is None else value


@st.composite
def columns(draw: st.DrawFn):
    """Time, and two signals of few values, so that levels are met and left."""
    count = draw(st.integers(1, 40))
    row = st.lists(st.integers(-2, 2), min_size=count, max_size=count)
    values = np.array([draw(row), draw(row)], dtype=float).T
    return STEP * np.arange(count), values


CROSSED = {"kind": "crossing", "signal": "theta"}
NUMBERS = {
    **{
        q.Size(kind=kind, signal="theta"): whole
        for kind, whole in {
            "peak": lambda t, v: signals.amplitude(v),
            "peak_to_peak": lambda t, v: signals.peak_to_peak(v),
            "mean": lambda t, v: signals.mean_value(v),
            "rms": lambda t, v: np.sqrt(np.mean(v**2)),
            "final": lambda t, v: v[-1],
        }.items()
    },
    q.Crossing(**CROSSED, side="above", level=1.0): (
        lambda t, v: _none(signals.crossing_time_above(t, v, 1))
    ),
    q.Crossing(**CROSSED, side="below", level=-1.0): (
        lambda t, v: _none(signals.crossing_time_below(t, v, -1))
    ),
    q.Settling(kind="settling", band_rad=1.0): lambda t, v: _none(_settled(t, v, 1.0)),
    q.NoContactShare(kind="apart_share", signal="F_sp"): lambda t, v: np.mean(v == 0),
    q.ContactLoss(kind="contact_loss", signal="F_sp"): lambda t, v: _lost(t, v),
    q.BandRms(kind="band_rms", signal="theta", band_Hz=(100.0, 400.0)): (
        lambda t, v: signals.band_rms(t, v, 100, 400)
    ),
    q.SpectralPeak(kind="spectral_peak", signal="theta", band_Hz=(100.0, 400.0)): (
        lambda t, v: signals.largest_line(t, v, 100, 400).frequency_Hz
    ),
}


def _settled(time: np.ndarray, values: np.ndarray, band: float) -> float | None:
    outside = np.flatnonzero(~(np.abs(values) <= band))
    last = int(outside[-1]) if outside.size else -1
    return None if last + 1 >= time.size else float(time[last + 1])


def _lost(time: np.ndarray, force: np.ndarray) -> float:
    carried = np.flatnonzero(force)
    if not carried.size:
        return np.nan
    after = np.flatnonzero(force[carried[0] :] == 0)
    return time[carried[0] + after[0]] if after.size else np.nan


@given(columns())
def test_every_number_is_that_of_the_signal_by_itself(signal):
    time, values = signal
    for quantity, whole in require_items(NUMBERS.items()):
        found = measure_values(quantity, time, values)[0]
        expected = [whole(time, np.ascontiguousarray(column)) for column in values.T]
        # sums are taken in another order: two roundings of 40 terms
        close = pytest.approx(expected, rel=1e-14, abs=1e-14, nan_ok=True)
        assert found == close, quantity.result_name


def test_a_signal_with_a_gap_has_no_spectrum_and_the_one_beside_it_has():
    time = STEP * np.arange(40)
    values = np.column_stack([np.sin(1e3 * time)] * 2)
    values[7, 1] = np.nan
    for quantity in require_items(each for each in NUMBERS if hasattr(each, "band_Hz")):
        numbers = np.array(measure_values(quantity, time, values))
        assert (np.isnan(numbers) == [False, True]).all(), quantity


def test_a_sine_has_its_rms_in_the_band_that_it_is_in():
    time = 1e-4 * np.arange(20_000)
    values = 3 * np.sin(2 * np.pi * 123.4 * time) + 5 * np.sin(2 * np.pi * 700 * time) + 7
    # a Hann window leaks less than 1e-4 past ten of its lines
    assert signals.band_rms(time, values, 100, 150) == pytest.approx(3 / np.sqrt(2), rel=1e-4)
    assert signals.band_rms(time, values, 600, 800) == pytest.approx(5 / np.sqrt(2), rel=1e-4)
    assert signals.band_rms(time, values, 200, 600) < 1e-3
    line = signals.largest_line(time, values, 100, 600)
    assert line.frequency_Hz == pytest.approx(123.4, abs=0.05)  # a tenth of a line's width


def test_numbers_of_a_short_signal_are_those_that_one_reads_off():
    time, values = np.arange(8.0), np.array([0.0, 3.0, -4.0, 1.0, 2.0, 1.0, 1.5, 1.0])
    sizes = (signals.amplitude, signals.peak_to_peak, signals.middle, signals.mean_value)
    assert [size(values) for size in sizes] == [4.0, 7.0, -0.5, 5.5 / 8]
    assert [signals.onset(time, values, part) for part in (0.75, 0.76)] == [1.0, 2.0]
    above = [signals.crossing_time_above(time, values, level) for level in (2.0, 3.0)]
    below = [signals.crossing_time_below(time, values, level) for level in (-3.9, -4.0)]
    assert (above, below) == ([1.0, None], [2.0, None])
    assert signals.window(time, 2.0, 5.0) == slice(2, 5)
    centres, low, high = signals.envelope(time, values, 2)
    assert (centres.tolist(), low.tolist(), high.tolist()) == ([1.5, 5.5], [-4, 1], [3, 2])


EVERY = [
    {"kind": "peak", "signal": "theta_ddot", "window_s": [0.001, 0.004]},
    {"kind": "rms", "signal": "F_sp", "joint": 1},
    {"kind": "final_error"},
    {"kind": "apart_share", "signal": "F_pr", "joint": 2},
    {"kind": "spectral_peak", "signal": "theta_ddot", "joint": 1},
    {"kind": "rigid_deviation"},
    {"kind": "trajectories", "signals": ["theta", "x_sp"]},
    {"kind": "peak", "signal": "theta", "window_s": [0.00011, 0.00019]},  # between two records
]


@pytest.mark.parametrize(
    ("arm", "planets"),
    [("paper-labelled", "lumped"), ("paper-labelled", "free"), ("three-unlike", "lumped")],
)
def test_a_member_has_the_numbers_of_a_run_by_itself(arm, planets):
    axes = [{"path": "arm.payload_mass_kg", "kind": "list", "values": [3.0, 4.0, 5.0]}]
    settings = {"scenario.duration_s": 0.005}
    made = study(axes, EVERY, arm, switches={"planets": planets}, settings=settings)
    found = run_batch(made.text, 0, 3)
    for place, case in require_items(enumerate(made.cases(0, 3))):
        run = build(reference_model(), *case.experiment).simulate()
        rigid = build("analytic:coupled", *case.experiment[:2]).simulate()  # at the same step
        part = signals.window(run["time"].values, 0.001, 0.004)
        force, apart = run["F_sp"].values[:, 0, 0], run["F_pr"].values[:, 1, 0]
        time = run["time"].values
        expected = {
            "theta_ddot_peak": np.abs(run["theta_ddot"].values[part]).max(axis=0),
            "F_sp_rms_joint1": np.sqrt(np.mean(force**2)),
            "theta_final_error": run["theta"].values[-1] - case.scenario.drive.target_rad,
            "F_pr_apart_share_joint2": np.nan if np.isnan(apart).any() else np.mean(apart == 0),
            "theta_ddot_spectral_peak_joint1_frequency": signals.dominant_frequency(
                time, run["theta_ddot"].values[:, 0], 0.0
            ),
            "theta_rigid_deviation_coupled": np.abs((run - rigid)["theta"].values).max(axis=0),
            "theta": run["theta"].values,
            "x_sp": run["x_sp"].values,
            "theta_peak": np.nan * run["theta"].values[0],
        }
        for name, value in require_items(expected.items()):
            # the ensemble's rounding, of 500 steps, against the plain kernel's
            limit = 1e-9 * np.nanmax(np.abs(value)) if np.isfinite(value).any() else 0
            if name.startswith("theta_rigid"):
                limit = 1e-11  # rad: the rigid arm's error at ten times the step, seen to be 3e-12
            close = pytest.approx(np.asarray(value), rel=1e-9, abs=limit, nan_ok=True)
            assert found[name][place] == close, name


def test_a_second_engine_has_every_quantity_too():
    made = study([], EVERY, settings={"scenario.duration_s": 0.005})
    ours, theirs = run_batch(made.text, 0, 1), run_check(made.text, 0)
    assert ours.keys() == theirs.keys()
    for name, value in ours.items():
        scale = np.nanmax(np.abs(value)) if np.isfinite(value).any() else 0
        # the same steps in other coordinates: rounding growth over 500 of them
        assert theirs[name] == pytest.approx(value, rel=1e-8, abs=1e-8 * scale, nan_ok=True), name


def test_a_force_that_is_lost_to_divergence_has_no_share_without_contact():
    quantity = q.NoContactShare(kind="apart_share", signal="F_sp")
    values = np.array([[1.0, 0.0], [0.0, 2.0], [np.nan, 3.0], [np.nan, 0.0]])
    (share,) = measure_values(quantity, np.arange(4.0), values)
    assert np.isnan(share[0])
    assert share[1] == 0.5


def test_a_diverged_member_has_no_numbers_but_when():
    axes = [{"path": "scenario.drive.derivative_N_m_s_per_rad", "kind": "list"}]
    axes[0]["values"] = [400.0, -1e12, 300.0]
    at_once = {"kind": "crossing", "signal": "theta", "level": -9.0, "side": "above"}
    made = study(axes, [{"kind": "peak", "signal": "theta"}, at_once])
    found = run_batch(made.text, 0, 3)
    assert np.isnan(found["diverged_s"]).tolist() == [True, False, True]
    for name in ("theta_peak", "theta_above_-9"):
        assert np.isnan(found[name]).any(axis=1).tolist() == [False, True, False]
    alone = run_batch(made.text, 2, 3)
    assert np.array_equal(alone["theta_peak"][0], found["theta_peak"][2])


def test_a_function_of_the_users_measures_a_run_as_a_model_records_it(tmp_path):
    code = "def measure(run):\n    return {'x': run.x_sp[-1, 1, 2], 'n': run.attrs['step_s']}\n"
    (tmp_path / "mine.py").write_text(code, encoding="utf-8")
    quantity = {"kind": "user_function", "function": "mine.py:measure"}
    made = study([], [{**quantity, "returns": {"x": "m", "n": "s"}}], folder=tmp_path)
    run = build(reference_model(), *made.base.experiment).simulate()
    found = run_batch(made.text, 0, 1)
    assert found["n"][0] == made.base.scenario.step_s
    # the ensemble's rounding, of 200 steps, against the plain kernel's
    assert found["x"][0] == pytest.approx(float(run.x_sp[-1, 1, 2]), rel=1e-9)


RECORDED = {"kind": "trajectories", "signals": ["theta", "F_sp"], "name": "run"}
CROSSING = {"kind": "crossing", "signal": "theta", "level": 0.25, "side": "above"}
LINE = {"kind": "spectral_peak", "signal": "x_sp", "band_Hz": [10.0, 90.0]}
NAMED = [
    {"kind": "peak", "signal": "theta_ddot", "joint": 2},
    {"kind": "band_rms", "signal": "F_sp", "band_Hz": [10.0, 90.0]},
    {"kind": "contact_loss", "signal": "F_pr"},
    {"kind": "apart_share", "signal": "F_sp"},
    {"kind": "settling", "band_rad": 0.01},
    {"kind": "final_error"},
    {"kind": "rigid_deviation", "level": "coupled"},
    *(CROSSING, LINE, RECORDED),
]


def test_every_quantity_has_its_unit_its_meaning_and_its_shape(snapshot: SnapshotAssertion):
    """Of 21 records, two joints, and three planets."""
    rows = [
        f"{each.name} [{each.unit}] {each.dims} {each.shape}: {each.meaning}; {each.missing}"
        for each in list_columns(study([], NAMED))
    ]
    assert "\n".join(rows) == snapshot


@pytest.mark.parametrize(
    ("quantity", "more", "said"),
    [
        ({**CROSSING, "joint": 2}, {}, ""),
        ({**CROSSING, "joint": 3}, {}, "joint = 3: the arm has 2"),
        ({**LINE, "planet": 4}, {"arm": "planets-apart", "switches": {"planets": "free"}}, ""),
        ({**LINE, "planet": 4}, {}, "planet = 4: the arm's joints have up to"),
        ({**CROSSING, "window_s": [0.0019, 0.1]}, {}, ""),
        ({**CROSSING, "window_s": [0.002, 0.1]}, {}, "must begin before the run's end, 0.002 s"),
        (
            {"kind": "apart_share", "signal": "F_sp"},
            {"switches": {"dead_zone": "tanh"}},
            "needs dead_zone = exact",
        ),
        ({"kind": "final_error"}, {"scenario": "constant-torque"}, "needs a PD drive"),
        ({"kind": "settling", "band_rad": 0.1}, {"scenario": "constant-torque"}, "needs a PD"),
        (
            {"kind": "settling", "band_rad": 0.1, "target_rad": 0.2, "joint": 1},
            {"scenario": "constant-torque"},
            "",
        ),
    ],
)
def test_what_a_member_does_not_have_is_refused(quantity, more, said):
    made = study([], [quantity], **more)
    if said:
        with pytest.raises(InputError, match=re.escape(said)):
            list_columns(made)
    else:
        assert len(list_columns(made)) > 1
