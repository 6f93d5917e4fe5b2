"""How a cross-check judges: beside a number that is wrong by just less than it may, and by more.

Sizes and tolerances are worked out here once more, from right answers and the arm's data alone.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from pydantic import TypeAdapter

from crosscheck import registry
from crosscheck.checks import convergence, energy, invariants, modes, records, scales, trajectories
from crosscheck.checks.answers import States
from crosscheck.checks.corners import sample_corner_states
from crosscheck.checks.scales import ReasonedLimit
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout
from crosscheck.models.arm.mesh import PlanetMesh
from crosscheck.models.arm.meshes import change_meshes
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.arm.stiffness import SineStiffness, StiffnessLaw
from crosscheck.models.experiment.scenario import ConstantDrive, expand_to_joints, switches
from crosscheck.models.interface import STATE_ABILITIES
from crosscheck.models.loading import Case, load_arm, load_scenario
from crosscheck.planning import arms, plan
from crosscheck.planning.comparison import Comparison, ModelTask, Results, collect_tasks
from crosscheck.planning.sizing import make_unequal_gains_scenario
from tests.arms import arm_of
from tests.judged import plan_states
from tests.mixed_arms import LAWS

STATES, SEED, SPOT = 9, 1, 4  # the one state whose answer is wrong
ABOVE, BELOW = 1.02, 0.98  # of a tolerance
# The same of a tolerance of a few roundings, of which models that agree are some apart.
WELL_ABOVE, WELL_BELOW = 1.2, 0.8
EPS = 2.0**-52
# Tolerances of states, of M, and of a bias that follows from M.
SHARPEST, OF_M, FOLLOWS = 50 * EPS, 200 * EPS, 1e-11
GEARED, RIGID = ("geared", "wide", "apart"), ("like", "unlike")
LEFT = dict.fromkeys(GEARED, "analytic:physical") | dict.fromkeys(RIGID, "analytic:carriers")
RIGHT = dict.fromkeys(GEARED, "pinocchio:gears") | dict.fromkeys(RIGID, "pinocchio:carriers")
SUBJECT = Subject(ComparisonKey("family", "case", "theta", "one", "other"), "1", "largest")


def direct_arm(first_m: float) -> Arm:
    """An arm of three direct joints, unlike each other; its first link is so long."""
    arm = arm_of(3, direct=(0, 1, 2))
    first = arm.links[0].model_copy(update={"length_m": first_m})
    return arm.model_copy(update={"links": (first, *arm.links[1:])})


ARMS: dict[str, Callable[[], Arm]] = {
    "geared": lambda: load_arm("probe"),
    # Teeth so far apart that the arcs of gears no longer decide how closely a force is known.
    "wide": lambda: change_meshes(load_arm("probe"), lambda mesh: mesh.model_copy(update=WIDE)),
    "apart": lambda: load_arm("planets-apart"),
    "like": lambda: direct_arm(0.5),
    "unlike": lambda: direct_arm(12.0),
}


WIDE = {"backlash_m": 2e-2}


class Bench(NamedTuple):
    """Comparisons of two models by quantity and whether it is of one; right answers to all."""

    arm: Arm
    comparisons: dict[tuple[str, str], Comparison]
    outcomes: dict[Any, Any]

    def finding(self, name: tuple[str, str], changed: Mapping[Any, Any]) -> Finding:
        """The finding with some answers changed."""
        return self.comparisons[name].finding(Results({**self.outcomes, **changed}))

    def key(self, model: str, quantity: str) -> Any:
        """The key of a model's answers."""
        return next(key for key in self.outcomes if (key.model, key.quantity) == (model, quantity))

    def answers(self, model: str, quantity: str) -> np.ndarray:
        """A model's right answers, to be changed."""
        return np.array(self.outcomes[self.key(model, quantity)])


def bench(name: str) -> Bench:
    """The comparisons of states of an arm by two models, planned anew."""
    arm, both = ARMS[name](), {LEFT[name], RIGHT[name]}
    planned = [
        each
        for each in plan_states(arm, STATES, SEED, groups=("geared", "rigid"))
        if {each.about.key.left, each.about.key.right or each.about.key.left} <= both
        and each.about.key.family in ("states", "invariants", "arm-data")
    ]
    comparisons = {
        (each.about.key.quantity, each.about.key.left * (not each.about.key.right)): each
        for each in planned
    }
    return Bench(arm, comparisons, right_answers(tuple(collect_tasks(planned))))


@lru_cache
def right_answers(tasks: tuple[ModelTask, ...]) -> dict[Any, Any]:
    """The outcomes of the tasks."""
    return {task.key: task.perform() for task in tasks}


