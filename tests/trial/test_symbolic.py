"""Equations from sympy."""

import numpy as np
import pytest
import sympy as sp

from crosscheck.analytic.derivation.symbols import parameter_values
from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.input.supplied import SuppliedEquations, bind_equations
from crosscheck.trial.input.symbolic import from_sympy, replace_symbols

ARM, PROBE = load_arm("paper-labelled"), load_arm("probe")
x, v = sp.symbols("x1 x2"), sp.symbols("v1 v2")
torque, t = sp.symbols("T1 T2"), sp.Symbol("t")
L1, L2, m_payload = sp.symbols("L1 L2 m_payload")
MASS = sp.Matrix([[m_payload * L1**2, L2 * sp.cos(x[1])], [L2 * sp.cos(x[1]), 1]])
BIAS = sp.Matrix([-L2 * sp.sin(x[1]) * v[1] ** 2, L1 * v[0] * v[1]])
FORCE = sp.Matrix([torque[0] - sp.Rational(3, 10) * v[0], torque[1] * sp.cos(t) + sp.sin(x[0])])
X, V, TORQUE = np.array([[0.3, -0.4], [1.0, 2.0], [30.0, 40.0]])


def on(equations: Equations, arm: Arm = ARM) -> SuppliedEquations:
    bound = equations.adapt_to_arm(arm)
    return bind_equations(bound, arm, build_frame(bound.coordinates, arm))


def assert_right(model: SuppliedEquations) -> None:
    lengths = [link.length_m for link in model.arm.links]
    cosine, sine = np.cos(X[1]), np.sin(X[1])
    mass = [[model.arm.payload_mass_kg * lengths[0] ** 2, lengths[1] * cosine]]
    np.testing.assert_allclose(model.mass_matrix(X), [*mass, [lengths[1] * cosine, 1]], rtol=1e-15)
    bias = [-lengths[1] * sine * 4, lengths[0] * 2]
    np.testing.assert_allclose(model.bias(X, V), bias, rtol=1e-15)
    force = [30 - 0.3, 40 * np.cos(0.5) + np.sin(0.3)]
    np.testing.assert_allclose(model.force(0.5, X, V, TORQUE), force, rtol=1e-15)


WAYS = {
    "apart": {"bias": BIAS, "force": FORCE},
    "coriolis": {"coriolis": sp.Matrix([[0, BIAS[0] / v[1]], [L1 * v[1], 0]]), "force": FORCE},
    "forcing": {"forcing": FORCE - BIAS},
    "lists": {"bias": list(BIAS), "force": [list(FORCE)]},
}


@pytest.mark.parametrize("way", WAYS)
def test_matrices(way):
    equations = from_sympy(x, v, mass_matrix=MASS, torque=torque, t=t, **WAYS[way])
    for arm in (ARM, PROBE):
        assert_right(on(equations, arm))
    assert on(equations).frame.names == ("x1", "x2")
    assert on(on(equations).equations, PROBE).mass_matrix(X)[0, 0] == 7.0


def test_a_forcing_that_is_no_polynomial_in_the_rates_is_split_by_their_sign():
    friction = sp.Matrix([sp.tanh(v[0]), sp.Abs(v[1]) * v[1]])
    own = on(from_sympy(x, v, forcing=FORCE - BIAS - friction, torque=torque, t=t))
    apart = on(from_sympy(x, v, bias=BIAS, force=FORCE - friction, torque=torque, t=t))
    np.testing.assert_allclose(own.bias(X, V), apart.bias(X, V), rtol=1e-14)
    force = (0.5, X, V, TORQUE)
    np.testing.assert_allclose(own.force(*force), apart.force(*force), rtol=1e-14)


def test_a_force_without_torques_is_of_its_time():
    own = on(from_sympy(x, v, force=[sp.cos(t), t * v[1]], t=t))
    assert own.force(0.5, X, V, TORQUE).tolist() == [np.cos(0.5), 0.5 * V[1]]


def test_dynamicsymbols():
    import sympy.physics.mechanics as me  # slow to import, in every process that collects tests

    q, T = me.dynamicsymbols("q1 q2"), me.dynamicsymbols("T1 T2")
    moving = {**dict(zip(x, q, strict=True)), **dict(zip(torque, T, strict=True))}
    derivatives, speeds = [own.diff() for own in q], me.dynamicsymbols("u1 u2")
    for rates, used in ((derivatives, derivatives), (speeds, speeds), (speeds, derivatives)):
        swap = moving | dict(zip(v, used, strict=True)) | {t: me.dynamicsymbols._t}
        mass, bias, force = (part.subs(swap) for part in (MASS, BIAS, FORCE))
        equations = from_sympy(q, rates, mass_matrix=mass, bias=bias, force=force, torque=T)
        assert_right(on(equations))
        assert on(equations).frame.names == ("q1", "q2")


