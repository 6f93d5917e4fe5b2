"""What a study's result says: of its members, its axes, a second engine; and its drawings."""

import json
import tomllib
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib as mpl
import matplotlib.image
import numpy as np
import pytest
import xarray as xr

import crosscheck as package
from crosscheck.cli import studies as cli_studies
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm, load_case, load_scenario
from crosscheck.models.trajectory import recorded_times
from crosscheck.provenance import ROOT
from crosscheck.registry import build, reference_model, second_engine
from crosscheck.studies import plot
from crosscheck.studies.plot import STYLE, find_state_boundary, make_study_figure
from tests.studies.studies import content, study

PEAKS = [{"kind": "peak", "signal": "theta_ddot"}]
SHORT = {"scenario.duration_s": 0.002}
UNIFORM = {"kind": "uniform", "relative_tolerance": 0.2}
BACKLASH = "arm.joints.*.*_mesh.backlash_m"


def _made(out: Path, jobs: int) -> Path:
    """Of two grid axes, one of words, samples and starts."""
    package.sweep(
        "paper-labelled",
        [
            {"path": "arm.payload_mass_kg", "kind": "grid", "start": 5, "stop": 15, "count": 3},
            {"path": "switches.phase", "kind": "list", "values": ["angle", "omega_t"]},
            {"path": "arm.joints.*.*_mesh.damping_ratio", **UNIFORM},
            {"path": BACKLASH, "each": True, **UNIFORM},
        ],
        scenario="pd",
        settings=SHORT,
        measures=[*PEAKS, {"kind": "trajectories", "signals": ["theta", "F_sp"]}],
        samples={"count": 2, "seed": 3},
        starts={"count": 2, "seed": 7},
        spot_checks=2,
        jobs=jobs,
        out=out,
    )
    return out


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _made(tmp_path_factory.mktemp("result") / "out.nc", 1)


def test_every_number_is_where_its_axes_say(result):
    with xr.open_dataset(result) as found:
        sizes = {"payload_mass_kg": 3, "phase": 2, "sample": 2, "start": 2, "joint": 2}
        assert dict(found.theta_ddot_peak.sizes) == sizes
        one = found.isel(sample=1, start=1).sel(payload_mass_kg=10, phase="omega_t")
        settings = [
            f"arm.joints.{place // 2}.{side}_mesh.backlash_m={float(one.backlash_m[place])!r}"
            for place, side in enumerate(("sun", "ring", "sun", "ring"))
        ]
        settings += [
            "scenario.duration_s=0.002",
            f"arm.joints.*.*_mesh.damping_ratio={float(one.damping_ratio)!r}",
        ]
        case = load_case("paper-labelled", "pd", {"phase": "omega_t"}, settings)
        run = build(reference_model(), *case).simulate()
        # its start is perturbed by 1e-12 m, which the teeth's stiffness makes 1e-4 N
        assert one.theta.values == pytest.approx(run.theta.values, abs=1e-12)
        assert one.F_sp.values == pytest.approx(run.F_sp.values, abs=1e-2)
        assert one.theta_ddot_peak.values == pytest.approx(
            np.abs(run.theta_ddot.values).max(axis=0), rel=1e-5
        )


def test_axes_carry_units_and_what_they_vary(result):
    with xr.open_dataset(result) as found:
        assert found.payload_mass_kg.attrs["units"] == "kg"
        assert found.backlash_m.attrs == {"units": "m", "long_name": BACKLASH}
        assert found.theta_ddot_peak.attrs["units"] == "rad s-2"
        assert list(found.phase.values) == ["angle", "omega_t"]
        assert found.start.values.tolist() == [7, 8]  # by which a member's start is drawn again
        assert json.loads(found.attrs["provenance"])["switches"] is not None
        assert {"backlash_m", "damping_ratio"} <= set(found.coords)
        case = load_case("paper-labelled", "pd", settings=["scenario.duration_s=0.002"])
        assert np.array_equal(found.time.values, recorded_times(case.scenario))


def test_spot_checks_are_the_second_engines_numbers(result):
    with xr.open_dataset(result) as found:
        assert found.checked.values.tolist() == [6, 18]
        assert second_engine() in found.checked.attrs["long_name"]
        assert found.checked_phase.values.tolist() == [1, 0]
        ours = found.theta_ddot_peak.values.reshape(24, 2)[[6, 18]]
        theirs = found.theta_ddot_peak_checked.values
        assert np.array_equal(found.theta_ddot_peak_difference.values, np.abs(ours - theirs))
        # the same steps in other coordinates: rounding growth over 200 of them
        assert theirs == pytest.approx(ours, rel=1e-8)
        assert 0 < found.theta_ddot_peak_difference_over_spread.values.max() < 1e-6
        assert found.theta_difference.values.max() < 1e-12