def states_of(made: Bench, name: str, *, corners: bool = False) -> States:
    """The random states, or the corners of the mesh laws."""
    case = Case(made.arm, load_scenario("pd"), usual_switches(made.arm))
    setting = arms.sample_model("", LEFT[name], case, STATES, SEED).setting
    if corners:
        return sample_corner_states(setting.layout, made.arm, case.switches, SEED)
    return setting.states


@lru_cache
def conditioning(name: str) -> float:
    """Arcs of gears, and what 3 of 50 roundings leave of places at the arm's reach, over play."""
    arm = ARMS[name]()
    arcs = [j.module_m * j.ring_teeth / 2 for j in arm.joints if j.planet_count]
    reach = sum(link.length_m for link in arm.links)
    return (max(arcs) + 0.06 * reach) / play_of(arm) if arcs else 1.0


def play_of(arm: Arm) -> float:
    """How far random states have their teeth from the middle at most [m]."""
    meshes = [mesh for _, mesh in meshes_of(arm)]
    return max(3 * max(m.backlash_m for m in meshes), 6e-5) + max(
        abs(m.static_error_m) for m in meshes
    )


def meshes_of(arm: Arm) -> list[tuple[tuple[int, str, int], PlanetMesh]]:
    """The meshes of every planet of every joint, counted from 0, by joint, name and planet."""
    return [
        ((number, name, planet), side.planet_mesh(planet))
        for number, joint in enumerate(arm.joints)
        if joint.planet_count
        for planet in range(joint.planet_count)
        for name, side in (("x_sp", joint.sun_mesh), ("x_pr", joint.ring_mesh))
    ]


@lru_cache
def scale(name: str, quantity: str) -> tuple[np.ndarray, float]:
    """Sizes of a quantity at the spot, (n,), of M (n, n); what part of them is allowed.

    From the left model's M, not from the arm's data.
    """
    made, model = bench(name), LEFT[name]
    mass, v = made.answers(model, "mass_matrix")[SPOT], states_of(made, name).v[SPOT]
    root, angular = np.sqrt(np.diag(mass)), layout_of(made, name).angular
    if quantity == "mass_matrix":
        return np.outer(root, root), OF_M
    bias = root * math.sqrt(v @ mass @ v) * np.abs(v[angular]).sum()
    if quantity == "bias":
        return bias, SHARPEST
    sharpest = SHARPEST * conditioning(name)
    if quantity != "acceleration":
        return force_scale(name, corners=quantity == "corner_force"), sharpest
    a = np.abs(made.answers(model, "acceleration")[SPOT])
    solved = np.abs(mass) @ a / conditioning(name)
    return np.abs(np.linalg.inv(mass)) @ (force_scale(name) + bias + solved), sharpest


def layout_of(made: Bench, name: str) -> Layout:
    """The coordinates of the models."""
    return registry.MODELS[LEFT[name]].layout(made.arm, usual_switches(made.arm))


def force_scale(name: str, *, corners: bool = False) -> np.ndarray:
    """Sizes of the generalized force at the spot, (n,): what acts there at most."""
    made = bench(name)
    arm, layout = made.arm, layout_of(made, name)
    _, q, v = (each[SPOT] for each in states_of(made, name, corners=corners))
    drive, pull = make_unequal_gains_scenario(arm).drive, math.hypot(*arm.gravity_m_per_s2)
    across = arm.model_copy(update={"gravity_m_per_s2": (0.0, pull)})
    still = ConstantDrive(kind="constant", torque_N_m=0.0)
    rest = load_scenario("pd").model_copy(update={"drive": still})
    lying = registry.build("pinocchio:coupled", across, rest)
    zero = np.zeros(len(arm.joints))
    size, weights = np.zeros(len(layout)), np.abs(lying.generalized_force(0.0, zero, zero))
    places = {each.name: place for place, each in enumerate(layout.coordinates)}
    for k, joint in enumerate(arm.joints):
        place = places[f"theta_{k + 1}"]
        P, D = drive.proportional_N_m_per_rad[k], drive.derivative_N_m_s_per_rad[k]
        torque = 2 * max(abs(P * drive.target_rad[k]), abs(P * q[place] + D * v[place]))
        torque += weights[k] + abs(joint.friction_N_m_s_per_rad * v[place])
        size[place] += torque
        if joint.planet_count and layout.mesh_joints:
            lever = joint.module_m * math.cos(math.radians(joint.pressure_angle_deg)) / 2
            pressed = torque / (lever * (joint.sun_teeth + joint.ring_teeth))
            for advance in ("x_s",) if layout.free else ("x_sp", "x_pr"):
                size[places[f"{advance}{k + 1}"]] += pressed
    for (k, mesh, planet), data in meshes_of(arm) if layout.mesh_joints else ():
        force = scales.stiffness_bound(data.stiffness) * play_of(arm)
        force += 0.1 * scales.mesh_damping(arm.joints[k], mesh, planet)
        size[layout.angular] += force * play_of(arm)
        for moved in (("x_s", "x_pr") if mesh == "x_sp" else ("x_pr",)) if layout.free else (mesh,):
            which = f"_{planet + 1}" if layout.free and moved == "x_pr" else ""
            size[places[f"{moved}{k + 1}{which}"]] += force
    return size


