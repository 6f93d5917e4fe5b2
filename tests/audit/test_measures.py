"""What is measured of made-up runs whose numbers are known; events; the preloaded start."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck import signals
from crosscheck.analytic.derivation.stage import equivalent_masses
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.audit.experiments import experiments
from crosscheck.audit.experiments.ensembles import (
    ALIKE,
    PERTURBATION_ITSELF,
    EnsembleNumbers,
    are_alike,
)
from crosscheck.audit.experiments.paper_conditions import INTEGRAL, PRINTED, Condition
from crosscheck.audit.experiments.pd import (
    CONVERGED_S,
    MULTIPLES,
    measure_transient_pd,
    measure_whole_pd,
)
from crosscheck.audit.experiments.torque import (
    ERROR_WINDOWS_S,
    RING_CYCLES,
    SETTLED_S,
    find_tip,
    measure_back_and_forth,
    measure_constant_torque,
)
from crosscheck.audit.experiments.variant import (
    COUPLED,
    GEARED_MODELS,
    Variant,
    remove_gears,
    rigid_arm,
)
from crosscheck.audit.figures.sweeps import find_spectrum
from crosscheck.audit.measures import events
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.measures.stage import geared_joint
from crosscheck.models.loading import load_case
from crosscheck.registry import RIGID_LEVELS, build
from tests.audit.runs import simulate

STEP_S = 5e-5
TIME = np.arange(0, 3, STEP_S)
CASE = load_case("paper-labelled", "pd", {}, [])
TARGET, K_M = np.pi / 6, 1e8  # rad; N/m, Table I
LEFT_S, MET_S, RETURN_S = 0.35, 0.36, 1.5
ON_DRIVING = np.where((TIME < LEFT_S) | (TIME > RETURN_S), 100.0, 0.0)
FORCE = ON_DRIVING - 100.0 * ((TIME >= MET_S) & (TIME < RETURN_S - 0.005))

PRELOADED, LOADED, TURNING = (
    experiments.EXPERIMENTS[name]
    for name in ("preloaded", "constant torque, preloaded", "turning back, b = 3000 um")
)


def made(
    excess: np.ndarray, force: np.ndarray = FORCE, elbow: np.ndarray = FORCE, angle: float = 1.0
) -> tuple[RunSignals, RunSignals]:
    """A run and the rigid arm beside it, which has no acceleration but the constant 0.5.

    No ring mesh ever parts, and the elbow's torque is another one: neither is what is measured.
    """
    way = angle * TARGET * (1 - np.exp(-3 * TIME))
    theta = np.column_stack([way, way])
    rate = np.gradient(theta, TIME, axis=0)
    joints = (theta, rate, np.full(theta.shape, 0.5), np.ones_like(theta))
    x, pressed = 50e-6 * np.sign(force), np.full(TIME.size, 300.0)
    rigid = RunSignals(
        *(CASE, TIME, *joints, x, 0 * x, force, pressed, np.column_stack([elbow, pressed]))
    )
    return replace(rigid, theta_ddot=rigid.theta_ddot + excess[:, None] * (1, 4)), rigid


def burst(begin_s: float, end_s: float, size: float, frequency_Hz: float = 1500.0) -> np.ndarray:
    """A vibration of this size in a part of the run."""
    inside = (begin_s <= TIME) & (end_s > TIME)
    return np.where(inside, size * np.sin(2 * np.pi * frequency_Hz * TIME), 0.0)


def test_the_three_fluctuations_and_the_fourth():
    bursts = (0, 0.02, 40), (0.36, 0.38, 20), (0.5, 0.55, 100), (0.9, 1.1, 300), (1.5, 1.6, 2)
    numbers = measure_whole_pd(*made(sum(burst(*each) for each in bursts)))
    sizes = [numbers[name] for name in ("first", "second", "third", "fourth")]
    # Thirteen samples a period miss a sine's peak by at most 3 %.
    assert sizes == pytest.approx([40, 20, 300, 2], rel=0.03)
    assert numbers["third_growth"] == pytest.approx(3, rel=0.03)
    assert numbers["side_change_s"] == pytest.approx(MET_S, abs=STEP_S)
    assert numbers["flight_s"] == pytest.approx(MET_S - LEFT_S, abs=2 * STEP_S)
    assert numbers["jump_um"] == pytest.approx(100)
    assert numbers["second_delay_s"] == pytest.approx(0, abs=1e-3)
    assert numbers["opposite_share"] == 1
    assert numbers["return_s"] == pytest.approx(RETURN_S, abs=2 * STEP_S)


def test_every_joints_spectrum_is_of_the_shoulders_third_fluctuation():
    """A larger burst of the elbow, at another time and frequency, is not in it."""
    run, rigid = made(burst(0.9, 1.1, 300))
    earlier = np.column_stack([0 * TIME, burst(0.6, 0.7, 5000, 4000.0)])
    run = replace(run, theta_ddot=run.theta_ddot + earlier)
    for joint in (0, 1):
        frequency, amplitudes = find_spectrum(run, rigid, joint)
        assert frequency[np.nanargmax(amplitudes)] == pytest.approx(1500, rel=0.05)


def test_what_was_there_before_a_side_change_is_no_second_fluctuation():
    numbers = measure_transient_pd(*made(burst(0, 0.8, 5)))
    assert numbers["second_over_before"] == pytest.approx(1, rel=0.03)
    assert (
        measure_transient_pd(*made(burst(0, 0.35, 1) + burst(0.35, 0.8, 5)))["second_over_before"]
        > 4
    )


@pytest.mark.parametrize(
    ("rate_per_s", "decay_s"),
    [
        (300.0, np.log(10) / 300),
        (30.0, np.log(10) / 30),
        (3.0, CONVERGED_S),
        (0.0, CONVERGED_S),
        (-30.0, CONVERGED_S),  # it grows
    ],
)
def test_an_impact_converges_once_a_tenth_is_left_counted_from_the_impact(rate_per_s, decay_s):
    course = np.exp(-rate_per_s * TIME), np.exp(-rate_per_s * (TIME - MET_S))
    size = np.where(MET_S > TIME, course[0], np.where(TIME < 0.6, course[1], 0.0))
    numbers = measure_transient_pd(*made(30 * size * np.sin(2 * np.pi * 1500 * TIME)))
    # To a period of the vibration.
    assert numbers["first_decay_s"] == pytest.approx(decay_s, abs=1 / 1500)
    assert numbers["second_decay_s"] == pytest.approx(decay_s, abs=1 / 1500)


def test_what_eq_11_neglects_is_looked_for_once_the_start_is_over():
    run, rigid = made(np.zeros(TIME.size), force=np.full(TIME.size, 100.0))
    at_start, later = (
        replace(run, x_sp=run.x_sp + 1e-4 * (begin_s < TIME) * (begin_s + 0.01 > TIME))
        for begin_s in (0.01, 0.5)
    )
    assert measure_transient_pd(at_start, rigid)["mesh_rate_over_speed"] < 1e-12
    assert measure_transient_pd(later, rigid)["mesh_rate_over_speed"] > 1e-3


def test_an_uncontrollable_speed_is_one_that_swings_as_far_as_it_goes():
    run, rigid = made(np.zeros(TIME.size))
    for share in (0.1, 2.0):
        swing = share * np.sin(2 * np.pi * 1500 * TIME)[:, None]
        slow = 0.3 * np.ones_like(run.theta_dot)
        shaken = replace(run, theta_dot=slow * (1 + swing))
        assert (measure_transient_pd(shaken, rigid)["speed_fast"] > 1) == (share > 1)


def test_a_late_impact_of_either_joint_is_no_third_fluctuation():
    late = np.where(TIME < 0.6, 100.0, -100.0)
    impact = burst(0.6, 0.65, 50)
    assert measure_transient_pd(*made(impact, elbow=late))["third"] == 0
    assert measure_transient_pd(*made(impact, force=late))["third"] == 0
    assert measure_transient_pd(*made(impact))["third"] == pytest.approx(50, rel=0.03)


def test_multiples_that_stand_out_are_counted():
    noise = 0.3 * np.random.default_rng(1).standard_normal(TIME.size)
    pure = burst(0.5, 1.2, 50) + noise
    assert measure_transient_pd(*made(pure))["overtones"] == 0
    for count, multiple in enumerate(MULTIPLES, start=1):
        pure = pure + burst(0.5, 1.2, 2, multiple * 1500.0)
        assert measure_transient_pd(*made(pure))["overtones"] == count


def test_the_first_sun_mesh_and_each_joints_own_torque_are_measured():
    """A torque's vibration over its largest value, of either joint; the shoulder's frequency."""
    run, rigid = made(burst(0.6, 0.7, 10) + burst(0.9, 1.1, 50))
    shaken = np.column_stack([burst(0.9, 1.1, 0.5, 1500.0), burst(0.5, 1.2, 0.25, 900.0)])
    numbers = measure_whole_pd(replace(run, torque=run.torque + shaken), rigid)
    shares = [numbers[f"torque_fast_{joint}"] for joint in (1, 2)]
    assert shares == pytest.approx([0.5 / 1.5, 0.25 / 1.25], rel=0.03)
    assert numbers["torque_frequency_Hz"] == pytest.approx(1500, abs=10)
    assert numbers["torque_follows"] > 0.95
    assert numbers["second_force_N"] == numbers["third_force_N"] == 100
    assert numbers["return_s"] == pytest.approx(RETURN_S, abs=2 * STEP_S)


def test_numbers_of_constant_torque_in_closed_form():
    """Of the first sun mesh; of the other pairs the one that calms least, or ripples most."""
    case = load_case("paper-labelled", "constant-torque", {}, [])
    joint, time = geared_joint(case.arm), np.arange(0, 0.5, 1e-4)
    early, theta = time < SETTLED_S, np.column_stack([8 * time, 3 * time])

    def vibrating(mean: float, first: float, then: float) -> np.ndarray:
        return mean * (1 + np.where(early, first, then) * np.sin(RING_CYCLES * theta[:, 0]))

    law = joint.sun_mesh.planet_mesh(0).stiffness
    depth = law.amplitude_N_per_m / law.mean_N_per_m
    sun, ring = vibrating(200.0, 1.5 * depth, 0.5 * depth), vibrating(100.0, 0.2, 0.1)
    outer = np.column_stack([vibrating(100.0, 0.6, 0.01), vibrating(100.0, 1.0, 0.25)])
    torque = np.full(theta.shape, 100.0) * (1.0, 0.4)
    # Two swings, then six, whose mean is not their middle; it speeds up, either way, for 0.4 s.
    swings = np.where(time < 0.25, 2 * time, 0.5 + 6 * (time - 0.25)) * 4
    x = 50e-6 + 8e-6 * np.sin(np.pi * swings) ** 4
    rate = np.column_stack([-1 - np.minimum(time, 0.8 - time), np.ones(time.size)])
    run = RunSignals(case, time, theta, rate, rate, torque, x, x, sun, ring, outer)
    shares = dict(zip(RIGID_LEVELS, (0.5, 1.0, 2.0, 4.0), strict=True))
    apart = [np.where(time < time[time.size // 2], 1e-6, 1e-6 * by) for by in shares.values()]
    rigid = [replace(run, theta=theta + np.column_stack([0 * each, each])) for each in apart]
    numbers = measure_constant_torque(run, *rigid)
    geometry, link = stage_geometry(joint), case.arm.links[1].length_m
    right = {
        "force_decay": 3.0,
        "stiffness_follows": 0.5,
        "others_decay": 2.0,
        "others_ripple_N": 50.0,
        "stroke_1": 8 * 0.5 / np.pi,
        "stroke_2": 3 * 0.5 / np.pi,
        "torque_gain": 3 * geometry.r_cp * 300.0 * geometry.n / 100.0,
        "x_middle_um": 54.0,
        "x_ripple_um": 8.0,
        "x_ripple_over_2E": 0.8,
        "theta_1_rad": 4.0,
        "turns_gained": 8.0,
        "speeding_up": 0.8,
    }
    for level, by in shares.items():
        right |= {
            f"growth_{level}": by,
            f"deviation_2_{level}_rad": 1e-6 * max(by, 1.0),
            f"tip_{level}_mm": 1e-3 * link * max(by, 1.0),
            f"relative_{level}": 1e-6 * max(by, 1.0) / 4.0,
            f"stroke_share_{level}": 1e-6 * max(by, 1.0) / np.pi,
        }
        assert numbers[f"deviation_1_{level}_rad"] == numbers[f"own_share_{level}"] == 0
    assert {name: numbers[name] for name in right} == pytest.approx(right, rel=0.01)
    turned = replace(run, theta=theta + np.outer(time / time[-1], (3e-6, 0)))
    of_first = measure_constant_torque(run, *[turned] * len(rigid))
    for level in RIGID_LEVELS:
        assert of_first[f"deviation_1_{level}_rad"] == pytest.approx(3e-6, rel=1e-9)
        assert of_first[f"deviation_2_{level}_rad"] == 0
        assert of_first[f"own_share_{level}"] == pytest.approx(3e-6 / 4.0, rel=0.01)
    # One of the others never falls to a tenth.
    assert numbers["others_decay_s"] == pytest.approx(0.5, abs=0.01)
    ringing = 20 * np.sin(2 * np.pi * 1700 * time) * (time < 0.05) - 30.0 * (time == 0)
    numbers = measure_constant_torque(replace(run, F_sp=200.0 + ringing), *rigid)
    assert numbers["force_at_start_N"] == 170.0
    assert numbers["vibration_decay_s"] == pytest.approx(0.05, abs=1e-3)


def test_the_rigid_arms_own_error_is_that_of_the_one_that_starts_a_little_away():
    time = np.arange(0, 2, 1e-3)
    none = [np.empty(0)] * 5
    run, rigid, shifted = (
        RunSignals(CASE, time, np.full((time.size, 2), angle), *[np.empty(0)] * 3, *none)
        for angle in (1.0, 3.0, 4.5)
    )
    numbers = measure_back_and_forth(run, rigid, shifted)
    assert {numbers[f"error_{when}"] for when in ERROR_WINDOWS_S} == {2.0}
    assert {numbers[f"own_{when}"] for when in ERROR_WINDOWS_S} == {1.5}


def test_the_tip_is_where_a_turned_chain_ends():
    """From relative angles: links of 1 and 0.7 m, stretched, at right angles, folded out."""
    right = np.pi / 2
    tips = find_tip(np.array([[0, 0], [right, -right], [right, right]]), CASE.arm)
    assert tips == pytest.approx([1.7, 0.7 + 1j, -0.7 + 1j])


def test_numbers_of_pd_control_in_closed_form():
    """The joints at constant rates, then slower; meshes that swing at 50 Hz, five times a side."""
    bursts = burst(0.9, 1.1, 300) + burst(1.5, 1.6, 2) + burst(1.95, 2.2, 50)
    run, rigid = made(bursts)
    late, swing = TIME >= 1.0, np.sin(2 * np.pi * 50 * TIME)
    theta = np.column_stack([0.1 * TIME, 0.3 * TIME])
    rate = np.where(late, 0.2, 0.4)[:, None] * (1.0, 1.0)
    off = np.column_stack([2e-5 * swing, np.where(late, 1e-3, 5e-3)])
    run = replace(run, theta=theta + off, theta_dot=rate, x_sp=5e-5 + 1e-6 * swing, x_pr=0 * TIME)
    numbers = measure_whole_pd(run, replace(rigid, theta=theta))
    r_cp, end = stage_geometry(geared_joint(CASE.arm)).r_cp, TIME[-1]
    right = {
        "neglected_in_eq11": 1e-6 * 2 * np.pi * 50 / (2 * r_cp * 0.4),
        "mesh_over_gross": 51e-6 / (2 * r_cp * 0.1 * end),
        "phase_gap_rad": RING_CYCLES * 0.3 * 1.0,  # where 0.4 t ends
        "final_1_rad": TARGET - 0.1 * end,
        "gap_end_rad": 1e-3,
        "deviation_rad": 5e-3,
        "theta_fast_rad": 2e-5 * (1 - (2 / np.pi) ** 2),  # less two means over half a period
        "apart_share": 0.015 / end,
        "third_gap_s": 0.9 - MET_S,
        "fourth": 2.0,
        "speed_at_return": 0.5,
    }
    assert {name: numbers[name] for name in right} == pytest.approx(right, rel=0.03)
    assert numbers["side_changes"] == 0
    sides = np.sign(np.cos(2 * np.pi * 5 * TIME + 0.1))
    assert measure_transient_pd(*made(bursts, force=sides))["side_changes"] == 7


def test_lines_shares_and_frequencies_of_both_joints():
    numbers = measure_transient_pd(*made(burst(0.5, 1.2, 50)))
    assert numbers["frequency_Hz"] == pytest.approx(1500, abs=1)
    assert numbers["line_elbow"] / numbers["line"] == pytest.approx(4)
    assert numbers["line_share"] == pytest.approx(1, abs=1e-3)
    assert numbers["static_over_line"] == pytest.approx(0.5 / 50, rel=0.02)
    low = measure_transient_pd(*made(burst(0.5, 1.2, 50, 200.0)))
    assert low["low_share"] == pytest.approx(1, abs=1e-3)


def test_too_small_a_vibration_has_no_frequency():
    numbers = measure_transient_pd(*made(burst(0.5, 1.2, 0.2)))
    assert numbers["frequency_Hz"] is numbers["overtones"] is numbers["line_share"] is None
    assert numbers["line"] == pytest.approx(0.2, rel=0.03)


def test_zero_acceleration_and_open_teeth():
    everywhere = burst(0, 1.2, 5)
    open_ = np.where(np.abs(np.diff(FORCE, prepend=100.0)) > 0, FORCE, 0.0)
    closed = measure_transient_pd(*made(everywhere))
    assert closed["zero_windows"] == 3
    # The force is zero nowhere but in the 10 ms of flight, of 1.06 s of windows.
    assert closed["apart_at_zero"] == pytest.approx(0.010 / 1.06, rel=0.1)
    assert closed["apart_windows"] == 1
    assert measure_transient_pd(*made(everywhere, force=open_))["apart_at_zero"] > 0.99
    # Teeth apart at one sample alone, the last before the zero or the first after it, count too.
    before = np.flatnonzero(np.diff(np.signbit(made(everywhere)[0].theta_ddot[:, 0])))
    for at in (before, before + 1):
        beside = np.where(np.isin(np.arange(TIME.size), at), 0.0, FORCE)
        assert measure_transient_pd(*made(everywhere, force=beside))["apart_at_zero"] > 0.99
    assert measure_transient_pd(*made(0 * everywhere))["zero_windows"] == 0


def test_the_way_to_the_target():
    ended = measure_whole_pd(*made(np.zeros(TIME.size)))
    assert ended["late_distance_1"] == pytest.approx(np.exp(-3 * 2.6), rel=1e-3)
    assert ended["setback_1"] == 0
    assert measure_whole_pd(*made(np.zeros(TIME.size), angle=1.1))["overshoot_1"] > 0.09
    run, rigid = made(np.zeros(TIME.size))
    shaken = replace(run, theta=run.theta - 0.01 * TARGET * np.sin(np.pi * TIME / 0.1)[:, None])
    # A hundredth either way, where the way has become flat.
    assert measure_whole_pd(shaken, rigid)["setback_1"] == pytest.approx(0.02, rel=0.01)
    assert measure_whole_pd(shaken, rigid)["gap_end_rad"] < 1e-4


PD = experiments.build_question(PRELOADED, Condition(INTEGRAL, 0.02), (1,)).variant


def test_the_preloaded_start_bears_the_drive():
    """Newton for the shoulder's sun, which turns 2 r_cp / r_s times as fast as its carrier."""
    model = build("analytic:physical", *Variant("pd").case())
    rigid = build("analytic:coupled", *rigid_arm(Variant("pd")).case())
    acceleration, _ = rigid.acceleration(0.0, *rigid.start())
    joint = geared_joint(model.arm)
    geometry = stage_geometry(joint)
    motor = 1000 * TARGET / geometry.n
    on_sun = motor / geometry.r_s - 2 * geometry.r_cp * acceleration * equivalent_masses(joint)[0]
    force = on_sun / joint.planet_count
    sun = experiments.resting_offsets(model)[0]
    # Both sides are exact; 1e-9 is rounding.
    assert K_M * sun == pytest.approx(force, rel=1e-9)