def test_a_result_is_the_same_again(result, tmp_path):
    again = content(_made(tmp_path / "out.nc", 2))
    assert again.keys() >= {"theta_ddot_peak", "backlash_m", "sample", "start"}
    assert again.keys() >= {"diverged_s", "checked"}
    assert again == content(result)


def test_what_the_user_gives_as_records_is_taken_as_it_is():
    arm, scenario = load_arm("three-unlike"), load_scenario("constant-torque")
    axes, settings = {"arm.payload_mass_kg": np.array([2])}, ["arm.payload_mass_kg=2"]
    found = package.sweep(arm, axes, scenario=scenario, settings=SHORT, measures=PEAKS)
    settings.append("scenario.duration_s=0.002")
    case = load_case("three-unlike", "constant-torque", settings=settings)
    run = build(reference_model(), *case).simulate()
    largest = np.abs(run.theta_ddot.values).max(axis=0)
    # the ensemble's rounding against that of one run
    assert found.theta_ddot_peak.values[0] == pytest.approx(largest, rel=1e-9)


@pytest.mark.parametrize("quantity", [[], ["--quantity", "theta_ddot_peak"] * 2])
def test_a_result_is_drawn(result, tmp_path, crosscheck, quantity):
    out = tmp_path / "out.png"
    code, said, err = crosscheck("plot", result, "--out", out, *quantity)
    assert (code, err) == (0, "")
    assert str(out) in said
    picture = matplotlib.image.imread(out)
    assert picture.shape[0] > picture.shape[1]  # one drawing above the other, of two joints
    assert np.ptp(picture) > 0.5
    assert not quantity or picture.shape[0] < 2 * picture.shape[1]


def test_a_single_member_is_drawn_too(tmp_path, crosscheck):
    out = tmp_path / "single.nc"
    package.sweep(
        "paper-labelled", [], scenario="pd", settings=SHORT, measures=PEAKS, out=out, jobs=1
    )
    code, _, err = crosscheck("plot", out)
    assert (code, err) == (0, "")
    assert out.with_suffix(".png").stat().st_size > 10_000


def test_two_states_are_distinguished_from_one():
    generator = np.random.default_rng(1)
    one = generator.uniform(size=200)
    assert find_state_boundary(one) is None
    assert find_state_boundary(np.where(one > 0.5, one + 3, one)) == pytest.approx(2, abs=0.6)
    assert find_state_boundary(np.array([1.0, np.nan])) is None
    assert find_state_boundary(np.ones(9)) is None
    far = np.append(np.where(one > 0.5, one + 3, one).ravel(), 1e5)
    assert find_state_boundary(far) == pytest.approx(2, abs=0.6)
    for outliers, is_state in ((4, False), (5, True)):  # of 200 members
        some = np.append(one[: 200 - outliers], np.full(outliers, 9.0))
        assert (find_state_boundary(some) is not None) == is_state


@pytest.mark.parametrize(("count", "shown"), [(40, 40), (41, 21)])
def test_forty_words_stand_along_an_axis_and_forty_drawings_above_each_other(
    count, shown, monkeypatch
):
    ticks = []
    words: Any = SimpleNamespace(values=np.array([f"w{n}" for n in range(count)]), size=count)
    words.dtype = words.values.dtype
    plot._mark(words, pytest.fail, lambda places, texts: ticks.extend(texts))
    assert len(ticks) == shown
    content = {"all": SimpleNamespace(sizes={"joint": count})}
    result: Any = SimpleNamespace(path="r.nc", content=content, read_variables=lambda names: 0)
    monkeypatch.setattr(plot, "drawable_names", lambda result: ["all"])
    monkeypatch.setattr(plot, "draw_png", lambda result, names: b"drawn")
    with nullcontext() if count == 40 else pytest.raises(InputError, match="41 drawings, 1 to 40"):
        assert plot.draw_selected([], result) == b"drawn"


