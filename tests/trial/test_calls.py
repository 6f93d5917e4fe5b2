"""A user's functions behind fixed signatures."""

import functools
import re
from collections.abc import Callable
from fractions import Fraction
from types import MethodType
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp

from crosscheck.checks.answers import BadAnswer
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import CannotDo, InputError
from crosscheck.models.loading import load_arm
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.calls import describe_failure
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.input.source_lines import has_literal
from crosscheck.trial.input.supplied import SuppliedEquations, bind_equations

ARM = load_arm("paper-labelled")
X, V, TORQUE = np.array([[0.3, -0.4], [1.0, 2.0], [30.0, 40.0]])
MASS = np.array([[5.0, 1.0], [1.0, 3.0]])
TWO = sp.symbols("a b")


def of(arm: Arm = ARM, **parts: Any) -> SuppliedEquations:
    return bind_equations(Equations(**parts), arm, build_frame(Coordinates(), arm))


class Callable4:
    """An object that can be called."""

    def __call__(self, v: np.ndarray, t: float, torque: np.ndarray, q: np.ndarray) -> np.ndarray:
        return t * q + 10 * v + torque


def default(t: Any, x: Any, v: Any, torque: Any = None, gain: float = 10.0) -> Any:
    return t * x + gain * v + torque


FORCES: dict[str, Callable[..., Any]] = {
    "by name": lambda torque, v, q, t: t * q + 10 * v + torque,
    "synonyms": lambda time, x, q_dot, tau: time * x + 10 * q_dot + tau,
    "Kane's speeds": lambda t, q, u, tau: t * q + 10 * u + tau,
    "torques as u": lambda t, q, qd, u: t * q + 10 * qd + u,
    "defaults": default,
    "partial": functools.partial(lambda gain, t, x, v, T: t * x + gain * v + T, 10.0),
    "partial by name": functools.partial(default, gain=10.0),
    "positional only": eval("lambda t, x, /, v, *, torque: t * x + 10 * v + torque"),
    "whatever": lambda *args: args[0] * args[1] + 10 * args[2] + args[3],
    "extra": lambda t, x, v, torque, **more: t * x + 10 * v + torque + len(more),
    "object": Callable4(),
    "wrapped": functools.wraps(default)(lambda *args, **kwargs: default(*args, **kwargs)),
    "no signature": np.frompyfunc(lambda t, x, v, torque: t * x + 10 * v + torque, 4, 1),
    "lambdified, numbers and names": sp.lambdify(
        [sp.Symbol("t"), TWO, sp.symbols("c d"), sp.symbols("e f")],
        [sp.sympify("t*a + 10*c + e"), sp.sympify("t*b + 10*d + f")],
    ),
    "lambdified": sp.lambdify(
        [sp.Symbol("s"), TWO, sp.symbols("c d"), sp.symbols("e f")],
        sp.Matrix([sp.sympify("s*a + 10*c + e"), sp.sympify("s*b + 10*d + f")]),
    ),
    "column": lambda t, x, v, torque: (t * x + 10 * v + torque)[:, None],
    "row": lambda t, x, v, torque: [list(t * x + 10 * v + torque)],
    "sympy": lambda t, x, v, torque: sp.Matrix([sp.Float(f) for f in t * x + 10 * v + torque]),
    "fractions": lambda t, x, v, torque: [Fraction(f) for f in t * x + 10 * v + torque],
    "real complex": lambda t, x, v, torque: t * x + 10 * v + torque + 0j,
    "matrix": lambda t, x, v, torque: np.matrix(t * x + 10 * v + torque),
    "objects": lambda t, x, v, torque: (t * x + 10 * v + torque).astype(object),
    "masked nowhere": lambda t, x, v, torque: np.ma.array(t * x + 10 * v + torque),
    "casadi matrix": lambda t, x, v, torque: ca.DM(t * x + 10 * v + torque),
}