def test_no_mesh_of_a_preloaded_start_accelerates():
    model = build(PD.model, *PD.case())
    idle = build(PD.model, *replace(PD, meshes=()).case())
    meshes = ~model.layout.angular
    left, without = (np.abs(m.acceleration(0.0, *m.start())[meshes]).max() for m in (model, idle))
    assert left < 1e-9 * without


@pytest.mark.parametrize("source", [experiments.WIDE, TURNING], ids=str)
def test_the_widest_clearance_is_run_to_the_end(source):
    asked = experiments.build_question(source, Condition(PRINTED, 0.02), (1,))
    case = asked.variant.case()
    assert case.scenario.duration_s == 3


def test_links_turn_back_where_that_is_what_is_asked():
    """Both, on a rigid arm, which the geared one follows."""
    turns = {}
    for source in (experiments.WIDE, TURNING):
        rigid = rigid_arm(
            experiments.build_question(source, Condition(PRINTED, 0.02), (1,)).variant
        )
        rate = simulate(rigid)["theta_dot"].values
        turns[source] = ((rate.min(axis=0) < -0.1) & (rate.max(axis=0) > 0.1)).tolist()
    assert turns == {experiments.WIDE: [True, False], TURNING: [True, True]}


def test_a_preloaded_start_under_constant_torque_does_not_ring():
    at_rest, loaded = (
        experiments.build_question(source, Condition(INTEGRAL, 0.05), (1,))
        .answer()
        .numbers["ringing_N"][0]
        for source in (experiments.CONSTANT, LOADED)
    )
    assert loaded < 0.1 * at_rest


