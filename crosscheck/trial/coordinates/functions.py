"""A user's functions of coordinates x as functions of the project's q."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from typing import Any

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.input.arrays import NotNumbers, convert_to_numbers
from crosscheck.trial.input.calls import MATRICES, Arguments

Call = Callable[[Arguments], Any]
RATED = ("bias", "coriolis")  # parts that stand beside M, of whose x'' the map's bend is a part
KEPT_STATES = 1024  # states whose map is kept: several parts are asked at each


def map_calls(calls: Mapping[str, Call], frame: Frame, where: str) -> dict[str, Call]:
    """The functions of x as functions of q: what they get and what they answer is carried over.

    With q' = J x' it is M = J^-T M_x J^-1, and a force is J^-T times that along x. Torques are
    those of the joints in both. A matrix of Coriolis of curved coordinates counts as
    the bias that it makes. Raises InputError where a bias has no M beside it.
    """
    if frame.is_identity:
        return dict(calls)
    mass_of, curved = calls.get("mass_matrix"), frame.matrix is None
    rated = [part for part in RATED if part in calls]
    if curved and rated and mass_of is None:
        reason = "needs mass_matrix beside it: the coordinates are curved, q'' = J x'' + J' x'"
        raise InputError(where, rated[0], None, reason)

    @lru_cache(maxsize=KEPT_STATES)
    def map_state(q: bytes, v: bytes) -> tuple[np.ndarray, ...]:
        """Of a state of the joints x (n,), J (n, n), x' (n,), and J' x' (n,)."""
        x = frame.place(np.frombuffer(q))
        jacobian, v_q = frame.jacobian(x), np.frombuffer(v)
        u = np.linalg.solve(jacobian, v_q)
        bend = frame.drift(x, u) if v_q.any() else np.zeros_like(u)  # a square of the rates
        return x, jacobian, u, bend

    def carry(part: str, call: Call, arguments: Arguments) -> Any:
        """The answer in the joints' coordinates, or as it is where it is no answer."""
        q = np.asarray(arguments["x"], dtype=float)
        v = arguments.get("v", np.zeros_like(q))
        x, jacobian, u, bend = map_state(q.tobytes(), v.tobytes())
        moved = {**arguments, "x": x.copy(), "v": u.copy()}
        if "a" in arguments:
            moved["a"] = np.linalg.solve(jacobian, arguments["a"] - bend)
        raw, shape = call(moved), (len(x), len(x))
        try:
            answer = convert_to_numbers(raw, shape if part in MATRICES else shape[:1])
        except NotNumbers:  # the caller reports it with the state
            return raw
        if part == "acceleration":
            return jacobian @ answer + bend
        if part == "coriolis" and curved:
            answer = answer @ u
        if answer.ndim == 2:
            return np.linalg.solve(jacobian.T, answer) @ np.linalg.inv(jacobian)
        if part in RATED and bend.any():
            assert mass_of is not None  # as was required
            mass = convert_to_numbers(mass_of({"x": x.copy()}), shape)
            answer = answer - mass @ np.linalg.solve(jacobian, bend)
        return np.linalg.solve(jacobian.T, answer)

    mapped = {part: partial(carry, part, call) for part, call in calls.items()}
    return {"bias" if curved and part == "coriolis" else part: c for part, c in mapped.items()}
