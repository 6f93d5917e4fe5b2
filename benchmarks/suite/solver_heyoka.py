"""heyoka: Taylor series of the equations, compiled; scalar, in batches, and with contact events.

The equations are built here as heyoka's expressions from the model's own numbers, with the constant
inertia of the gears eliminated beforehand: what is left to compile is as small as it can be.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from benchmarks.suite.refined_solution import contact_sides, solve_refined
from benchmarks.suite.solver import Solver
from crosscheck.analytic.model import AnalyticModel
from crosscheck.models.experiment.drive import PD

MOMENT_S = 1e-6  # after the start
SELECT_TOLERANCE = 1e-9  # of a Taylor step; what errs is the kink that it leaps over


class Equations(NamedTuple):
    """y' (2 n,) as expressions of the variables y, and x - e [m] of every mesh."""

    variables: list[Any]
    rates: list[Any]
    gaps: list[Any]


def build_equations(model: AnalyticModel, by_events: bool) -> Equations:
    """Of an arm of two joints under PD drive, phase by angle, gears by Eq. 8.

    by_events: contact is a parameter of every mesh that events change; else a `select`.
    """
    import heyoka as hy

    n = len(model.layout)
    names = [f"q{i}" for i in range(n)] + [f"v{i}" for i in range(n)]
    variables = list(hy.make_vars(*names))
    q, v = variables[:n], variables[n:]
    forces, gaps = _forces(hy, model, q, v, by_events)
    return Equations(variables, [*v, *_accelerations(hy, model, q, v, forces)], gaps)


def _forces(
    hy: Any, model: AnalyticModel, q: list[Any], v: list[Any], by_events: bool
) -> tuple[list[Any], list[Any]]:
    """Generalized forces (n,), and every mesh's gap."""
    terms, gears, drive = model.terms, model.gears, model.drive
    assert drive.code == PD
    assert not terms.weight.size
    forces = [hy.expression(0.0) for _ in q]
    for joint, place in enumerate(terms.theta):
        target, proportional, derivative = map(float, drive.gains[joint])
        effort = proportional * (target - q[place]) - derivative * v[place]
        for row in np.flatnonzero(terms.drive_map[:, joint]):
            forces[row] += float(terms.drive_map[row, joint]) * effort
        forces[place] -= float(terms.friction[joint]) * v[place]
    gaps = []
    for i, where in enumerate(gears.x_index):
        phase = float(gears.rate[i]) * q[gears.theta[i]] + float(gears.offset[i])
        sine, b = hy.sin(phase), float(gears.b[i])
        gap = q[where] - (float(gears.static_error[i]) + float(gears.E[i]) * sine)
        gaps.append(gap)
        beyond = hy.par[2 * i] * (gap - hy.par[2 * i + 1]) if by_events else _dead_zone(hy, gap, b)
        force = (float(gears.k_m[i]) + float(gears.k_a[i]) * sine) * beyond
        for row in np.flatnonzero(terms.mesh_map[:, i]):
            forces[row] += float(terms.mesh_map[row, i]) * force
        forces[where] -= float(gears.d[i]) * v[where]
    return forces, gaps


def _dead_zone(hy: Any, gap: Any, b: float) -> Any:
    below = hy.select(hy.lte(gap, -b), gap + b, 0.0)
    return hy.select(hy.gt(gap, b), gap - b, below)


def _accelerations(
    hy: Any, model: AnalyticModel, q: list[Any], v: list[Any], forces: list[Any]
) -> list[Any]:
    """q'' (n,), the gears eliminated: M_ll changes with the pose alone."""
    terms, links = model.terms, list(model.layout.theta)
    gears = [i for i in range(len(q)) if i not in links]
    angles = [_sum(float(w) * q[k] for k, w in enumerate(wave) if w) for wave in terms.angle_sums]
    right = [*forces]
    for (row, wave, a, b), coeff in zip(terms.bias, terms.bias_coeff, strict=True):
        right[row] -= float(coeff) * hy.sin(angles[wave]) * v[a] * v[b]
    constant = model.mass_matrix(np.zeros(len(q)))
    inverse = np.linalg.inv(constant[np.ix_(gears, gears)])
    onto = constant[np.ix_(links, gears)] @ inverse
    matrix = [[hy.expression(0.0) for _ in links] for _ in links]
    for (row, col, wave), coeff in zip(terms.mass, terms.mass_coeff, strict=True):
        if row in links and col in links:
            turned = hy.cos(angles[wave]) if terms.angle_sums[wave].any() else 1.0
            matrix[links.index(row)][links.index(col)] += float(coeff) * turned
    lost = onto @ constant[np.ix_(gears, links)]
    reduced = [[matrix[i][j] - float(lost[i, j]) for j in range(2)] for i in range(2)]
    driving = [
        right[link] - _sum(float(onto[i, k]) * right[g] for k, g in enumerate(gears))
        for i, link in enumerate(links)
    ]
    determinant = reduced[0][0] * reduced[1][1] - reduced[0][1] * reduced[1][0]
    of_links = [
        (driving[0] * reduced[1][1] - driving[1] * reduced[0][1]) / determinant,
        (driving[1] * reduced[0][0] - driving[0] * reduced[1][0]) / determinant,
    ]
    accelerations: list[Any] = [None] * len(q)
    for i, link in enumerate(links):
        accelerations[link] = of_links[i]
    back = inverse @ constant[np.ix_(gears, links)]
    for k, g in enumerate(gears):
        pushed = _sum(float(inverse[k, m]) * right[h] for m, h in enumerate(gears) if inverse[k, m])
        accelerations[g] = pushed - _sum(float(back[k, i]) * of_links[i] for i in range(2))
    return accelerations