def numbers_of_starts(**values: list[float | None]) -> EnsembleNumbers:
    return EnsembleNumbers(dict(values), [None] * 8, 8)


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (numbers_of_starts(third=[5.0] * 8), True),
        (numbers_of_starts(third=[5.0] * 7 + [5.001]), True),
        (numbers_of_starts(third=[5.0] * 7 + [5.1]), False),
        (numbers_of_starts(third=[5.0] * 7 + [None]), False),
        (numbers_of_starts(third=[None] * 8), True),
        (numbers_of_starts(planets_apart_m=[float(n) for n in range(8)]), True),
        (EnsembleNumbers({"third": [5.0] * 7 + [None]}, [None] * 7 + [0.3], 8), False),
    ],
)
def test_starts_stand_for_others_only_where_they_agree_in_every_number(found, said):
    assert are_alike(found) == said


def test_starts_that_agree_are_those_that_more_starts_agree_with():
    """What is left out would have said the same: run it all the same."""
    asked = experiments.build_question(
        experiments.NO_ERROR, Condition(INTEGRAL, 0.05), tuple(range(1, 13))
    )
    brief = replace(asked, variant=replace(asked.variant, duration_s=0.1))
    answer, later = brief.answer(), replace(brief, seeds=(9, 10, 11, 12)).answer()
    assert (answer.ran, len(answer.diverged_s)) == (8, 12)
    for name, values in later.numbers.items():
        if name not in PERTURBATION_ITSELF and values[0] is not None:
            assert answer.numbers[name][8:] == pytest.approx(values, rel=2 * ALIKE)