@pytest.mark.parametrize("kind", FORCES)
def test_force_of_every_kind(kind):
    found = of(force=FORCES[kind]).force(2.0, X, V, TORQUE)
    assert found.dtype == np.float64
    np.testing.assert_allclose(found, 2 * X + 10 * V + TORQUE, rtol=1e-15)


def test_casadi_functions():
    t, x, v, torque = ca.SX.sym("t"), *(ca.SX.sym(name, 2) for name in ("x", "v", "torque"))
    expression = t * x + 10 * v + torque
    named = ca.Function("f", [torque, v, x, t], [expression], ["tau", "qd", "q", "t"], ["out"])
    nameless = ca.Function("f", [t, x, v, torque], [expression])
    for function in (named, nameless):
        found = of(force=function).force(2.0, X, V, TORQUE)
        np.testing.assert_allclose(found, 2 * X + 10 * V + TORQUE)
    sparse = ca.Function("m", [x], [ca.diag(ca.vertcat(x[0], 2))], ["q"], ["M"])
    np.testing.assert_allclose(of(mass_matrix=sparse).mass_matrix(X), np.diag([0.3, 2]))
    with pytest.raises(InputError, match="gives 2 outputs"):
        of(bias=ca.Function("b", [x, v], [x, v]))
    with pytest.raises(InputError, match="takes lam, which is none of x, q"):
        of(mass_matrix=ca.Function("m", [x], [x], ["lam"], ["o"]))


def mass(q: np.ndarray) -> np.ndarray:
    return MASS