def wrong_states(name: str) -> Iterator[str]:
    """Of pairs at states: every component of every quantity."""
    for quantity in (*STATE_ABILITIES, *(["corner_force"] if name in GEARED else [])):
        yield from _wrong_components(name, (quantity, ""), *scale(name, quantity))


def wrong_data_checks(name: str) -> Iterator[str]:
    """Of a model beside the arm's data: its force, and its M."""
    for quantity in ("generalized_force", "mass_matrix"):
        yield from _wrong_components(name, (quantity, RIGHT[name]), *scale(name, quantity))


def _wrong_components(
    name: str, comparison: tuple[str, str], sizes: np.ndarray, limit: float
) -> Iterator[str]:
    made, quantity = bench(name), comparison[0]
    right = made.answers(LEFT[name], quantity)
    for place in np.ndindex(sizes.shape):
        for part in (WELL_ABOVE, WELL_BELOW):
            answers = made.answers(RIGHT[name], quantity)
            answers[(SPOT, *place)] = right[(SPOT, *place)] + part * limit * sizes[place]
            changed = {made.key(RIGHT[name], quantity): answers}
            found = made.finding(comparison, changed)
            yield from misjudged(f"{comparison} {place}", found, part, limit, closely=0.15)


def misjudged(
    name: str,
    found: Finding,
    part: float,
    tolerance: float,
    within: str = "agree",
    closely: float = 1e-2,
) -> Iterator[str]:
    """A line if a finding is not of so many tolerances, or not judged by that."""
    if found.verdict != ("differ" if part > 1 else within):
        yield f"{name} by {part}: {found.verdict}, {found.measured} of {found.tolerance}"
    elif found.measured is None or found.tolerance is None:
        yield f"{name} has no numbers"
    elif not math.isclose(found.tolerance, tolerance, rel_tol=1e-6):
        yield f"{name}: tolerance {found.tolerance}, must be {tolerance}"
    elif not math.isclose(found.measured, part * tolerance, rel_tol=closely):
        yield f"{name}: measured {found.measured}, must be {part * tolerance}"


def wrong_self_checks(name: str) -> Iterator[str]:
    """Of what a model owes to itself: symmetry, an M that is definite, a bias that follows."""
    made, model = bench(name), RIGHT[name]
    mass, key = made.answers(model, "mass_matrix"), made.key(model, "mass_matrix")
    for i, j in ((0, 1), (1, 2)):
        size = math.sqrt(mass[SPOT, i, i] * mass[SPOT, j, j])
        for part in (ABOVE, BELOW):
            wrong = mass.copy()
            wrong[SPOT, i, j] = wrong[SPOT, j, i] + part * 1e-12 * size
            found = made.finding(("inertia", model), {key: wrong})
            yield from misjudged("symmetry", found, part, 1e-12)
        for beyond, verdict in ((1e-9, "failed"), (-1e-9, "agree")):
            wrong = mass.copy()
            wrong[SPOT] = np.diag(np.diag(mass[SPOT]))
            wrong[SPOT, i, j] = wrong[SPOT, j, i] = (1 + beyond) * size
            found = made.finding(("inertia", model), {key: wrong})
            if found.verdict != verdict:
                yield f"M by {beyond} beyond definite: {found.verdict}"
    follows = made.key(model, "christoffel_force")
    v = np.abs(states_of(made, name).v[SPOT])
    for row, size in enumerate(scale(name, "mass_matrix")[0] @ v * v.sum()):
        for part in (ABOVE, BELOW):
            answers = made.answers(model, "christoffel_force")
            right = made.answers(model, "bias")[SPOT, row]
            answers[SPOT, row] = right + part * FOLLOWS * size
            found = made.finding(("bias-from-inertia", model), {follows: answers})
            yield from misjudged(f"bias[{row}]", found, part, FOLLOWS)
    claimed = np.array(sorted({*made.outcomes[made.key(model, "abilities")]}))
    answers = made.key(model, "abilities")
    for place in range(claimed.size):
        lost = np.delete(claimed, place)
        found = made.finding(("abilities", model), {answers: lost})
        promised = claimed[place] in registry.MODELS[model].promises
        if found.verdict != ("failed" if promised else "agree"):
            yield f"abilities without {claimed[place]}: {found.verdict}"


