"""Numbers of a cross-check's plots, of its 3-D view and behind its report, worked out again.

The records are values at states, trajectories and findings of a small run; here they meet numpy
alone. A few findings are made anew on either side of their tolerance, so that each verdict occurs.
"""

import base64
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from crosscheck.findings import Finding
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import Case, load_arm, load_scenario
from crosscheck.planning import arms
from crosscheck.planning.comparison import Results, collect_tasks, judge_comparisons
from crosscheck.planning.plan import Experiment
from crosscheck.registry import RIGID_LEVELS
from crosscheck.report.finding_groups import list_findings
from crosscheck.report.plots import figures, signals
from crosscheck.run import runs_by_key
from crosscheck.runner.tasks import Evaluation, RunKey
from crosscheck.view import scene
from crosscheck.view.trajectory_file import Run
from tests.judged import plan_states
from tests.views.agreements import make_agreement

ARM, STATES, SEED = "probe", 3, 0
STATE_FAMILIES, RUN_FAMILIES = ("states", "form-states"), ("same-step", "form", "deviation")
LEAD, SECOND, PRINTED = "analytic:physical", "exudyn:tree", "analytic:printed"
ENGINES = ("pinocchio:gears", "exudyn:tree", "exudyn:bodies")
START = {
    "theta_rad": [0.3, -0.8],
    "theta_dot_rad_per_s": [0.6, -0.9],
    "sun_planet_offset_m": [2e-6, 5e-6],
    "planet_ring_offset_m": [-3e-6, 4e-6],
}


class Records(NamedTuple):
    """What the small run left: answers by model and quantity, runs and findings."""

    arm: Arm
    results: Results
    values: dict[tuple[str, str], np.ndarray]
    runs: dict[str, xr.Dataset]
    findings: list[Finding]


def moving_scenario() -> Scenario:
    """2 ms of PD control from a start in motion."""
    grid = {"duration_s": 2e-3, "step_s": 1e-5, "record_every": 5, "start": START}
    own = load_scenario("pd").model_dump()
    return Scenario.model_validate({**own, **grid})


@lru_cache
def records() -> Records:
    """The records of the probe arm, whose numbers are all unequal; made once."""
    arm = printed_arm()
    asked = [c for c in plan_states(arm, STATES, SEED) if of_views(c.about.key)]
    case = Case(arm, moving_scenario(), usual_switches(arm))
    own = arms.plan_experiment_comparisons(Experiment("pd", case))
    asked += [c for c in own if c.about.key.family in RUN_FAMILIES]
    outcomes = {task.key: task.perform() for task in collect_tasks(asked)}
    results = Results(outcomes)
    values = {
        (key.model, key.quantity): outcome
        for key, outcome in outcomes.items()
        if isinstance(key, Evaluation)
    }
    runs = {k.model: r for k, r in runs_by_key(results).items() if k == RunKey("pd", k.model)}
    return Records(arm, results, values, runs, list(judge_comparisons(asked, results)))


def printed_arm() -> Arm:
    """The probe arm as the paper's equations cover it: three planets, no gravity, no friction."""
    own = load_arm(ARM)
    alike = {"planet_count": 3, "friction_N_m_s_per_rad": 0.0}
    joints = []
    for joint in own.joints:
        sun = joint.sun_mesh.model_copy(update={"static_error_m": 3e-6})
        ring = joint.ring_mesh.model_copy(update={"static_error_m": -2e-6, "backlash_m": 7e-5})
        joints.append(joint.model_copy(update={**alike, "sun_mesh": sun, "ring_mesh": ring}))
    return own.model_copy(update={"joints": tuple(joints), "gravity_m_per_s2": (0.0, 0.0)})


def of_views(key: Any) -> bool:
    """Whether a comparison of states is among those that the views show here."""
    where = (f"{ARM}/geared", *(f"{ARM}/{level}" for level in RIGID_LEVELS))
    return key.family in STATE_FAMILIES and key.case in where


