"""A user's coordinates x beside the project's q: q = phi(x), q' = J(x) x'; and random states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
import sympy as sp

from crosscheck.analytic.derivation.chain import Chain, build_exact_chain
from crosscheck.analytic.derivation.stage import Stage
from crosscheck.analytic.derivation.symbols import build_arm_chain
from crosscheck.analytic.paper.kinematics import mesh_displacements
from crosscheck.checks.answers import sample_states
from crosscheck.checks.invariants import torques_at
from crosscheck.models.arm import layout as layouts
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Coordinate, Layout
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.drive import drive_data
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.trial.input.arrays import NotNumbers, convert_to_numbers, format_vector
from crosscheck.trial.input.equations import Coordinates, Gearing

WHERE = "coordinates"
WORST_CONDITION = 1e12  # of J, rows and columns scaled: beyond it x says too little of q
ROUNDING = 1e-13  # of a matrix's row: what is below it was meant to be 0
LARGEST_DENOMINATOR = 1000  # of what is taken for a ratio of whole numbers
FIRST = 20  # poses that a map may not reach, before it is one that reaches none
TRIES = 40
MOST_HALVED = 20
PLACED = 1e-9  # of a state found for given q, before it is polished
LAYOUTS = {
    "rigid": layouts.rigid_layout,
    "lumped": layouts.lumped_layout,
    "free": layouts.free_layout,
}
JacobianSource = Literal["linear", "sympy", "given", "complex step", "differences"]
Vector = Callable[[np.ndarray], np.ndarray]
Along = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Frame:
    """The map from x (n,), called ``names``, to the coordinates q (n,) of ``layout``.

    position(x): q. slopes(x): dq/dx (n, n); jacobian_source: where it comes from. drift(x, u): J' u
    (n,) at rates u = x', what q'' has beside J x''. They raise InputError where they find none.
    matrix: where the map is linear, q = matrix @ x. symbolic: the same in symbols of
    ``analytic.derivation.symbols``, of named maps and of matrices whose numbers are ratios, radii
    and gear ratios of the arm.
    """

    layout: Layout
    names: tuple[str, ...]
    jacobian_source: JacobianSource
    position: Vector
    slopes: Vector
    drift: Along
    matrix: np.ndarray | None = None
    symbolic: sp.ImmutableMatrix | None = None

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """J = dq/dx (n, n). Raises InputError where it is singular."""
        jacobian = self.slopes(x)
        if self.matrix is None:  # which was looked at once and for all
            require_invertible(jacobian, "jacobian", x)
        return jacobian

    def place(self, q: np.ndarray) -> np.ndarray:
        """An x (n,) that gives this q. Raises InputError where none is found.

        If the map is not linear, it is found by Newton's method from several starts.
        """
        if self.matrix is not None:
            return np.linalg.solve(self.matrix, q)
        n = len(self.names)
        drawn = np.random.default_rng(0).uniform(-np.pi, np.pi, (TRIES, n))
        for start in (q.copy(), np.zeros(n), *drawn):
            solution = self._solve(start, q)
            if solution is not None:
                return solution
        raise InputError(
            WHERE, "function", None, f"no x was found that gives q = {format_vector(q)}"
        )

    def find_nearest(self, q: np.ndarray, reachable_x: np.ndarray) -> np.ndarray:
        """An x (n,) that gives this q, or one on the way to it from that of a known x.

        It is found by Newton's method from few starts; where it is not, the way is halved.
        """
        start = self.position(reachable_x)
        for halved in range(MOST_HALVED):
            target = start + (q - start) / 2**halved
            for guess in (
                (target, reachable_x) if halved else (target, np.zeros(len(q)), reachable_x)
            ):
                solution = self._solve(guess, target)
                if solution is not None:
                    return solution
        return reachable_x

    def _solve(self, start: np.ndarray, q: np.ndarray) -> np.ndarray | None:
        """The x (n,) that gives q, by Newton's method from a start; None if it does not arrive."""
        from scipy.optimize import root

        size = np.maximum(np.abs(q), 1e-3 * max(1e-3, float(np.abs(q).max())))
        try:
            with np.errstate(all="ignore"):
                x = root(lambda x: (self.position(x) - q) / size, start, tol=1e-13).x
                for _ in range(3):
                    x = x - np.linalg.solve(self.jacobian(x), self.position(x) - q)
                reached = np.abs(self.position(x) - q) <= PLACED * size
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None
        return x if reached.all() else None