def wrong_balances() -> Iterator[str]:
    """Of power and momentum by their terms, of joints that stay closed, of energy and its work."""
    sizes = np.array([3.0, 40.0, 7.0, 1.0])
    limit = 1e-10 * math.sqrt((sizes**2).mean())
    for part in (ABOVE, BELOW):
        for sign in (1, -1):
            gaps = np.array([0.0, 0.0, sign * part * limit, 0.0])
            found = invariants.check_balance(SUBJECT, gaps, sizes)
            yield from misjudged("balance", found, part, limit)
        found = invariants.check_constraints(SUBJECT, np.array([1e-15, part * 1e-12, 0.0]), None)
        yield from misjudged("closure", found, part, 1e-12)
        for place in (1, -1):
            work, turned = np.array([0.0, 3.0, -2.0, 1.0]), np.array([0.0, 3.0, 8.0, 11.0])
            kinetic = 5.0 + work
            kinetic[place] += part * 1e-9 * turned[-1]
            names = {"kinetic_energy": kinetic, "work": work, "work_turned_over": turned}
            run = xr.Dataset({name: ("time", values) for name, values in names.items()})
            found = energy.check_energy_over_run(SUBJECT, run)
            yield from misjudged(f"work at {place}", found, part, 1e-9 * 11.0)
        yield from _wrong_conservation(part)


def _wrong_conservation(part: float) -> Iterator[str]:
    """A motion of direct joints whose kinetic energy is what torques and weight have done."""
    arm, torques = ARMS["like"](), np.array([30.0, -20.0, 10.0])
    phases = np.outer(np.linspace(0.1, 4, 9), [1.0, 1.7, 0.6]) + np.array([0.1, 0.5, 0.9])
    theta = 0.3 * np.sin(phases)
    heading = np.exp(1j * np.cumsum(theta, axis=1))
    ends = np.cumsum(heading * [link.length_m for link in arm.links], axis=1)
    begins = np.hstack([np.zeros((len(theta), 1)), ends[:, :-1]])
    middles = begins + heading * [link.com_m for link in arm.links]
    masses = [link.mass for link in arm.links]
    motors = [joint.motor_mass_kg for joint in arm.joints]
    pull = complex(*arm.gravity_m_per_s2)
    moments = middles @ masses + begins @ motors + arm.payload_mass_kg * ends[:, -1]
    weight, work = -(np.conj(pull) * moments).real, (theta - theta[0]) @ torques
    kinetic = 2.0 + work - (weight - weight[0])
    turned = sum(np.abs(np.diff(each)).sum() for each in (kinetic, weight, work))
    for place in (4, -1):
        wrong = kinetic.copy()
        wrong[place] += part * 1e-9 * turned
        still = ("time", "joint", "planet"), np.zeros((*theta.shape, 1))
        run = xr.Dataset(
            {"kinetic_energy": ("time", wrong), "theta": (("time", "joint"), theta)}
            | {"x_sp": still, "x_pr": still}
        )
        drive = ConstantDrive(kind="constant", torque_N_m=tuple(torques))
        scenario = load_scenario("constant-torque").model_copy(update={"drive": drive})
        found = energy.check_energy_conservation(SUBJECT, run, Case(arm, scenario, switches()))
        yield from misjudged(f"energy at {place}", found, part, 1e-9 * turned)


def wrong_modes() -> Iterator[str]:
    """Of modes, poles, and the step that is stable by them."""
    few, many = np.array([100.0, 200.0, 350.0]), np.array([100.0, 150.0, 200.0, 350.0])
    for part in (ABOVE, BELOW):
        for place in range(3):
            other = few.copy()
            other[place] *= 1 + part * 1e-6
            found = modes.check_modes(SUBJECT, few, other[::-1])
            yield from misjudged(f"mode {place}", found, part, 1e-6)
            found = modes.check_modes(SUBJECT, other, many)
            yield from misjudged(f"mode {place} of more", found, part, 1e-6)
        yield from _wrong_poles(part)
        # Runge and Kutta's method bears h w up to the root of 8 of a vibration at w.
        stable = math.sqrt(8) / FAST
        for step in (1.5 * part * stable, stable / (1.5 * part)):
            found = modes.check_step_limit(SUBJECT, np.array(step), np.eye(2), springs(0.0))
            yield from misjudged(f"stable step {step}", found, part, 1.5)
    same = modes.check_modes(SUBJECT, np.array([100.0, 100.00001]), np.array([100.0, 200.0]))
    if same.verdict != "differ":
        yield "two modes of one side are the same one of the other"


SLOW, FAST = 700.0, 3000.0  # [rad/s]


def springs(softer: float, slow: float = SLOW) -> np.ndarray:
    """Slopes of the forces of two masses of 1 kg on springs, one of them softer, twice."""
    stiff = np.diag([slow**2, FAST**2])
    again = stiff * (1 - softer) ** 2
    return np.array([np.hstack([-each, 0 * each]) for each in (stiff, again)])