def test_no_label_shows_the_signs_of_a_formula():
    """Ticks of a log axis are typeset, and what a file says is not, dollars and all."""
    ratio = xr.DataArray(np.geomspace(1e-3, 2e-2, 6), dims="ratio", attrs={"units": "$x$"})
    title = {"long_name": r"what it costs: $5 or $6 \alpha"}
    peak = xr.DataArray(np.arange(6.0), coords={"ratio": ratio}, attrs=title)
    with mpl.rc_context(STYLE):
        study = xr.Dataset({"peak": peak}, attrs={"title": "$5 a drive"})
        (axes,) = make_study_figure(study, ["peak"]).axes
        assert axes.get_xscale() == "log"
        axes.figure.draw_without_rendering()
    ticks = [*axes.get_xticklabels(which="both"), *axes.get_yticklabels()]
    assert all(t.get_parse_math() for t in ticks if "\\" in t.get_text())
    assert axes.figure.get_suptitle() == r"\$5 a drive"
    for label in (axes.title, axes.xaxis.label):
        plain = label.get_text().replace(r"\$", "")
        assert "$" not in plain


def test_the_example_of_backlash_shows_what_backlash_does():
    """Of fewer draws: the quantities of one backlash and of the next lie apart."""
    text = (ROOT / "examples/studies/backlash.toml").read_text(encoding="utf-8")
    given = tomllib.loads(text)
    asked = {name: given[name] for name in ("scenario", "settings")}
    asked |= {"measures": given["quantities"], "samples": given["samples"] | {"count": 2}}
    found = package.sweep(given["arm"], given["axes"], **asked, starts=1)
    for quantity in (found.theta_ddot_peak_joint1, found.theta_rigid_deviation_coupled[..., 0]):
        drawn = [dim for dim in quantity.dims if dim != "backlash_m"]
        least, largest = quantity.min(drawn).values, quantity.max(drawn).values
        assert (least[1:] > largest[:-1]).all()


@pytest.mark.parametrize("columns", ["80", "40"])
def test_numbers_of_a_sweep_are_whole_on_a_narrow_terminal(tmp_path, capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", columns)
    values = {"path": "arm.payload_mass_kg", "kind": "list", "values": [1.0, 2.0, 3.0]}
    made = study([values], [{"kind": "rigid_deviation"}])
    name = "theta_rigid_deviation_coupled"
    numbers = {
        "diverged_s": ("payload", np.full(3, np.nan)),
        name: ("payload", [8.25914e-07, 3.10953e-06, 1.04956e-05]),
        f"{name}_difference": ("checked", [6.8e-21]),
        f"{name}_difference_over_spread": ("checked", [1e-15]),
    }
    xr.Dataset(numbers, {"checked": [0]}).to_netcdf(tmp_path / "out.nc", engine="h5netcdf")
    cli_studies._print_ranges(made, tmp_path / "out.nc")
    words = capsys.readouterr().out.split()
    for number in ("8.25914e-07", "3.10953e-06", "1.04956e-05", "6.8e-21"):
        assert number in words


def test_axes_of_a_drawing_have_the_scales_of_their_points():
    """Equal ratios are logarithmic, words stand for numbers; a lost member hides no ticks."""
    ratios, words = [1.0, 10.0, 100.0, 1000.0], ["low", "middle", "high"]
    values = np.arange(12.0).reshape(4, 3)
    values[0, 0] = np.nan
    whole = xr.DataArray(values, {"ratio": ratios, "word": words}, ("ratio", "word"), "a")
    made = xr.Dataset({"a": whole, "b": whole.T, "c": whole.isel(word=0, drop=True)})
    first, second, curve = make_study_figure(made, ["a", "b", "c"]).axes[:3]
    assert (first.get_yscale(), first.get_xscale()) == ("log", "linear")
    assert (second.get_xscale(), second.get_yscale()) == ("log", "linear")
    for axis in (first.xaxis, second.yaxis):
        assert [text.get_text() for text in axis.get_ticklabels()] == words
    assert curve.get_xscale() == "log"
    assert not plot._is_logarithmic(np.array([-1.0, 0.0, 1.0]))
    assert len(curve.get_yticks()) > 0


@pytest.mark.parametrize(
    ("name", "unit", "label"),
    [
        ("play_m", "m", "play [m]"),
        ("theta_dot_peak_joint2", "rad s-1", "peak rate of joint 2 [rad/s]"),
        ("torque_peak_to_peak", "N m", "peak to peak torque [N m]"),
        ("theta_settling_joint1", "s", "settling of joint 1 [s]"),
        ("theta_finally", "rad", "theta finally [rad]"),
    ],
)
def test_an_axis_of_a_drawing_is_labelled_in_words(name, unit, label):
    assert plot._axis_label(xr.DataArray(0, name=name, attrs={"units": unit})) == label