def build_linear_frame(
    layout: Layout, names: tuple[str, ...], matrix: np.ndarray, symbolic: sp.ImmutableMatrix | None
) -> Frame:
    """The frame of q = matrix @ x."""
    return Frame(
        layout,
        names,
        "linear",
        position=lambda x: matrix @ x,
        slopes=lambda x: matrix.copy(),
        drift=lambda x, u: np.zeros(len(names)),
        matrix=matrix,
        symbolic=symbolic,
    )


def build_frame(coordinates: Coordinates, arm: Arm) -> Frame:
    """The frame of a user's coordinates. Raises InputError."""
    from crosscheck.trial.coordinates.curved import build_curved_frame

    _require_allowed_choices(coordinates)
    layout = LAYOUTS[coordinates.gearing](arm)
    if coordinates.function is not None:
        return build_curved_frame(coordinates, layout, arm)
    if coordinates.matrix is None:
        return _build_named_frame(coordinates, layout, arm)
    n = len(layout)
    try:
        matrix = convert_to_numbers(coordinates.matrix, (n, n))
    except NotNumbers as error:
        reason = f"{error}, for {describe_coordinate_count(coordinates, n, arm)}"
        raise InputError(WHERE, "matrix", None, reason) from None
    require_invertible(matrix, "matrix")
    names = select_coordinate_names(coordinates, [f"x_{k + 1}" for k in range(n)])
    return build_linear_frame(layout, names, matrix, express_in_symbols(matrix, layout, arm))


def _require_allowed_choices(coordinates: Coordinates) -> None:
    """Raise InputError for a word that is not allowed, or for two maps at once."""
    allowed = {
        "gearing": get_args(Gearing),
        "links": ("relative", "absolute"),
        "gears": ("displacements", "angles"),
    }
    for name, words in allowed.items():
        word = getattr(coordinates, name)
        if word not in words:
            raise InputError(WHERE, name, word, f"must be one of {', '.join(words)}")
    if coordinates.matrix is not None and coordinates.function is not None:
        raise InputError(WHERE, "matrix", None, "give either matrix or function")
    map_field = "matrix" if coordinates.matrix is not None else "function"
    mapped = coordinates.matrix is not None or coordinates.function is not None
    usual = Coordinates()
    for name in ("links", "gears", "order"):
        if mapped and getattr(coordinates, name) != getattr(usual, name):
            reason = f"is for named coordinates; {map_field} alone says what x is"
            raise InputError(WHERE, name, getattr(coordinates, name), reason)
    for name in ("jacobian", "symbols"):
        if coordinates.function is None and getattr(coordinates, name) not in (None, ()):
            raise InputError(WHERE, name, None, "needs function beside")


def _build_named_frame(coordinates: Coordinates, layout: Layout, arm: Arm) -> Frame:
    """The frame of coordinates by name, in the user's order. Raises InputError."""
    usual = [_coordinate_name(coordinates, coordinate) for coordinate in layout.coordinates]
    ordered = coordinates.order or usual
    missing = [name for name in usual if name not in ordered]
    unknown = [name for name in ordered if name not in usual]
    twice = [name for name, count in Counter(ordered).items() if count > 1]
    mistakes = {"is without": missing, "has unknown": unknown, "has twice": twice}
    wrong = [f"{what} {', '.join(map(str, names))}" for what, names in mistakes.items() if names]
    if wrong:
        reason = f"{' and '.join(wrong)}; must be all of {', '.join(usual)}"
        raise InputError(WHERE, "order", None, reason)
    order = [usual.index(name) for name in ordered]
    symbolic = _map_rows(build_arm_chain(arm, layout), coordinates)[:, order]
    numbers = _map_rows(build_exact_chain(arm, layout), coordinates)[:, order].astype(np.float64)
    names = select_coordinate_names(coordinates, [usual[place] for place in order])
    return build_linear_frame(layout, names, numbers, sp.ImmutableMatrix(symbolic))


