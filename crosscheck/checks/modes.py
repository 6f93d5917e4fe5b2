"""Modes of the teeth, and poles of an arm with its teeth in contact, against other models."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations

import numpy as np

from crosscheck.checks.answers import BadAnswer, Setting, ask, require_numbers
from crosscheck.checks.sampled import SampledArm, Subjects, group_models
from crosscheck.checks.scales import equivalent_mass, geared_joints, mean_stiffness, stiffness_bound
from crosscheck.findings import ComparisonKey, Finding, Subject, make_check
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.meshes import change_meshes
from crosscheck.models.arm.stiffness import SineStiffness, StiffnessLaw
from crosscheck.models.experiment.scenario import expand_to_joints, make_bent_start
from crosscheck.models.interface import Model
from crosscheck.models.loading import Case, make_rest_scenario
from crosscheck.planning.comparison import Comparison, MissingResult, ModelTask, make_comparison

TOLERANCE = 1e-6
BASIS = "1e-6: engines linearise by finite differences of forces of 1e4 N at 1e-7 relative steps"
# A carrier is locked by a link this many times heavier: the modes move by about its inverse.
LOCK = 1e9
POLE_TOLERANCE, SAFETY = 1e-7, 3.0
# Of angles [rad, rad/s] and displacements [m, m/s], of which forces are differenced.
TURN, SHIFT = 1e-4, 1e-6
MEANINGFUL = 1e-5  # least difference that an error in a formula makes
# Of a step by poles: the method's polynomial, how far it may be from zero in units of the fastest
# pole, and how closely it is looked for.
STABILITY = np.array([1 / 24, 1 / 6, 1 / 2, 1.0, 1.0])
REACH, STEPS, OTHER_POSES = 3.0, 2000, 1.5
SLOW = 1e-3  # least size of a pole for relative errors, over the fastest pole
POLE_BASIS = (
    "1e-7: differences over 1e-4 rad leave 2e-9 of a weight's slope, roundings 1e-9 of a mesh's"
)
POLE_METRIC = "largest relative distance of a pole to the nearest of the other model's forces"
MODE_METRIC = "largest relative distance of a mode to the nearest of the other model"
STEP_METRIC = "largest stable step over that of its poles, or the other way round"


def mesh_modes(model: Model, setting: Setting) -> np.ndarray:
    """Frequencies of a model's modes [Hz], ascending. Raises BadAnswer."""
    modes = require_numbers(model.mesh_modes(), "mesh_modes", None)
    if modes.ndim != 1 or (modes <= 0).any() or (np.diff(modes) < 0).any():
        raise BadAnswer("mesh_modes are not positive frequencies in ascending order")
    return modes


def contact_poles(model: Model, setting: Setting) -> np.ndarray:
    """A model's poles [1/s], (2 n,). Raises BadAnswer."""
    poles = model.contact_poles()
    if not isinstance(poles, np.ndarray) or poles.shape != (2 * len(model.layout),):
        raise BadAnswer("contact_poles are not two for every coordinate")
    parts = np.array([poles.real, poles.imag])
    require_numbers(parts, "contact_poles", parts.shape)
    return parts[0] + 1j * parts[1]


def largest_stable_step(model: Model, setting: Setting) -> np.ndarray:
    """A model's largest stable step [s], (). Raises BadAnswer."""
    step = model.largest_stable_step()
    if not isinstance(step, float) or not step > 0:
        raise BadAnswer(f"largest_stable_step is {step!r}, must be a positive number")
    return np.array(step)


def start_pose(setting: Setting) -> np.ndarray:
    """Coordinates of the scenario's angles, the teeth centred, shape (n,)."""
    (arm, scenario, _), layout = setting.case, setting.layout
    pose = np.zeros(len(layout))
    pose[layout.theta] = expand_to_joints(scenario.start.theta_rad, len(arm.joints))
    return pose


def start_mass(model: Model, setting: Setting) -> np.ndarray:
    """M in the start pose (n, n)."""
    pose = start_pose(setting)
    return ask(model, "mass_matrix", (1, pose.size, pose.size), pose[None])[0]