def _wrong_poles(part: float) -> Iterator[str]:
    for slow in (0.3, SLOW):  # slower than a thousandth of the fastest, a pole has the size of that
        right = 1j * np.array([slow, -slow, FAST, -FAST])
        for place in range(4):
            wrong = right.copy()
            wrong[place] += part * 1e-7j * max(right[place].imag, FAST / 1000, key=abs)
            found = modes.check_poles(SUBJECT, wrong, np.eye(2), springs(0.0, slow))
            yield from misjudged(f"pole {place}", found, part, 1e-7)
    wrong = right.copy()
    wrong[0] *= 1 + part * (1e-7 + 3 * 1e-6)
    found = modes.check_poles(SUBJECT, wrong, np.eye(2), springs(1e-6))
    yield from misjudged("pole of rounded slopes", found, part, 1e-7 + 3 * 1e-6)
    for model, what in ((right[[0, 1, 0, 1]], "lost"), (np.append(right, 9e3j), "too many")):
        if modes.check_poles(SUBJECT, model, np.eye(2), springs(0.0)).verdict != "differ":
            yield f"a pole that is {what}"
    softer = (1e-5 - 1e-7) / 3 * part
    found = modes.check_poles(SUBJECT, right, np.eye(2), springs(softer))
    if found.verdict != ("unresolved" if part > 1 else "agree"):
        yield f"poles known to {softer}: {found.verdict}"


TIMES, STEP_S = 6, 1e-5


def made_run(**changes: float) -> xr.Dataset:
    """A run of 500 steps; its angles and displacements are changed at one place if that is named.

    changes: by how much, of theta_last, theta_first, theta_middle, x_sp_last and so on.
    """
    time = np.linspace(0, 500 * STEP_S, TIMES)
    theta = np.array([0.3, -0.7]) * np.cos(200 * time)[:, None]
    x_sp = 1e-5 * np.sin(300 * time)[:, None, None] * np.array([1.0, 0.4])[:, None] * np.ones(3)
    values = {"theta": theta, "x_sp": x_sp}
    for name, by in changes.items():
        quantity, _, place = name.rpartition("_")
        at = {"first": (0, 1), "middle": (3, 0), "before": (-2, 0), "last": (-1, 1)}[place]
        values[quantity][(*at, *[2] * (values[quantity].ndim - 2))] += by
    dims = ("time", "joint", "planet")
    labels = {"time": time, "joint": [1, 2], "planet": [1, 2, 3]}
    data = {name: (dims[: each.ndim], each) for name, each in values.items()}
    return xr.Dataset(data, labels, {"step_s": STEP_S, "model": "one"})


def subject(quantity: str) -> Subject:
    """What a comparison of runs is about."""
    return Subject(ComparisonKey("family", "case", quantity, "one", "other"), "1", "largest")


def wrong_runs() -> Iterator[str]:
    """Of runs in the same steps, at one instant, by refinement, of orders and of steps."""
    for quantity in ("theta", "x_sp"):
        size, grown = float(np.abs(made_run()[quantity]).max()), 2.0**-41
        pair = trajectories.Pair(made_run(), made_run(**{f"{quantity}_middle": grown}))
        limit = 10 * math.sqrt(500) * (grown + EPS * size)
        wide, narrow = (ReasonedLimit(part * limit, "so") for part in (ABOVE, BELOW))
        for part in (ABOVE, BELOW):
            for place in ("first", "middle", "before", "last"):
                other = made_run(**{f"{quantity}_{place}": part * limit})
                for within, widest in (("agree", wide), ("unresolved", narrow)):
                    given = subject(quantity), made_run(), other, pair, widest
                    found = trajectories.check_same_step(*given)
                    yield from misjudged(f"{quantity}, {place}", found, part, limit, within)
                found = trajectories.check_same_step(*given[:4], wide, 500 * STEP_S)
                seen = part if place in ("before", "last") else 0.0
                if found.verdict != ("differ" if seen > 1 else "agree"):
                    yield f"{quantity} at the end, by {part} at {place}: {found.verdict}"
            yield from _wrong_refinement(quantity, part, size)
    for order, sign, part in ((4, 1, ABOVE), (4, -1, ABOVE), (2, 1, BELOW), (2, -1, BELOW)):
        shrink = 2.0 ** (order + sign * 0.2 * part)
        runs = [made_run(x_sp_last=by) for by in (1e-6 + 1e-6 / shrink, 1e-6 / shrink, 0.0)]
        found = convergence.check_formal_order(subject("x_sp"), *runs, formal=order)
        yield from misjudged(f"order {order}", found, part, 0.2)
    for part in (ABOVE, BELOW):
        found = records.check_stable_step(SUBJECT, np.array(1e-5), part * 1e-5)
        yield from misjudged("stable step", found, part, 1.0)
    if records.check_stable_step(SUBJECT, np.array(np.inf), 1.0).verdict != "agree":
        yield "a step of a model that bears any"