def _coordinate_name(coordinates: Coordinates, meant: Coordinate) -> str:
    """The name of the coordinate of x that stands in place of one of the layout."""
    if meant.is_angle:
        return f"{'phi' if coordinates.links == 'absolute' else 'theta'}_{meant.joint}"
    if coordinates.gears == "displacements":
        return meant.name
    gear = f"theta_{'p' if meant.meaning == 'x_pr' else 's'}{meant.joint}"
    return gear + (f"_{meant.planet}" if meant.planet else "")


def _map_rows(chain: Chain, coordinates: Coordinates) -> np.ndarray:
    """Rows over x that give q, x in the layout's order; numbers or symbols, as the chain's are."""
    layout_rows = [chain.row(c.meaning, c.joint, c.planet) for c in chain.layout.coordinates]
    turns = {joint: chain.row("theta", joint) for joint in chain.numbers}
    if coordinates.links == "absolute":
        turns |= {joint: turns[joint] - turns[joint - 1] for joint in chain.numbers if joint > 1}
    if coordinates.gears == "displacements":
        pairs = zip(chain.layout.coordinates, layout_rows, strict=True)
        return np.array([turns[c.joint] if c.is_angle else row for c, row in pairs])
    mapped_rows = []
    for meant in chain.layout.coordinates:
        turn, stage = turns[meant.joint], chain.stages[meant.joint - 1]
        if meant.is_angle:
            mapped_rows.append(turn)
            continue
        assert isinstance(stage, Stage)
        theta_s = chain.row("x_s" if chain.layout.free else "x_sp", meant.joint)
        theta_p = chain.row("x_pr", meant.joint, meant.planet)
        radii = stage.r_s, stage.r_p, stage.r_cp
        x_sp, x_pr = mesh_displacements(theta_s, theta_p, turn, *radii)  # Eqs. 2-3
        rows: dict[str, np.ndarray] = {"x_sp": x_sp, "x_pr": x_pr, "x_s": x_sp + x_pr}
        mapped_rows.append(rows[meant.meaning])
    return np.array(mapped_rows)


def describe_coordinate_count(coordinates: Coordinates, n: int, arm: Arm) -> str:
    """How many coordinates there are and of what, in words, for a line on a wrong length."""
    return f"the {n} {coordinates.gearing} coordinates of {arm.name}, {len(arm.joints)} joints"


def select_coordinate_names(coordinates: Coordinates, usual: Sequence[str]) -> tuple[str, ...]:
    """The user's names of x, or the usual ones. Raises InputError."""
    names = tuple(coordinates.names) or tuple(usual)
    if len(names) != len(usual):
        reason = f"must be {len(usual)}, one for each coordinate; are {len(names)}"
        raise InputError(WHERE, "names", names, reason)
    if not all(isinstance(name, str) and name for name in names) or len(set(names)) < len(names):
        raise InputError(WHERE, "names", names, "must be words unlike each other")
    return names