def test_values_by_name_and_by_number():
    a, b = sp.symbols("a b")
    mass = sp.diag(a, b + L1)
    named = from_sympy(x, v, mass_matrix=mass, values={a: "m_payload", "b": "L2"})
    assert on(named, PROBE).mass_matrix(X).tolist() == [[7.0, 0.0], [0.0, 1.7]]
    assert named.adapt_to_arm(ARM).any_arm
    fixed = from_sympy(x, v, mass_matrix=mass, values={a: 0.1, b: "L2"})
    assert on(fixed).mass_matrix(X)[0, 0] == 0.1
    assert not fixed.adapt_to_arm(ARM).any_arm
    for matrix, known in ((np.eye(2), True), (np.eye(2) / 2, False)):
        mapped = from_sympy(x, v, mass_matrix=MASS, coordinates=Coordinates(matrix=matrix))
        assert mapped.adapt_to_arm(ARM).any_arm == known
    for share, known in ((sp.Rational(1, 2), True), (0.5, False)):
        curved = Coordinates(function=sp.Matrix([x[0], share * x[1]]))
        mapped = from_sympy(x, v, mass_matrix=MASS, coordinates=curved)
        assert mapped.adapt_to_arm(ARM).any_arm == known
    floats = from_sympy(x, v, mass_matrix=sp.diag(0.5, L1))
    assert not floats.adapt_to_arm(ARM).any_arm


def test_in_the_symbols_of_an_arm():
    symbolic = from_sympy(x, v, mass_matrix=MASS, values={L1: 0.25}).adapt_to_arm(ARM).symbolic
    found = replace_symbols(symbolic, ARM)
    assert found.mass_matrix.free_symbols - set(x) <= set(parameter_values(ARM))
    assert found.mass_matrix[0, 0].coeff(next(iter(found.mass_matrix[0, 0].free_symbols))) == (
        sp.Rational(1, 16)
    )
    assert found.values == {}


def test_a_constant_matrix_and_level_pass_through():
    equations = from_sympy(
        *(x, v),
        mass_matrix=sp.eye(2),
        level="links",
        coordinates=Coordinates(links="absolute", names=("first", "second")),
    )
    bound = on(equations)
    assert bound.equations.level == "links"
    assert bound.equations.coordinates.links == "absolute"
    assert bound.frame.names == ("first", "second")
    assert bound.mass_matrix(X).tolist() == [[1, 0], [0, 1]]


g, M3 = sp.Symbol("g"), sp.Symbol("l_1")
BAD = {
    "l_1: is not a quantity of the arm; give its value, or its name (near it: L1)": {
        "mass_matrix": sp.eye(2) * M3
    },
    "J1: is not a quantity of the arm; give its value, or its name (near it: I_l1": {
        "mass_matrix": sp.eye(2) * sp.Symbol("J1")
    },
    "Theta_2: is not a quantity of the arm; give its value, or its name (near it: I_l2": {
        "mass_matrix": sp.eye(2) * sp.Symbol("Theta_2")
    },
    "g: is not a quantity of the arm; give its value, or its name (near it: g_x, g_y": {
        "mass_matrix": sp.eye(2) * g
    },
    "g = 'gravity': is not a quantity": {"mass_matrix": sp.eye(2) * g, "values": {g: "gravity"}},
    "g: must be a number, or the name": {"mass_matrix": sp.eye(2) * g, "values": {g: None}},
    "mass_matrix: has v1; must be of x alone": {"mass_matrix": sp.eye(2) * v[0]},
    "bias: has T1, T2; must be of x and v alone": {"bias": sp.Matrix(torque), "torque": torque},
    "bias: has shape (3, 1), must be (2, 1)": {"bias": sp.ones(3, 1)},
    "mass_matrix: has shape (1, 2), must be (2, 2)": {"mass_matrix": sp.ones(1, 2)},
    "mass_matrix: is not a sympy Matrix": {"mass_matrix": object()},
    "forcing: give either bias or forcing": {"forcing": FORCE, "bias": BIAS},
    "coriolis: give either bias or coriolis": {"coriolis": sp.eye(2), "bias": BIAS},
    "Derivative(w(t), t), w(t): depend on time": {
        "mass_matrix": sp.eye(2) * sp.Function("w")(t) * sp.Function("w")(t).diff(t)
    },
}


@pytest.mark.parametrize("reason", BAD)
def test_bad_symbols(reason):
    with pytest.raises(InputError) as caught:
        from_sympy(x, v, **BAD[reason]).adapt_to_arm(ARM)
    assert reason in str(caught.value)


def test_coordinates_and_rates_are_as_many_and_unlike():
    for rates in (v[:1], (x[0], v[1]), (v[0], 3)):
        with pytest.raises(InputError, match="symbols"):
            from_sympy(x, rates, mass_matrix=MASS)


def test_names_that_a_trial_prints_are_names():
    """Friction and gravity have no symbols in the derivation, but stand in a trial's terms."""
    c2, g_y, z_s1 = sp.symbols("c2 g_y z_s1")
    force = sp.Matrix([g_y * sp.cos(x[0]), torque[1] - c2 * v[1] * z_s1])
    equations = from_sympy(x, v, force=force, torque=torque)
    for arm in (ARM, PROBE):
        (_, gravity), elbow = arm.gravity_m_per_s2, arm.joints[1]
        found = on(equations, arm).force(0.0, X, V, TORQUE)
        friction = elbow.friction_N_m_s_per_rad * V[1] * arm.joints[0].sun_teeth
        np.testing.assert_allclose(found, [gravity * np.cos(X[0]), 40 - friction], rtol=1e-14)