def _wrong_refinement(quantity: str, part: float, size: float) -> Iterator[str]:
    """Of runs whose coarser ones are 1, 4 and 2 units off, on the left also a further pair.

    Those on the left take 100 times as many steps.
    """
    unit, last = 2.0**-43, f"{quantity}_last"
    limit = 3 * unit * math.hypot(4, 2) + EPS * size * math.sqrt(50_000)
    off = part * limit
    right = made_run(), made_run(), made_run(**{last: 2 * unit})
    run = made_run(**{last: off})
    own = run, made_run(**{last: off + unit})
    left = (run, *own, made_run(), made_run(**{last: 4 * unit}))
    left = tuple(run.assign_attrs(step_s=STEP_S / 100) for run in left)
    # What is judged is the uncertainty alone, without the rounding.
    wide, narrow = (ReasonedLimit(by * 3 * unit * math.hypot(4, 2), "so") for by in (ABOVE, BELOW))
    for within, widest in (("agree", wide), ("unresolved", narrow)):
        for sides in ((left, right), (right, left)):
            found = trajectories.check_refined_runs(subject(quantity), *sides, widest)
            yield from misjudged(f"{quantity}, refined", found, part, limit, within)


def wrong_acceptance() -> Iterator[str]:
    """Of what an uncertainty must stay below, on an arm of unlike gears with no weight."""
    arm = load_arm("probe").model_copy(update={"gravity_m_per_s2": (0.0, 0.0)})
    play = [4e-5, 9e-5]
    arm = arm.model_copy(
        update={
            "joints": tuple(
                change_meshes(
                    arm, lambda mesh, own=own: mesh.model_copy(update={"backlash_m": own})
                ).joints[place]
                for place, own in enumerate(play)
            )
        }
    )
    pitch = [j.module_m * math.cos(math.radians(j.pressure_angle_deg)) / 2 for j in arm.joints]
    around = [p * (j.sun_teeth + j.planet_teeth) for p, j in zip(pitch, arm.joints, strict=True)]
    lost = [2 * each / radius for each, radius in zip(play, around, strict=True)]
    parts = {"x_sp": (0.01, min(play), "a hundredth of a mesh's travel, 4e-05 m")}
    parts["x_pr"] = parts["x_sp"]
    words = f"a thousandth of a joint's lost motion, {min(lost):.2g} rad"
    parts["theta"] = 1e-3, min(lost), words
    parts["F_sp"] = 0.01, 5.5678, "a hundredth of its largest value, 5.57"
    weak = load_scenario("constant-torque").model_copy(update={"drive": drive_of(1.0, 1.0)})
    for quantity, (part, of, words) in parts.items():
        said, basis = scales.acceptance_limit(quantity, arm, weak, 5.5678)
        if not math.isclose(said, part * of, rel_tol=1e-9) or basis != words:
            yield f"{quantity} may be known to {said}, {basis}; must be {part * of}, {words}"
    yield from _wrong_bending(arm, pitch)
    weak = weak.model_copy(update={"drive": drive_of(1.0, 1.0, 1.0)})
    if scales.acceptance_limit("theta", ARMS["like"](), weak, 5.5) != (
        1e-6,
        "a millionth of a radian",
    ):
        yield "angles of an arm without gears"


def drive_of(*torques: float) -> ConstantDrive:
    """Constant torques [N m]."""
    return ConstantDrive(kind="constant", torque_N_m=torques)


# Of the laws of tests.mixed_arms the largest stiffness; and the mean, by hand where it has a
# closed form.
BOUNDS: dict[str, tuple[float, float | None]] = {
    "sine": (9.5e7, 8e7),
    "fourier": (9e7 + 1e7 + 3e6 + 2e6 + 6e6, 9e7),
    "square": (1.08e8, 0.6 * 1e8 + 0.4 * 6e7),
    "table": (1e8, None),
}
SOFTER = SineStiffness(law="sine", mean_N_per_m=3e7, amplitude_N_per_m=1e7)


def _wrong_bending(arm: Arm, pitch: Sequence[float]) -> Iterator[str]:
    """Under torques that bend teeth by more than their play: of each stiffness law's bound."""
    strong = load_scenario("constant-torque").model_copy(update={"drive": drive_of(2e5, 9e5)})
    for name, (bound, mean) in BOUNDS.items():
        stiff = TypeAdapter(StiffnessLaw).validate_python(LAWS[name], strict=False)
        if mean is not None and not math.isclose(scales.mean_stiffness(stiff), mean, rel_tol=1e-9):
            yield f"{name}: mean {scales.mean_stiffness(stiff)}, must be {mean}"
        # The suns' meshes have the law, the rings' are softer.
        own = change_meshes(arm, lambda mesh: mesh.model_copy(update={"stiffness": SOFTER}))
        joints = tuple(
            joint.model_copy(
                update={"sun_mesh": joint.sun_mesh.model_copy(update={"stiffness": stiff})}
            )
            for joint in own.joints
        )
        own = own.model_copy(update={"joints": joints})
        bent = [
            torque / (p * (j.sun_teeth + j.ring_teeth)) / (j.planet_count * bound)
            for torque, p, j in zip((2e5, 9e5), pitch, own.joints, strict=True)
        ]
        said = scales.acceptance_limit("x_sp", own, strong, 1.0).value
        if not math.isclose(said, 0.01 * min(bent), rel_tol=1e-9):
            yield f"{name}: displacements may be known to {said}, must be {0.01 * min(bent)}"


