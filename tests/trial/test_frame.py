"""A user's coordinates beside the project's own."""

import math
from contextlib import nullcontext
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.analytic.derivation.chain import build_exact_chain
from crosscheck.models.arm.layout import free_layout, lumped_layout, rigid_layout
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.registry import build
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.changes.arms.polynomial import as_polynomial
from crosscheck.trial.changes.arms.segments import find_columns
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.frame import Frame, require_invertible
from crosscheck.trial.input.equations import Coordinates
from tests.arms import random_arm

PAPER = load_arm("paper-labelled")
LAYOUTS = {"rigid": rigid_layout, "lumped": lumped_layout, "free": free_layout}
NAMED = st.builds(
    Coordinates,
    gearing=st.sampled_from(sorted(LAYOUTS)),
    links=st.sampled_from(["relative", "absolute"]),
    gears=st.sampled_from(["displacements", "angles"]),
)
ARMS = st.integers(0, 200).map(lambda seed: random_arm(seed, most_joints=4))
SMALL = st.floats(-2, 2)


def states(frame: Frame, seed: int) -> tuple[np.ndarray, np.ndarray]:
    x, u = np.random.default_rng(seed).uniform(-1, 1, (2, len(frame.names)))
    return x, u


@settings(max_examples=40)
@given(ARMS, NAMED, st.integers(0, 99))
def test_named_maps(arm, coordinates, seed):
    """x are what their names say: cumulative angles, and gear angles by the chain's own rows."""
    usual = build_frame(coordinates, arm)
    order = tuple(np.random.default_rng(seed).permutation(usual.names).tolist())
    frame = build_frame(replace(coordinates, order=order), arm)
    assert frame.names == order
    x, _ = states(frame, 1)
    q = frame.position(x)
    expected, chain = {}, build_exact_chain(arm, frame.layout)
    for joint in chain.numbers:
        expected[f"theta_{joint}"] = chain.row("theta", joint)
        expected[f"phi_{joint}"] = chain.angles[joint]
    for joint, _ in chain.geared_joints if coordinates.gearing != "rigid" else ():
        expected[f"theta_s{joint}"] = chain.sun_row(joint)
        for place, (_, row) in enumerate(chain.planet_rows(joint), start=1):
            suffix = f"_{place}" if frame.layout.free else ""
            expected[f"theta_p{joint}{suffix}"] = row
    for place, name in enumerate(frame.layout.names):
        expected.setdefault(name, np.eye(len(q))[place])
    rows = np.array([expected[name].astype(float) for name in frame.names])
    np.testing.assert_allclose(rows @ q, x, atol=1e-9)
    np.testing.assert_allclose(rows @ frame.jacobian(x), np.eye(len(q)), atol=1e-9)


@settings(max_examples=20)
@given(ARMS, NAMED)
def test_symbols_say_what_numbers_say(arm, coordinates):
    frame = build_frame(coordinates, arm)
    values, columns = collect_arm_values(arm), find_columns(frame, arm)
    numbers = [as_polynomial(entry).value(values) for entry in columns.ravel()]
    np.testing.assert_allclose(np.reshape(numbers, columns.shape), frame.matrix, rtol=1e-12, atol=0)


@given(st.lists(SMALL, min_size=2, max_size=2), st.lists(SMALL, min_size=2, max_size=2))
def test_mass_matrix_and_bias_in_absolute_angles(pose, rates):
    """J^T M J and J^T (h + M J' u) are what the textbook has in absolute angles."""
    frame = build_frame(Coordinates(links="absolute"), PAPER)
    x, u = np.array(pose), np.array(rates)
    model = build("analytic:links", PAPER, load_scenario("constant-torque"))
    q, jacobian = frame.position(x), frame.jacobian(x)
    mass = jacobian.T @ model.mass_matrix(q) @ jacobian
    coupling = (18.9 * 0.35 + 10 * 0.7) * np.cos(x[0] - x[1])
    first, second = 27 * (1 / 12 + 0.25) + 28.9, 18.9 * (0.49 / 12 + 0.35**2) + 10 * 0.49
    np.testing.assert_allclose(mass, [[first, coupling], [coupling, second]], atol=1e-12)
    pull = (18.9 * 0.35 + 10 * 0.7) * np.sin(x[0] - x[1])
    bias = jacobian.T @ (model.bias(q, jacobian @ u) + mass @ frame.drift(x, u))
    np.testing.assert_allclose(bias, [pull * u[1] ** 2, -pull * u[0] ** 2], atol=1e-11)


def curved(x: np.ndarray) -> np.ndarray:
    return np.array([x[0] + 0.25 * np.sin(x[0]) * np.cos(x[1]), x[1] + 0.3 * np.sin(x[1] - x[0])])