def force_slopes(model: Model, setting: Setting) -> np.ndarray:
    """Slopes of the generalized force by q and v, at rest in the start pose, shape (2, n, 2 n).

    The first are by differences of one size, the second by differences of twice that.
    """
    pose = start_pose(setting)
    once = np.tile(np.where(setting.layout.angular, TURN, SHIFT), 2)
    steps = np.diag(once)
    ways = np.append(pose, 0 * pose) + np.array([[steps, -steps], [2 * steps, -2 * steps]])
    q, v = np.split(ways.reshape(-1, once.size), 2, axis=1)
    forces = ask(model, "generalized_force", q.shape, np.zeros(len(q)), q, v)
    ahead, back = forces.reshape(2, 2, once.size, pose.size).swapaxes(0, 1)
    return (ahead - back).swapaxes(1, 2) / (2 * np.array([once, 2 * once])[:, None])


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of modes and poles with the teeth in contact, and of the step that is stable."""
    geared = [each for each in subjects.arms if each.group in ("geared", "free", "form")]
    for group in group_models(geared):
        where, rest = group[0].where.removesuffix("/geared"), make_rest_scenario()
        case = group[0].setting.case._replace(scenario=rest)
        models = [each for each in group if each.group != "form"]
        yield from plan_poles(where, models)
        able = [each for each in models if "mesh_modes" in each.promises]
        for pair in combinations(able, 2) if geared_joints(case.arm) else ():
            key = ComparisonKey("modes", where, "mesh-mode", pair[0].model, pair[1].model)
            yield _plan_modes(Subject(key, "1", MODE_METRIC), pair, case)
        for number, joint in geared_joints(case.arm):
            locked = case._replace(arm=make_locked_stage(case.arm, number))
            closed = stage_modes(joint, lumped=case.switches.planets == "lumped")
            for each in able:
                if each.covers(locked.arm, case.switches):
                    key = ComparisonKey("modes", where, "locked-stage", each.model, "", number + 1)
                    about = Subject(key, "1", MODE_METRIC, "closed form")
                    yield _plan_modes(about, [each], locked, closed)
        for each in group if geared_joints(case.arm) else ():
            if "simulate" in each.promises and each.order == models[0].order:
                yield _plan_stable_step(where, each)


def _plan_modes(
    about: Subject, models: Sequence[SampledArm], case: Case, *closed: np.ndarray
) -> Comparison:
    """The check of two models' modes, or of one's and those of first principles.

    It raises MissingResult if a model has lost some.
    """

    def judge(about: Subject, *model_modes: np.ndarray) -> Finding:
        for sampled, frequencies in zip(models, model_modes, strict=True):
            single = sampled.free_planets or case.switches.planets == "free"
            planets = [joint.planet_count for joint in case.arm.joints if joint.planet_count]
            expected = sum(1 + (count if single else 1) for count in planets)
            if len(frequencies) != expected:
                lack = f"{len(frequencies)} mesh modes, there must be {expected}"
                raise MissingResult(f"{sampled.model}: {lack}")
        few, many = sorted((*closed, *model_modes), key=len)
        return check_modes(about, few, many)

    return make_comparison(about, [each.ask_once(mesh_modes, case) for each in models], judge)


def make_locked_stage(arm: Arm, number: int) -> Arm:
    """An arm of one geared joint, its link too heavy to move, without weight and friction."""
    free = arm.joints[number].model_copy(update={"friction_N_m_s_per_rad": 0.0})
    link = arm.links[number]
    heavy = "density_kg_per_m3", "mass_kg", "inertia_kg_m2"
    heavier = {name: LOCK * x for name, x in link if name in heavy and x is not None}
    locked = {"joints": (free,), "links": (link.model_copy(update=heavier),)}
    return arm.model_copy(update={**locked, "gravity_m_per_s2": (0.0, 0.0)})


def plan_poles(where: str, models: Sequence[SampledArm]) -> Iterator[Comparison]:
    """Comparisons of the loop's poles with teeth in contact, by which it is called unstable."""
    arm, scenario, laws = models[0].setting.case
    start = make_bent_start(len(arm.joints))
    case = Case(arm, scenario.model_copy(update={"start": start}), laws)
    linear = case._replace(arm=linearize_teeth(arm))
    able = [each for each in models if each.covers(linear.arm, laws)]
    for left in able:
        for right in able if "contact_poles" in left.promises else ():
            if right != left:
                tasks = left.ask_once(contact_poles, case), *_pole_tasks(right, linear)
                key = ComparisonKey("modes", where, "contact-poles", left.model, right.model)
                yield make_comparison(Subject(key, "1", POLE_METRIC), tasks, check_poles)


def _plan_stable_step(where: str, sampled: SampledArm) -> Comparison:
    """A comparison of the largest stable step with a model's own poles, teeth at their stiffest."""
    case = sampled.setting.case
    stiff = case._replace(arm=linearize_teeth(case.arm, stiffness_bound))
    tasks = sampled.ask_once(largest_stable_step), *_pole_tasks(sampled, stiff)
    key = ComparisonKey("modes", where, "stable-step", sampled.model)
    return make_comparison(Subject(key, "1", STEP_METRIC, "its poles"), tasks, check_step_limit)


def _pole_tasks(sampled: SampledArm, case: Case) -> tuple[ModelTask, ModelTask]:
    """Tasks for a model's inertia and slopes of its force at the start, of which poles are made."""
    return sampled.ask_once(start_mass, case), sampled.ask_once(force_slopes, case)


def check_modes(about: Subject, few: np.ndarray, many: np.ndarray) -> Finding:
    """Check that each of some modes [Hz] is one of the others; of as many, each its own."""
    if len(few) == len(many):
        distance = np.abs(np.sort(few) - np.sort(many)) / np.sort(few)
    else:
        distance = np.abs(few[:, None] - many[None, :]).min(axis=1) / few
    measured = float(distance.max())
    note = "modes [Hz]: " + ", ".join(f"{mode:.2f}" for mode in few)
    return make_check(
        about, measured=measured, tolerance=TOLERANCE, basis=BASIS, relative=measured, note=note
    )