def wrong_records() -> Iterator[str]:
    """Of a run that belies its states, or was recorded at other times."""
    arm, model = ARMS["like"](), "analytic:coupled"
    scenario = load_scenario("constant-torque").model_copy(
        update={
            "drive": drive_of(30.0, -20.0, 10.0),
            "duration_s": 2e-3,
            "step_s": 1e-5,
            "record_every": 10,
        }
    )
    case = Case(arm, scenario, switches())
    made = registry.build(model, *case)
    run = made.simulate()
    for name, constrained in product(("theta_ddot", "torque", "kinetic_energy"), (False, True)):
        values = run[name].values
        for part, place in product((ABOVE, BELOW, np.nan), (0, -1)):
            wrong = run.copy(deep=True)
            by = part * (1e-8 if constrained else 1e-9) * float(np.abs(values).max())
            wrong[name].values[(place, *[1] * (values.ndim - 1))] -= by
            if (not part <= 1) != _is_refused(
                partial(records.require_consistent, wrong, made, constrained=constrained)
            ):
                yield f"{name} of record {place} by {part}"
    yield from _unlike_planets()
    for part in (ABOVE, BELOW):
        times = run["time"].values.copy()
        times[3] += part * 1e-10
        moved = run.assign_coords(time=times)
        if (part > 1) != _is_refused(
            lambda moved=moved: records.require_complete(moved, model, case, meshing=False)
        ):
            yield f"a time by {part}"


def _unlike_planets() -> Iterator[str]:
    """Of planets that count as one, and of which one is elsewhere than the others, or faster."""
    changes = {"duration_s": 1e-4, "step_s": 1e-6, "record_every": 10}
    scenario = load_scenario("constant-torque").model_copy(update=changes)
    for length_m, constrained in ((1.0, False), (1000.0, True)):
        arm = ARMS["geared"]()
        links = tuple(link.model_copy(update={"length_m": length_m}) for link in arm.links)
        arm = arm.model_copy(update={"links": links})
        made = registry.build("analytic:physical", arm, scenario, usual_switches(arm))
        run = made.simulate()
        radius = max(j.module_m * j.ring_teeth / 2 for j in arm.joints if j.planet_count)
        angle, rate = (float(np.abs(run[name]).max()) for name in ("theta", "theta_dot"))
        placed = 3 * EPS * length_m * len(links) * constrained
        limits = {
            "x_pr": max(1000 * EPS * radius * (1 + angle), placed),
            "x_sp_dot": max(1e-9 * float(np.nanmax(np.abs(run["x_sp_dot"]))), placed * rate),
        }
        for (name, limit), part in product(limits.items(), (ABOVE, BELOW)):
            wrong = run.copy(deep=True)
            wrong[name].values[:, 0, 1] += part * limit
            if (part > 1) != _is_refused(
                partial(records.require_consistent, wrong, made, constrained=constrained)
            ):
                yield f"{name} of a planet by {part}, links of {length_m} m"


def _is_refused(asked: Callable[[], None]) -> bool:
    try:
        asked()
    except (records.IncompleteRun, records.InconsistentRun):
        return True
    return False


def wrong_plan() -> Iterator[str]:
    """Of what is compared with what: no pair of models, no joint and no quantity is left out."""
    arm = load_arm("paper-labelled")
    laws = usual_switches(arm)
    case = Case(arm, load_scenario("pd"), laws)
    planned = [
        *plan_states(arm, 1, SEED),
        *arms.plan_experiment_comparisons(plan.Experiment("pd", case)),
    ]
    keys = [each.about.key for each in planned]
    answers = {(k.family, k.case, k.quantity, frozenset((k.left, k.right)), k.joint) for k in keys}
    where = {f"{arm.name}/geared": registry.find_covering_models("geared", arm, laws)}
    where |= {
        f"{arm.name}/{level}": registry.find_level_models(level) for level in registry.RIGID_LEVELS
    }
    right: set[tuple[str, str, str, frozenset[str], int | None]] = set()
    for name, models in where.items():
        pairs = [frozenset((one, other)) for one in models for other in models if one < other]
        corners = ("corner_force",) if name.endswith("geared") else ()
        right |= {
            ("states", name, q, pair, None) for q in (*STATE_ABILITIES, *corners) for pair in pairs
        }
    first = registry.reference_model()
    for other in registry.find_same_integrator_models():
        pair = frozenset((first, other))
        for quantity in trajectories.SAME_STEP if other != first else ():
            right |= {(each, "pd", quantity, pair, None) for each in ("same-step", "at-2-s")}
    for level in registry.RIGID_LEVELS:
        one, *others = plan.sort_engines(level)
        right |= {("refined", "pd", "theta", frozenset((one, each)), None) for each in others}
        pair = frozenset((one, first))
        right |= {("deviation", "pd", q, pair, j) for q in ("theta", "theta_dot") for j in (1, 2)}
        right.add(("deviation", "pd", "tip", pair, None))
    yield from (f"not planned: {each}" for each in sorted(right - answers, key=str))