def report_problems() -> Iterator[str]:
    """What of the small run's findings does not follow from their numbers, or from the values."""
    made, agreement = records(), make_agreement("arm", False, 1)
    for f in agreement.findings:
        if f.verdict != verdict_of(f):
            yield f"{f.id}: {f.verdict}"
    listed = []
    for group in list_findings(agreement.findings).groups:
        found = [row.finding for row in group.rows]
        listed += [f.id for f in found]
        failed = [f for f in found if f.kind == "check" and f.verdict != "agree"]
        if group.is_open != bool(failed) or found[: len(failed)] != failed:
            yield f"{group.title}: failures are not shown first"
        shares = [f.measured / f.tolerance for f in found if f.verdict == "agree" and f.tolerance]
        if shares != sorted(shares, reverse=True):
            yield f"{group.title}: not the tightest first"
        for row in group.rows:
            if row.reason.split() != f"{row.finding.basis} {row.finding.note}".split():
                yield f"{row.finding.id}: {row.reason}"
    if sorted(listed) != sorted(f.id for f in agreement.findings):
        yield "the groups do not hold every finding once"
    models = arms.sample_arm(made.arm, STATES, SEED)
    for each in arms.compute_entry_differences(made.arm, models, made.results):
        expected = entry_table(made, each.model)
        if each.quantity == "mass_matrix" and not np.allclose(each.relative, expected, 1e-9, 0):
            yield f"{each.model}: {each.relative}; are {expected}"
    for f in made.findings:
        if (f.about.key.family, f.quantity) == ("deviation", "tip"):
            apart = np.abs(tip_of(made.runs[f.left], made.arm) - tip_of(made.runs[LEAD], made.arm))
            if not np.isclose(f.measured, apart.max(), rtol=1e-9):
                yield f"{f.id}: {f.measured}; is {apart.max()}"


def verdict_of(f: Finding) -> str:
    """The verdict that a finding's numbers demand; its own where none is judged."""
    if f.measured is None or f.verdict == "unresolved":
        return f.verdict
    return "measured" if f.tolerance is None else "differ" if f.measured > f.tolerance else "agree"


def entry_table(made: Records, model: str) -> np.ndarray:
    """Largest difference of M's entries from any engine, over the root of the right M_ii M_jj."""
    own, right = (made.values[each, "mass_matrix"] for each in (model, LEAD))
    size = np.sqrt(np.diagonal(right, axis1=1, axis2=2))
    size = size[:, :, None] * size[:, None, :]
    apart = [np.abs(own - made.values[engine, "mass_matrix"]) / size for engine in ENGINES]
    return np.max(apart, axis=(0, 1))


def tip_of(run: xr.Dataset, arm: Arm) -> np.ndarray:
    """Position of the tip (times,) [m], as a complex number."""
    absolute = np.cumsum(run["theta"].values, axis=1)
    return np.exp(1j * absolute) @ [link.length_m for link in arm.links]


def first_planets(run: xr.Dataset, quantity: str, joint: int) -> np.ndarray:
    """A quantity of a joint, counted from 1, and planet 1, (times,)."""
    values = run[quantity].values
    return values[:, joint - 1, 0] if values.ndim == 3 else values[:, joint - 1]


def unlike_planets(run: xr.Dataset) -> xr.Dataset:
    """A run of planets that move alike, with the second's and the third's numbers twice and three
    times as large.
    """
    return run.map(lambda values: values * values["planet"] if "planet" in values.dims else values)


def signal_problems() -> Iterator[str]:
    """What in the plots' numbers is not as the runs have it."""
    models = (LEAD, SECOND, PRINTED, "pinocchio:links")
    made = {name: unlike_planets(records().runs[name]) for name in models}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(signals, "HALF_WINDOW_S", 2e-5)
        (found,) = signals.collect_signals(LEAD, {"pd": made})
    units = signals.format_signals([found])["quantities"]
    time = made[LEAD]["time"].values
    for line in found.lines:
        own = first_planets(made[line.model], line.quantity, line.joint)
        if line.model != LEAD:
            own = own - first_planets(made[LEAD], line.quantity, line.joint)
        stretch = found.whole[line.quantity]
        if not np.array_equal(unpacked(stretch.data[line.name]), own.astype("f4")):
            yield f"{line.name}: values"
        if line.peak != float(np.abs(own).max()):
            yield f"{line.name}: peak {line.peak}"
        times = stretch.start_s + stretch.step_s * np.arange(stretch.count)
        if stretch.count != time.size or not np.allclose(times, time, atol=1e-12):
            yield f"{line.name}: times"
    expected = {"theta": "rad", "theta_ddot": "rad/s²", "x_sp": "m", "F_sp": "N", "F_pr": "N"}
    if {name: each["unit"] for name, each in units.items()} != expected:
        yield f"units {units}"
    peaks = {joint: np.abs(first_planets(made[LEAD], "F_sp", joint)) for joint in (1, 2)}
    joint = max(peaks, key=lambda each: peaks[each].max())
    at = float(time[int(peaks[joint].argmax())])
    title = f"largest F_sp, joint {joint}"
    if not any(w.title == title and w.begin_s <= at <= w.end_s for w in found.windows):
        yield f"no window {title} at {at}"