def of_floats(x: np.ndarray) -> list[float]:
    return [x[0] + 0.25 * math.sin(x[0]) * math.cos(x[1]), x[1] + 0.3 * math.sin(x[1] - x[0])]


def cast(x: np.ndarray) -> np.ndarray:
    """Loses the imaginary part with a warning alone."""
    return curved(np.asarray(x).astype(float))


def slopes(x: np.ndarray) -> np.ndarray:
    near = 0.3 * np.cos(x[1] - x[0])
    along, across = 0.25 * np.cos(x[0]) * np.cos(x[1]), -0.25 * np.sin(x[0]) * np.sin(x[1])
    return np.array([[1 + along, across], [-near, 1 + near]])


A, B = sp.symbols("a b")
SYMBOLIC = sp.Matrix([A + sp.sin(A) * sp.cos(B) / 4, B + sp.Rational(3, 10) * sp.sin(B - A)])
MAPS = {
    "complex step": Coordinates(function=curved),
    "differences": Coordinates(function=of_floats),
    "given": Coordinates(function=of_floats, jacobian=slopes),
    "sympy": Coordinates(function=SYMBOLIC, symbols=(A, B)),
}


@pytest.mark.parametrize("found_by", MAPS)
def test_curved_maps(found_by):
    """However the derivatives come about, they are the same."""
    frame, exact = build_frame(MAPS[found_by], PAPER), build_frame(MAPS["sympy"], PAPER)
    assert frame.matrix is None
    for seed in range(10):
        x, u = states(frame, seed)
        np.testing.assert_allclose(frame.position(x), curved(x), rtol=1e-14)
        np.testing.assert_allclose(frame.jacobian(x), slopes(x), rtol=1e-12, atol=1e-13)
        tolerance = 1e-9 if found_by == "differences" else 1e-12
        np.testing.assert_allclose(frame.drift(x, 5 * u), exact.drift(x, 5 * u), atol=tolerance)
        again = frame.place(frame.position(x))
        np.testing.assert_allclose(frame.position(again), frame.position(x), atol=1e-13)


def test_a_function_that_drops_imaginary_parts_is_seen():
    frame = build_frame(Coordinates(function=cast), PAPER)
    x, _ = states(frame, 0)
    np.testing.assert_allclose(frame.jacobian(x), slopes(x), rtol=1e-12, atol=1e-13)


def test_a_straight_function_is_a_matrix():
    """In the arm's own symbols, which stand for its numbers."""
    r_s1, r_p1, r_cp1 = sp.symbols("r_s1 r_p1 r_cp1")
    sun, planet, *others = sp.symbols("s p theta x_sp2 x_pr2 theta_2")
    q = [r_s1 * sun - r_p1 * planet - r_cp1 * others[0], r_p1 * planet - r_cp1 * others[0]]
    own = Coordinates(
        gearing="lumped", function=sp.Matrix([*q, *others]), symbols=(sun, planet, *others)
    )
    named = Coordinates(gearing="lumped", gears="angles")
    found, expected = build_frame(own, PAPER), build_frame(named, PAPER)
    np.testing.assert_allclose(found.matrix[:3], expected.matrix[:3], rtol=1e-14)
    left, right = (find_columns(each, PAPER)[:3].ravel() for each in (found, expected))
    assert [as_polynomial(e).terms for e in left] == [as_polynomial(e).terms for e in right]


def test_own_matrices():
    frame = build_frame(Coordinates(matrix=[[1, 0], [-1, 1]], names=("a", "b")), PAPER)
    assert frame.names == ("a", "b")
    assert find_columns(frame, PAPER).tolist() == [[1, 0], [-1, 1]]
    ratios = [3 / 14, 0.1], [Fraction(3, 14), Fraction(1, 10)]
    for numbers, found in (ratios, ([math.pi, 1], [math.pi, 1])):
        ratio = build_frame(Coordinates(matrix=np.diag(numbers)), PAPER)
        assert np.diag(find_columns(ratio, PAPER)).tolist() == found


def test_a_singular_state_is_named():
    frame = build_frame(Coordinates(function=lambda x: np.array([x[0] ** 2, x[1]])), PAPER)
    with pytest.raises(InputError, match=r"jacobian: is singular at x = \[0, 0.5\]"):
        frame.jacobian(np.array([0.0, 0.5]))
    with pytest.raises(InputError, match="no x was found"):
        frame.place(np.array([-1.0, 0.0]))


@pytest.mark.parametrize(("share", "is_singular"), [(0.98, False), (1.02, True)])
def test_a_matrix_is_singular_from_a_condition_number_of_1e12(share, is_singular):
    """However large its rows and columns are."""
    unlike = np.outer([1e3, 1e-5], [1e7, 1.0]) * [[1.0, 1.0], [1.0, 1.0 + 4e-12 / share]]
    with pytest.raises(InputError) if is_singular else nullcontext():
        require_invertible(unlike, "matrix")