def wrong_experiments() -> Iterator[str]:
    """Of steps that are stable, and of starts one rounding away."""
    arm = load_arm("probe")
    scenario = load_scenario("pd").model_copy(update={"record_every": 5})
    case = Case(arm, scenario, usual_switches(arm))
    for limit in (8.01 * scenario.step_s, 7.99 * scenario.step_s, 1.3 * scenario.step_s):
        found = plan.set_stable_step(plan.Experiment("pd", case), limit).case.scenario
        # Halved as often as an eighth of the limit asks for, and as twice the step meets records.
        times = max(0, math.ceil(math.log2(8 * scenario.step_s / limit)))
        while (scenario.stride << times) % 2:
            times += 1
        if found.step_s != scenario.step_s / 2**times:
            yield f"step {found.step_s} where {limit} is stable"
        if found.stride * found.step_s != scenario.stride * scenario.step_s:
            yield "records at other times"
    arcs = max(joint.module_m * joint.ring_teeth / 2 for joint in arm.joints)
    moved = plan.perturb_start_by_one_ulp(case).scenario.start
    for name, by in (
        ("theta_rad", EPS),
        ("sun_planet_offset_m", EPS * arcs),
        ("planet_ring_offset_m", EPS * arcs),
    ):
        said = np.subtract(getattr(moved, name), expand_to_joints(getattr(scenario.start, name), 2))
        if not np.allclose(said, by, rtol=1e-12, atol=0):
            yield f"{name} starts {said} away"


def wrong_stage_modes() -> Iterator[str]:
    """Of first principles' own modes, a carrier locked: energies of unlike planets, assembled."""
    joint = load_arm("planets-apart").joints[0]
    count, means = joint.planet_count, {}
    for side, more in (("sun", 0.1), ("ring", -0.07)):
        means[side] = [8e7 * (1 + more * n) for n in range(count)]
        law = SineStiffness(law="sine", mean_N_per_m=8e7, amplitude_N_per_m=1e6)
        laws = tuple(law.model_copy(update={"mean_N_per_m": mean}) for mean in means[side])
        mesh = getattr(joint, f"{side}_mesh").model_copy(update={"stiffness": laws})
        joint = joint.model_copy(update={f"{side}_mesh": mesh})
    pitch = joint.module_m / 2 * math.cos(math.radians(joint.pressure_angle_deg))

    def mass(name: str) -> float:
        given = getattr(joint, f"{name}_equivalent_mass_kg")
        radius = pitch * getattr(joint, f"{name}_teeth")
        return float(given or getattr(joint, f"{name}_inertia_kg_m2") / radius**2)

    stiff = np.zeros((count + 1, count + 1))
    for n in range(count):
        for side, row in (("sun", [1.0, -1.0]), ("ring", [0.0, 1.0])):
            across = np.zeros(count + 1)
            across[[0, n + 1]] = row
            stiff += means[side][n] * np.outer(across, across)
    masses = np.array([mass("sun"), *[mass("planet")] * count])
    right = np.sqrt(np.sort(np.linalg.eigvals(stiff / masses[:, None]).real)) / (2 * np.pi)
    if not np.allclose(modes.stage_modes(joint), right, rtol=1e-9):
        yield f"modes {modes.stage_modes(joint)}, must be {right}"


# What a cross-check judges, by the arm where there are several.
GUARDS: dict[str, Callable[[], Iterable[str]]] = {
    **{
        f"{what} {name}": lambda name=name, wrong=wrong: wrong(name)
        for what, wrong in (
            ("states", wrong_states),
            ("self", wrong_self_checks),
            ("data", wrong_data_checks),
        )
        for name in ARMS
    },
    "balances": wrong_balances,
    "modes": wrong_modes,
    "runs": wrong_runs,
    "acceptance": wrong_acceptance,
    "records": wrong_records,
    "plan": wrong_plan,
    "experiments": wrong_experiments,
    "stage modes": wrong_stage_modes,
}