def drawn_figures(made: Records) -> tuple[Figure, Figure]:
    """The figure of the run, and that of the rigid levels, before they become SVG."""
    kept: list[Figure] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "to_svg", lambda figure: kept.append(figure) or "")
        figures.draw_run_comparison(made.runs[LEAD], made.runs[SECOND])
        figures.draw_level_deviations(
            made.runs[LEAD], {level: made.runs[f"pinocchio:{level}"] for level in RIGID_LEVELS}
        )
    return kept[0], kept[1]


AXES = {  # of the run's figure: what is in a row, its label, and its unit's size
    "theta": ("joint angle [rad]", 1.0),
    "theta_ddot": ("acceleration [rad/s²]", 1.0),
    "x_sp": ("x_sp, planet 1 [µm]", 1e-6),
    "F_sp": ("F_sp, planet 1 [kN]", 1e3),
}


def figure_problems() -> Iterator[str]:
    """What in the figures is not as the runs have it."""
    made = records()
    made = made._replace(runs={name: unlike_planets(run) for name, run in made.runs.items()})
    run, levels = drawn_figures(made)
    time = made.runs[LEAD]["time"].values
    for row, (quantity, (label, unit)) in enumerate(AXES.items()):
        left, right = run.axes[2 * row : 2 * row + 2]
        if left.get_ylabel() != label:
            yield f"{quantity}: {left.get_ylabel()}"
        for joint in (1, 2):
            own = first_planets(made.runs[LEAD], quantity, joint)
            gap = np.abs(own - first_planets(made.runs[SECOND], quantity, joint))
            for axes, expected in ((left, own / unit), (right, np.maximum(gap, 1e-20))):
                yield from line_problems(axes, f"joint {joint}", time, expected)
    for joint, axes in enumerate(levels.axes, 1):
        if axes.get_title() != f"joint {joint}":
            yield f"levels: {axes.get_title()}"
        for level in RIGID_LEVELS:
            run_of_level = made.runs[f"pinocchio:{level}"]
            gap = first_planets(run_of_level, "theta", joint) - first_planets(
                made.runs[LEAD], "theta", joint
            )
            yield from line_problems(axes, level, time, np.maximum(np.abs(gap), 1e-12))


def line_problems(axes: Any, name: str, time: np.ndarray, expected: np.ndarray) -> Iterator[str]:
    """Whether a line of this name has these values."""
    lines = [line for line in axes.lines if line.get_label() == name]
    if len(lines) != 1:
        yield f"{axes.get_ylabel()}: {len(lines)} lines {name}"
        return
    if not np.array_equal(lines[0].get_xdata(), time):
        yield f"{axes.get_ylabel()}, {name}: times"
    if not np.allclose(lines[0].get_ydata(), expected, rtol=1e-12, atol=0):
        yield f"{axes.get_ylabel()}, {name}: values"


def unpacked(text: str) -> np.ndarray:
    """Numbers of a page."""
    return np.frombuffer(base64.b64decode(text), "<f4")


