"""A user's coordinates x beside the project's q: q = phi(x), q' = J(x) x'."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout
from crosscheck.models.errors import InputError
from crosscheck.trial.input.arrays import format_vector
from crosscheck.trial.input.equations import Coordinates

WHERE = "coordinates"
WORST_CONDITION = 1e12  # largest condition number of J with scaled rows and columns
TRIES = 40
MOST_HALVED = 20
PLACED = 1e-9  # accuracy of a state found for given q, before it is polished
Vector = Callable[[np.ndarray], np.ndarray]
Along = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Frame:
    """The map from x (n,), called ``names``, to the coordinates q (n,) of ``layout``.

    position(x): q. slopes(x): dq/dx (n, n). drift(x, u): J' u
    (n,) at rates u = x', what q'' has beside J x''. They raise InputError where they find none.
    matrix: where the map is linear, q = matrix @ x.
    """

    layout: Layout
    names: tuple[str, ...]
    position: Vector
    slopes: Vector
    drift: Along
    matrix: np.ndarray | None = None

    @property
    def is_identity(self) -> bool:
        """Whether x are the project's coordinates themselves."""
        return self.matrix is not None and np.array_equal(self.matrix, np.eye(len(self.names)))

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
        reason = f"no x was found that gives q = {format_vector(q)}"
        raise InputError(WHERE, "function", None, reason)

    def find_nearest(self, q: np.ndarray, reachable_x: np.ndarray) -> np.ndarray:
        """An x (n,) that gives this q, or one on the way to it from that of a known x.

        It is found by Newton's method from few starts; where it is not, the way is halved.
        """
        start = self.position(reachable_x)
        for halved in range(MOST_HALVED):
            target = start + (q - start) / 2**halved
            zero = () if halved else (np.zeros(len(q)),)
            for guess in (target, *zero, reachable_x):
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


def build_linear_frame(layout: Layout, names: tuple[str, ...], matrix: np.ndarray) -> Frame:
    """The frame of q = matrix @ x."""
    return Frame(
        layout,
        names,
        position=lambda x: matrix @ x,
        slopes=lambda x: matrix.copy(),
        drift=lambda x, u: np.zeros(len(names)),
        matrix=matrix,
    )


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
        raise InputError(WHERE, "names", names, "must be different words")
    return names


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