SHORT_TIME = np.arange(0, 1.5, 1e-3)


def test_the_third_fluctuations_onset_and_peak():
    excess = np.where(SHORT_TIME < 0.8, 0.1, np.exp((SHORT_TIME - 0.8) / 0.1))
    window = events.third_window(SHORT_TIME)
    onset = signals.onset(SHORT_TIME[window], excess[window])
    assert onset == pytest.approx(1.199 - 0.1 * np.log(2), abs=2e-3)
    near = events.third_peak(SHORT_TIME, excess, window)
    assert SHORT_TIME[near.start] == pytest.approx(1.199 - events.PEAK_S, abs=2e-3)
    assert SHORT_TIME[near.stop - 1] <= 1.199


def test_the_third_fluctuation_of_a_run_that_ends_before_is_empty():
    assert SHORT_TIME[:400][events.third_window(SHORT_TIME[:400])].size == 0


def test_a_contact_before_the_load_turns_is_no_side_change():
    force = np.where((SHORT_TIME > 0.21) & (SHORT_TIME < 0.22), -1.0, 1.0)
    assert events.side_change(SHORT_TIME, force) is None


def test_an_overshoot_is_over_the_step():
    angle = 0.5 * (1 - np.exp(-SHORT_TIME / 0.1) * np.cos(2 * np.pi * SHORT_TIME / 0.2))
    assert events.overshoot(angle, 0.5) == pytest.approx(angle.max() / 0.5 - 1)