def view_problems(phase: str) -> Iterator[str]:
    """What in a run's scene is not as the run has it, by a law of the mesh phase.

    Planets are unlike; every third record is shown.
    """
    made, every = records(), 3
    run, arm = unlike_planets(made.runs[LEAD]), made.arm
    names = ("theta", "theta_dot", "x_sp", "x_pr", "F_sp", "F_pr")
    signals_of, law = {name: run[name].values for name in names}, usual_switches(arm, phase=phase)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scene, "MOST_FRAMES", -(-run.sizes["time"] // every))
        shown = scene.build_scene(Run(LEAD, arm, run["time"].values, signals_of, law))
    time = run["time"].values[::every]
    frames = shown["start_s"] + shown["step_s"] * np.arange(shown["frames"])
    if shown["every"] != every or frames.size != time.size or not np.allclose(frames, time):
        yield f"times: {shown['step_s']} s, {shown['frames']} of one in {shown['every']}"
    for place, (joint, link) in enumerate(zip(shown["joints"], arm.links, strict=True)):
        if joint["length_m"] != link.length_m:
            yield f"length of link {place + 1}"
        yield from same_values(
            f"theta {place}", joint["theta"], run["theta"].values[::every, place]
        )
        gears, theta = arm.joints[place], run["theta"].values[::every, place]
        teeth_sum, module = gears.sun_teeth + gears.planet_teeth, gears.module_m
        drawn = {"carrier_m": teeth_sum / 2, "rim_m": gears.ring_teeth / 2 + 4, "face_m": 6}
        if any(not np.isclose(joint[name], module * by) for name, by in drawn.items()):
            yield f"sizes of stage {place + 1}"
        for name, count in (("sun", gears.sun_teeth), ("ring", gears.ring_teeth)):
            ends = np.hypot(*np.transpose(joint["outlines"][name]))
            # A tooth ends a module beyond its pitch circle, a ring's inside of it.
            end = ends.min() if name == "ring" else ends.max()
            far = count / 2 + (-1 if name == "ring" else 1)
            if not abs(end - module * far) <= 1.5e-6:
                yield f"outline of {name} {place + 1}: {end}, must be {module * far}"
        base = module / 2 * np.cos(np.radians(gears.pressure_angle_deg))
        x_sp, x_pr = (run[f"x_{side}"].values[::every, place] for side in ("sp", "pr"))
        rolled = base * teeth_sum * theta
        sun = (x_sp[:, 0] + x_pr[:, 0] + 2 * rolled) / (base * gears.sun_teeth)
        yield from same_values(f"sun {place}", joint["sun"], sun)
        for planet, own in enumerate(joint["planets"]):
            turned = -(x_pr[:, planet] + rolled) / (base * gears.planet_teeth)
            yield from same_values(f"planet {planet} of {place}", own, turned)
        for side, teeth in (("sun", gears.sun_mesh), ("ring", gears.ring_mesh)):
            mesh, own = joint["meshes"][side], teeth.planet_mesh(0)
            name = {"sun": "sp", "ring": "pr"}[side]
            x, force = (run[f"{q}_{name}"].values[::every, place, 0] for q in ("x", "F"))
            yield from same_values(f"force {side}", mesh["force"], force)
            # Every tooth of the ring passes a planet in a turn of the carrier; by Eq. 13 the sun's.
            printed = side == "ring" and law.ring_rate == "eq13"
            passing = gears.sun_teeth if printed else gears.ring_teeth
            rates = run["theta_dot"].values[::every, place]
            turned = passing * (theta if phase == "angle" else rates * time)
            wave = np.sin(turned + own.phase_rad + own.tooth_error_phase_rad)
            gap = x - own.static_error_m - own.tooth_error_m * wave
            yield from same_values(f"x - e, {side}", mesh["gap"], gap, 1e-12)
            if mesh["half_clearance_m"] != own.backlash_m:
                yield f"backlash, {side}"
            beyond = np.abs(gap) - own.backlash_m
            touches = np.where(beyond > 0, np.sign(gap), 0)
            if phase == "angle" and not np.array_equal(np.sign(force), touches):
                yield f"contact, {side}"


def same_values(name: str, text: str, expected: np.ndarray, atol: float = 0.0) -> Iterable[str]:
    """A problem if packed numbers are not these."""
    found = unpacked(text)
    same = found.shape == expected.shape and np.allclose(found, expected, rtol=2e-7, atol=atol)
    return () if same else (name,)


VIEW_PROBLEMS = {
    "report": report_problems,
    "signals": signal_problems,
    "figures": figure_problems,
    "scene": lambda: chain.from_iterable(map(view_problems, ("angle", "omega_t"))),
}