def express_in_symbols(matrix: np.ndarray, layout: Layout, arm: Arm) -> sp.ImmutableMatrix | None:
    """The matrix in ratios of whole numbers and the radii and ratios of each row's own joint.

    None where some number is none of these; what rounding left of a 0 counts as 0.
    """
    symbols, numbers = build_arm_chain(arm, layout).stages, build_exact_chain(arm, layout).stages
    symbolic_entries = []
    for row, meant in zip(matrix, layout.coordinates, strict=True):
        stage, numeric_stage = symbols[meant.joint - 1], numbers[meant.joint - 1]
        quantity_values: dict[sp.Expr, float] = {}
        if isinstance(stage, Stage) and isinstance(numeric_stage, Stage):
            quantity_values = dict(
                zip(_quantities(stage), map(float, _quantities(numeric_stage)), strict=True)
            )
        nothing = ROUNDING * float(np.abs(row).max())
        for value in row.tolist():
            ratio = Fraction(value).limit_denominator(LARGEST_DENOMINATOR)
            alike = (
                f
                for f, n in quantity_values.items()
                if abs(abs(value) - abs(n)) <= ROUNDING * abs(n)
            )
            form = next(alike, None)
            if abs(value) <= nothing:
                symbolic_entries.append(sp.Integer(0))
            elif float(ratio) == value:
                symbolic_entries.append(sp.Rational(ratio.numerator, ratio.denominator))
            elif form is not None:
                symbolic_entries.append(form if value * quantity_values[form] > 0 else -form)
            else:
                return None
    return sp.ImmutableMatrix(*matrix.shape, symbolic_entries)


def _quantities(stage: Stage) -> tuple[Any, ...]:
    """Quantities of a stage that people put in a map of its joint, simplest first."""
    r_s, r_p, r_cp, n = stage.r_s, stage.r_p, stage.r_cp, stage.n
    radii = r_s, r_p, r_cp, 2 * r_s, 2 * r_p, 2 * r_cp, r_s + 2 * r_p
    return *radii, n, 1 / n, 1 / r_s, 1 / r_p, 1 / r_cp, r_p / r_s, r_s / r_p, 2 * r_cp / r_s


def require_invertible(matrix: np.ndarray, what: str, x: np.ndarray | None = None) -> None:
    """Raise InputError, naming the state if there is one, for a matrix that is singular."""
    columns = np.abs(matrix).max(axis=0)
    condition = np.inf
    if columns.all():
        scaled = matrix / columns
        rows = np.abs(scaled).max(axis=1)
        condition = np.linalg.cond(scaled / rows[:, None]) if rows.all() else np.inf
    if not condition < WORST_CONDITION:
        place = "" if x is None else f" at x = {format_vector(x)}"
        raise InputError(WHERE, what, None, f"is singular{place}: other x give the same q")


class UserState(NamedTuple):
    """A state of the arm in the user's coordinates and in the project's.

    t [s]; x, u (n,), the user's coordinates and rates; q, v (n,), the project's; torque (joints,):
    output torques [N m] of the scenario's drive.
    """

    t: float
    x: np.ndarray
    u: np.ndarray
    q: np.ndarray
    v: np.ndarray
    torque: np.ndarray


@lru_cache(maxsize=8)  # every question of a trial asks at the same ones
def draw_states(
    frame: Frame, arm: Arm, scenario: Scenario, count: int, seed: int
) -> tuple[UserState, ...]:
    """Random states on both flanks of the teeth, at any pose, moving briskly.

    A pose that no x gives is shifted towards one that some x gives. Raises InputError.
    """
    drive, theta = drive_data(scenario, len(arm.joints)), frame.layout.theta
    drawn, states = sample_states(frame.layout, arm, count, seed), []
    for t, x, v in zip(drawn.t.tolist(), find_coordinates(frame, drawn.q), drawn.v, strict=True):
        q = frame.position(x)
        u = np.linalg.solve(frame.jacobian(x), v)
        states.append(UserState(t, x, u, q, v, torques_at(drive, t, q[theta], v[theta])))
    return tuple(states)


def find_coordinates(frame: Frame, drawn: np.ndarray) -> Iterator[np.ndarray]:
    """An x for each q (count, n). Raises InputError where no x gives any of the first ones."""
    if frame.matrix is not None:
        yield from map(frame.place, drawn)
        return
    reachable_x = None
    for q in drawn[:FIRST]:
        with suppress(InputError):
            reachable_x = frame.place(q)
            break
    reachable_x = frame.place(drawn[0]) if reachable_x is None else reachable_x
    for q in drawn:
        yield frame.find_nearest(q, reachable_x)