def test_geared_runs_share_their_rigid_arm():
    tight = ("arm.joints.*.*_mesh.backlash_m=0.0",)
    some = Variant(zeta=0.01, phase="omega_t", seed=3, meshes=tight, record_every=7)
    more = replace(some, ring_rate="eq13", planets="free", mesh_work="conservative", harmonics=15)
    assert rigid_arm(more) == rigid_arm(some) == rigid_arm(Variant())


def test_printed_equations_have_a_rigid_arm_of_their_own():
    printed = Variant(model=GEARED_MODELS["printed"])
    assert rigid_arm(printed).model == "analytic:printed-rigid"
    assert rigid_arm(printed, "links") == rigid_arm(Variant(), "links")
    assert rigid_arm(Variant(), "links").model == "analytic:links"


def test_what_is_no_mesh_stays_in_the_rigid_arm():
    two = Variant(settings=("arm.joints.*.planet_count=2",), duration_s=0.5)
    assert rigid_arm(two, COUPLED).case().arm == two.case().arm
    assert rigid_arm(two).case().scenario.duration_s == 0.5
    assert remove_gears(two).case().scenario == two.case().scenario


def test_a_side_change_is_that_of_the_load_not_of_a_vibration():
    turning = np.where(SHORT_TIME < 0.35, 1.0, np.where(SHORT_TIME < 0.36, 0.0, -1.0))
    side = events.side_change(SHORT_TIME, turning)
    assert (side.left_s, side.met_s) == pytest.approx((0.349, 0.36), abs=2e-3)
    assert events.side_change(SHORT_TIME, np.cos(2 * np.pi * SHORT_TIME / 0.01)) is None
    early = np.where((SHORT_TIME > 0.3) & (SHORT_TIME < 0.302), -1.0, turning)
    assert events.side_change(SHORT_TIME, early) is None
    soon = np.where((SHORT_TIME > 0.3) | (abs(SHORT_TIME - 0.24) < 0.005), -1.0, 1.0)
    assert events.side_change(SHORT_TIME, soon) is None


def test_bouncing_ends_with_the_last_loss_of_contact():
    force = np.where((SHORT_TIME > 0.42) & (SHORT_TIME < 0.43), 0.0, -1.0)
    assert events.bounce_duration(SHORT_TIME, force, 0.4) == pytest.approx(0.029, abs=2e-3)
    assert events.bounce_duration(SHORT_TIME, force, 0.5) == 0