@pytest.mark.parametrize(("off", "agrees"), [(0.98e-6, True), (1.02e-6, False)])
def test_slopes_are_those_of_the_function_to_a_millionth_of_their_row(off, agrees):
    """Of the largest in the row; differences are closer than a hundredth of that."""

    def near(x: np.ndarray) -> np.ndarray:
        rows = slopes(x)
        rows[0, 1] += off * np.abs(rows[0]).max()
        return rows

    with nullcontext() if agrees else pytest.raises(InputError, match="differences of function"):
        build_frame(Coordinates(function=curved, jacobian=near), PAPER)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("turned", [1, -1])
def test_values_at_one_state_in_forty_are_enough(turned):
    """Of the states that are tried one alone is so far out; slopes are looked at there."""

    def far_out(x: np.ndarray) -> np.ndarray:
        return curved(x) + 0 * np.sqrt(x[0] - 0.85)

    own = Coordinates(function=far_out, jacobian=lambda x: slopes(x) * [[1, 1], [turned, 1]])
    with nullcontext() if turned == 1 else pytest.raises(InputError, match="of theta_2 by x_1"):
        build_frame(own, PAPER)


BAD = {
    "rigid, lumped, free": Coordinates(gearing="geared"),
    "links = 'abs': must be one of relative, absolute": Coordinates(links="abs"),
    "give either matrix or function": Coordinates(matrix=np.eye(2), function=curved),
    "matrix alone says what x is": Coordinates(matrix=np.eye(2), links="absolute"),
    "needs function beside": Coordinates(jacobian=slopes),
    "without theta_2 and has unknown phi_2": Coordinates(order=("theta_1", "phi_2")),
    "has twice theta_1": Coordinates(order=("theta_1", "theta_1", "theta_2")),
    r"has shape \(3, 3\), must be \(2, 2\), for the 2 rigid coord": Coordinates(matrix=np.eye(3)),
    "matrix: is complex": Coordinates(matrix=1j * np.eye(2)),
    r"has NaN at \[0, 1\]": Coordinates(matrix=[[1, math.nan], [0, 1]]),
    "matrix: is singular": Coordinates(matrix=[[1, 2], [2, 4]]),
    "of unequal length": Coordinates(matrix=[[1, 2], [2]]),
    "must be 2, one for each coordinate; are 3": Coordinates(names=("a", "b", "c")),
    "must be different words": Coordinates(names=("a", "a")),
    r"\('a', ''\): must be different words": Coordinates(names=("a", "")),
    "must be a function of x or a sympy Matrix": Coordinates(function=np.eye(2)),
    r"function, for the 2 rigid .* has shape \(1,\), must be \(2,\), at x = ": Coordinates(
        function=lambda x: x[:1]
    ),
    "raises IndexError": Coordinates(function=lambda x: x[np.array([0, 7])]),
    "2 joints: is complex, must be real": Coordinates(function=lambda x: x * 1j),
    r"jacobian: \[1, 0\], of theta_2 by x_1, is .* differences": Coordinates(
        function=curved, jacobian=lambda x: slopes(x) * [[1, 1], [-1, 1]]
    ),
    "jacobian: is singular": Coordinates(function=lambda x: np.array([x[0], x[0]])),
    "has 2 entries over 1 symbols; must be 2 over 2": Coordinates(function=SYMBOLIC, symbols=(A,)),
    "has 3 entries over 2 symbols": Coordinates(function=sp.Matrix([A, B, A]), symbols=(A, B)),
    "c: is not a quantity of the arm": Coordinates(
        function=SYMBOLIC * sp.Symbol("c"), symbols=(A, B)
    ),
}


@pytest.mark.parametrize("reason", BAD)
def test_bad_coordinates(reason):
    with pytest.raises(InputError, match=reason) as caught:
        build_frame(BAD[reason], PAPER)
    assert "\n" not in str(caught.value)


def test_each_map_is_for_its_number_of_joints():
    three = load_arm("three-unlike")
    for own in (Coordinates(matrix=np.eye(2)), MAPS["complex step"], MAPS["sympy"]):
        with pytest.raises(InputError, match="3 rigid coordinates of three-unlike, 3 joints"):
            build_frame(own, three)


def edge(x: np.ndarray) -> np.ndarray:
    return np.array([x[0] + 0.1 * abs(x[0]) ** 1.5, x[1]])


def test_what_has_no_second_derivative_is_refused_where_it_has_none():
    frame = build_frame(Coordinates(function=edge), PAPER)
    with pytest.raises(InputError, match="second derivative is not to be found at x = "):
        frame.drift(np.zeros(2), np.ones(2))