def stage_modes(joint: Planetary, *, lumped: bool = False) -> np.ndarray:
    """All modes [Hz] of a stage with its carrier locked, ascending, (N + 1,); 2 if lumped.

    With u = r_s theta_s and w_n = r_p theta_p of planet n they solve
    M_s u'' = -sum of k_sn (u - w_n) and M_p w_n'' = k_sn (u - w_n) - k_rn w_n, also for planets
    that differ. Lumped planets, which are alike, move alike.
    """
    count = joint.planet_count
    roots = np.sqrt([equivalent_mass(joint, "sun"), *[equivalent_mass(joint, "planet")] * count])
    matrix = np.zeros((count + 1, count + 1))
    for n in range(count):
        k_s = mean_stiffness(joint.sun_mesh.planet_mesh(n).stiffness)
        k_r = mean_stiffness(joint.ring_mesh.planet_mesh(n).stiffness)
        matrix[0, 0] += k_s
        matrix[n + 1, n + 1] = k_s + k_r
        matrix[0, n + 1] = matrix[n + 1, 0] = -k_s
    matrix /= np.outer(roots, roots)
    if lumped:
        alike = np.zeros((count + 1, 2))
        alike[0, 0], alike[1:, 1] = 1.0, 1 / np.sqrt(count)
        matrix = alike.T @ matrix @ alike
    return np.sqrt(np.linalg.eigvalsh(matrix)) / (2 * np.pi)


def linearize_teeth(arm: Arm, stiffness: Callable[[StiffnessLaw], float] = mean_stiffness) -> Arm:
    """The arm with teeth that never part, without errors, at a stiffness [N/m] of each law."""

    def linearize_mesh(mesh: Mesh) -> Mesh:
        laws = mesh.stiffness
        constant = (
            tuple(map(make_constant, laws)) if isinstance(laws, tuple) else make_constant(laws)
        )
        clean = {"backlash_m": 0.0, "tooth_error_m": 0.0, "static_error_m": 0.0}
        return mesh.model_copy(update={"stiffness": constant, **clean})

    def make_constant(law: StiffnessLaw) -> SineStiffness:
        mean = stiffness(law)  # of a law within its range it may be beyond that of a mean
        return SineStiffness.model_construct(law="sine", mean_N_per_m=mean, amplitude_N_per_m=0.0)

    return change_meshes(arm, linearize_mesh)


def check_poles(about: Subject, poles: np.ndarray, mass: np.ndarray, slopes: np.ndarray) -> Finding:
    """Check that poles [1/s], (2 n,), are those of M (n, n) and the force's slopes by q and v.

    Each pole is compared with the nearest of the others, both ways. slopes (2, n, 2 n): by
    differences of one size and of twice that; how far this moves the poles is what rounding and
    curvature do.
    """
    expected, again = (_poles(mass, each) for each in slopes)
    measured, moved = (_distance(candidate, expected) for candidate in (poles, again))
    tolerance = POLE_TOLERANCE + SAFETY * moved
    return make_check(
        about,
        measured=measured,
        tolerance=tolerance,
        basis=f"{POLE_BASIS}; and {SAFETY:g} x {moved:.1g}, which twice the differences move them",
        resolved=tolerance <= MEANINGFUL,
        relative=measured,
    )


def check_step_limit(
    about: Subject, limit: np.ndarray, mass: np.ndarray, slopes: np.ndarray
) -> Finding:
    """Check a model's largest stable step [s], (), against that of Runge and Kutta at its poles.

    mass, slopes: of one pose with the teeth at their largest stiffness, as in `check_poles`.
    """
    poles = _poles(mass, slopes[0])
    # The first step at which |1 + z + ... + z^4 / 24| > 1, z = h p, of any mode. The method must
    # follow a growing mode's frequency too, so its growth alone is left out.
    bounded_poles = np.minimum(poles.real, 0.0) + 1j * poles.imag
    steps = np.linspace(0.0, REACH / np.abs(bounded_poles).max(), STEPS)[1:]
    grows = (np.abs(np.polyval(STABILITY, np.outer(steps, bounded_poles))) > 1 + 1e-6).any(axis=1)
    limit_s, expected = float(limit), float(steps[np.argmax(grows)] if grows.any() else steps[-1])
    measured = max(limit_s / expected, expected / limit_s)
    basis = f"factor of {OTHER_POSES:g}: other poses, and a stiffness that overshoots its bounds"
    note = f"largest stable step: {limit_s:.4g} s, from the poles {expected:.4g} s"
    return make_check(about, measured=measured, tolerance=OTHER_POSES, basis=basis, note=note)


def _poles(mass: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    n = len(mass)
    return np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), np.linalg.solve(mass, slopes)]))


def _distance(poles: np.ndarray, expected: np.ndarray) -> float:
    """Largest distance of a pole to the nearest of the others, over its size, both ways."""
    differences = np.abs(poles[:, None] - expected[None, :])
    size = np.maximum(np.abs(expected), SLOW * np.abs(expected).max())
    with np.errstate(divide="ignore", invalid="ignore"):  # a system without a motion has no poles
        relative = differences / size
    return max(float(relative.min(axis=side).max()) for side in (0, 1))