def coriolis(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.array([[0, v[1]], [-v[0], 1]])


BIAS = coriolis(X, V) @ V


def inverse(x: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    return MASS @ a + coriolis(x, v) @ v


def test_what_follows():
    by_matrix = of(mass_matrix=mass, coriolis=coriolis, force=lambda torque: torque)
    assert by_matrix.given == {"mass_matrix", "coriolis", "force"}
    assert by_matrix.has - by_matrix.given == {"bias", "acceleration"}
    np.testing.assert_allclose(by_matrix.bias(X, V), BIAS)
    acceleration = np.linalg.solve(MASS, TORQUE - BIAS)
    np.testing.assert_allclose(by_matrix.acceleration(0.0, X, V, TORQUE), acceleration)
    crossed = of(mass_matrix=lambda q: 1 - np.eye(2), bias=lambda v: BIAS, force=lambda t: 0 * X)
    assert crossed.acceleration(0.0, X, V, TORQUE).tolist() == (-BIAS[::-1]).tolist()
    by_inverse = of(inverse_dynamics=inverse)
    assert by_inverse.has == {"inverse_dynamics", "mass_matrix", "bias"}
    np.testing.assert_allclose(by_inverse.mass_matrix(X), MASS)
    np.testing.assert_allclose(by_inverse.bias(X, V), BIAS)
    assert of(force=lambda q: q, any_scenario=True).motors == (0, 1)  # the drive may be in it
    alone = of(mass_matrix=mass)
    assert alone.has == {"mass_matrix"}
    for call in (lambda: alone.bias(X, V), lambda: alone.force(0.0, X, V, TORQUE)):
        with pytest.raises(CannotDo):
            call()


def test_what_a_function_does_to_its_arguments_does_no_harm():
    def greedy(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        q[:] = 0.0
        v *= 2
        return v

    x, v = X.copy(), V.copy()
    of(bias=greedy).bias(x, v)
    assert (x == X).all()
    assert (v == V).all()
    answer = MASS.copy()  # which a function may keep and fill anew
    first = of(mass_matrix=lambda q: answer).mass_matrix(X)
    answer *= 2
    assert (first == MASS).all()


def test_a_number_of_either_sign_is_found_in_a_functions_file():
    found = [has_literal(Equations(bias=inverse), "bias", each) for each in (30.0, -30.0, 60 / 7)]
    assert found == [True, True, False]


def test_one_joint_may_answer_numbers():
    arm = ARM.model_copy(update={"joints": ARM.joints[:1], "links": ARM.links[:1]})
    model = of(arm, mass_matrix=lambda q: 3, bias=lambda q, v: 0.0)
    assert model.mass_matrix(np.zeros(1)).tolist() == [[3.0]]
    assert model.bias(np.zeros(1), np.zeros(1)).tolist() == [0.0]


ANSWERS: dict[str, Any] = {
    r"has shape \(3, 3\), must be \(2, 2\)": np.eye(3),
    r"has shape \(2,\), must be \(2, 2\)": np.ones(2),
    r"has NaN at \[0, 1\], must be finite": [[1, np.nan], [0, 1]],
    r"has an infinite number at \[1, 1\]": [[1, 0], [0, np.inf]],
    "is complex, must be real": np.eye(2) * (1 + 1e-30j),
    "is None, must be numbers": None,
    "is an object that holds object": object(),
    "is of type <U1": [["a", "b"], ["c", "d"]],
    "has rows of unequal length": [[1, 2], [3]],
    "is masked": np.ma.masked_equal(np.eye(2), 0),
    "is a .*Matrix that holds .*Symbol.*, must be numbers": sp.Matrix(
        [[sp.Symbol("m"), 0], [0, 1]]
    ),
    "is a SX, must be numbers": ca.SX.sym("m", 2, 2),
    "is a dict that holds dict": {"M": np.eye(2)},
    "is a list that holds NoneType": [[None, 1], [2, 3]],
}


@pytest.mark.parametrize("reason", ANSWERS)
def test_bad_answers(reason):
    with pytest.raises(BadAnswer, match=f"^mass_matrix {reason}") as caught:
        of(mass_matrix=lambda q: ANSWERS[reason]).mass_matrix(X)
    assert str(caught.value).endswith("at x = [0.3, -0.4]")
    assert "\n" not in str(caught.value)


def test_names_of_the_users_own_mean_the_same_in_every_function():
    given = of(
        mass_matrix=lambda phi: np.diag(phi),
        bias=lambda phi, phid: phi * phid,
        force=lambda phid, torque: torque - phid,
    )
    np.testing.assert_array_equal(given.mass_matrix(X), np.diag(X))
    np.testing.assert_array_equal(given.bias(X, V), X * V)
    np.testing.assert_array_equal(given.force(0.0, X, V, TORQUE), TORQUE - V)


def test_what_a_function_raises_comes_out_with_its_state():
    with pytest.raises(ZeroDivisionError) as caught:
        of(force=lambda t: 1 / 0).force(0.5, X, V, TORQUE)
    assert caught.value.__notes__ == [
        "force at t = [0.5], x = [0.3, -0.4], v = [1, 2], torque = [30, 40]"
    ]


FUNCTIONS: dict[str, dict[str, Any]] = {
    "force: takes psi, which is none of t, time; x, q; v,": {
        "mass_matrix": lambda phi: 1,
        "force": lambda phi, psi, torque: 1,
    },
    "mass_matrix: takes v, which is none of x, q": {"mass_matrix": lambda q, v: 1},
    "bias: takes w, which is none of x, q; v, qd, dq,": {"bias": lambda q, w: 1},
    "force: takes u, which is none of t, time;": {"force": lambda q, u: 1},
    "force: is an ndarray; must be a function of t, x, v, torque": {"force": np.eye(2)},
    "bias: is a method whose first parameter is q; must be self": {
        "bias": MethodType(lambda q, v: q * v, X)
    },
    "force: takes 2 arguments without names, must take t, x, v, torque": {
        "force": sp.lambdify([TWO, TWO], sp.Matrix(TWO))
    },
}


@pytest.mark.parametrize("reason", FUNCTIONS)
def test_bad_functions(reason):
    with pytest.raises(InputError, match=re.escape(reason)):
        of(**FUNCTIONS[reason])


def test_an_error_has_its_traceback_where_its_cause_was_never_raised():
    def raise_chained():
        raise ValueError("singular here") from KeyError("no entry")

    with pytest.raises(ValueError, match="singular here") as caught:
        raise_chained()
    trace = describe_failure(caught.value).trace
    assert "KeyError" in trace
    assert "raise_chained" in trace