def _sum(parts: Any) -> Any:
    total: Any = 0.0
    for part in parts:
        total = part + total
    return total


def make_select_solver(model: AnalyticModel, grid: np.ndarray) -> Solver:
    """Scalar; the dead zone is a `select`, which a Taylor step leaps over: the setting is the
    longest step [s] that it may take. Raises ImportError."""
    import heyoka as hy

    expressions, n, start = (
        build_equations(model, False),
        len(model.layout),
        np.concatenate(model.start()),
    )
    system = list(zip(expressions.variables, expressions.rates, strict=True))
    engine = hy.taylor_adaptive(system, start, tol=SELECT_TOLERANCE)

    def run(longest_s: float) -> np.ndarray:
        engine.time, engine.state[:] = 0.0, start
        return engine.propagate_grid(grid, max_delta_t=longest_s)[-1][:, :n]

    return Solver("heyoka, select", "longest step", run)


def make_batch_solver(model: AnalyticModel, grid: np.ndarray) -> Solver:
    """The same of as many equal trajectories at once as the machine has lanes."""
    import heyoka as hy

    expressions, n, start = (
        build_equations(model, False),
        len(model.layout),
        np.concatenate(model.start()),
    )
    lanes = hy.recommended_simd_size()
    starts = np.repeat(start[:, None], lanes, axis=1)
    system = list(zip(expressions.variables, expressions.rates, strict=True))
    engine = hy.taylor_adaptive_batch(system, starts, tol=SELECT_TOLERANCE)

    def run(longest_s: float) -> np.ndarray:
        engine.set_time(0.0)
        engine.state[:] = starts
        grids = np.repeat(grid[:, None], lanes, axis=1)
        result = engine.propagate_grid(grids, max_delta_t=[longest_s] * lanes)
        return (result[-1] if isinstance(result, tuple) else result)[:, :n, 0]

    return Solver(f"heyoka, select, batch of {lanes}", "longest step", run, lanes)


def make_event_solver(model: AnalyticModel, grid: np.ndarray) -> Solver:
    """Scalar; contact changes are terminal events. Raises ImportError.

    At the start the teeth rest at the very edge of contact, where no event can be seen: heyoka
    begins a moment later, with what the refined solver says of that moment.
    """
    import heyoka as hy

    hy.set_logger_level_critical()  # it warns of every event in a long line
    expressions, n = build_equations(model, True), len(model.layout)
    start, contacts = _state_after_start(model)
    made: dict[float, Any] = {}
    events = [
        hy.t_event(gap - side * float(model.gears.b[i]), callback=_Change(i, side, model))
        for i, gap in enumerate(expressions.gaps)
        for side in (1, -1)
    ]

    def run(tolerance: float) -> np.ndarray:
        if tolerance not in made:
            system = list(zip(expressions.variables, expressions.rates, strict=True))
            pars = [0.0] * contacts.size
            made[tolerance] = hy.taylor_adaptive(
                system, start, pars=pars, tol=tolerance, t_events=events
            )
        engine = made[tolerance]
        engine.time, engine.state[:], engine.pars[:] = MOMENT_S, start, contacts
        engine.reset_cooldowns()
        later = engine.propagate_grid(np.concatenate([[MOMENT_S], grid[1:]]))[-1][1:, :n]
        return np.vstack([model.start()[0], later])

    return Solver("heyoka, contact events", "tol", run)


def _state_after_start(model: AnalyticModel) -> tuple[np.ndarray, np.ndarray]:
    """y (2 n,) shortly after the start, and the parameters of every mesh's contact there."""
    moment = solve_refined(model, np.array([0.0, MOMENT_S]), MOMENT_S)
    q, v = moment.q[-1], moment.v[-1]
    sides = contact_sides(model, MOMENT_S, q, v)
    contacts = np.stack([abs(sides), sides * model.gears.b], axis=1)
    return np.concatenate([q, v]), contacts.ravel()


class _Change:
    """Puts a mesh's contact on or off as its gap passes side * b, outwards or inwards."""

    def __init__(self, mesh: int, side: int, model: AnalyticModel) -> None:
        self.mesh, self.edge = mesh, side * float(model.gears.b[mesh])
        self.side = side

    def __call__(self, engine: Any, sign: int) -> bool:
        touches = sign * self.side > 0
        engine.pars[2 * self.mesh] = float(touches)
        engine.pars[2 * self.mesh + 1] = self.edge
        return True
