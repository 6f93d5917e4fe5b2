"""Lines of derivations by SymPy: edits are judged by the differences that they make."""

import ast

import pytest
import sympy as sp
from sympy.core.cache import clear_cache

from crosscheck.cli.files.template import make_plain_arm
from crosscheck.models.arm.arm import Arm
from crosscheck.testing import try_equations
from crosscheck.trial.source.statements import select_statements
from tests.processes import command_line
from tests.robots import chains

VARIED = """
import sympy as sp
from sympy.physics.mechanics import Point, ReferenceFrame, dynamicsymbols

def make():
    a, b = dynamicsymbols("a b")
    t, g = sp.symbols("t g")
    N = ReferenceFrame("N")
    A = N.orientnew("A", "Axis", [a, N.z])
    m, square = 1.3, 0
    for angle, length in ((a, 0.7), (a + b, 0.4)):
        arm = length * sp.Matrix([sp.cos(angle), sp.sin(angle)])
        square += sum(each.diff(t) ** 2 for each in arm)
    lever = 0.3 * A.x + b * N.y
    V = m * g * lever.dot(N.y)
    origin, tip = Point("O"), Point("P")
    tip.set_pos(origin, 0.2 * A.x)
    origin.set_vel(N, 0.1 * b.diff(t) * N.y)
    tip.v2pt_theory(origin, N, A)
    L = m * square / 2 - V + m * tip.vel(N).dot(tip.vel(N))
    rates, angles = [a.diff(t), b.diff(t)], [a, b]
    rows = [L.diff(r).diff(t) - L.diff(c) for r, c in zip(rates, angles)]
    plain = sp.symbols("q0:6")
    numbers = dict(zip([a.diff(t, 2), b.diff(t, 2), *rates, *angles], plain))
    force = sp.lambdify([plain], [each.subs(numbers).subs(g, 9.81) for each in rows])
    return {"force": lambda q: force([*q, 0.3, -0.4, 1.1, -0.6])}
"""
# In a process of its own, whose SymPy is quickened for good.
COMPARED = """
import ast, sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
import numpy as np
from crosscheck.trial.source.edit import Edit
from crosscheck.trial.source.edits import list_edits
from crosscheck.trial.source.libraries import quicken_libraries
from crosscheck.trial.source import derivation, search as searches
from tests.trial.source.test_derivations import VARIED
from tests.trial.source.test_source_edits import make_answer_key, write_code

quicken_libraries()
searches.DERIVING_S = 0.0  # SymPy remembers what the answer key was derived by
derivation.LEAST_S = derivation.SCALING_S = derivation.RECORDING_S = 60.0  # also if it is slow
key = make_answer_key(VARIED)
search = searches.EditSearch(write_code(Path(sys.argv[1]), VARIED), [key])
compiler = search.compiler
nodes = {ast.unparse(each): each for each in search.tree.list_nodes()}

def compare(edited, node, text):
    try:
        anew = compiler.compile([Edit((0, 0), node, text)]).bind(key)("force", 0)
    except Exception:  # whatever an edit leads to
        return
    np.testing.assert_allclose(edited.bind_shared(key)("force", 0), anew, 1e-9, err_msg=text)

lines = Counter()
kept = len(VARIED[: VARIED.index("tip.v2pt")].splitlines())
edits = [*list_edits(search.tree, 2, lambda node: True)]
few = [*edits[::5], *(each for each in edits if each.node.lineno == kept)]
for edit, edited in compiler.compile_each(few):
    if edited and edited.shared is not None:
        edited.bind_shared(key)  # an edit of a later line is chosen
    elif edited and edited.varied and lines[edit.node.lineno] < 4:
        compare(edited, edit.node, edit.text)
        lines[edit.node.lineno] += 1
texts = {VARIED.splitlines()[line - 1].split()[0] for line in lines}
assert lines[kept]
assert texts >= {"arm", "square", "lever", "V", "L", "rows", "m,"}, texts

node = nodes["0.3 * A.x"].left
gap = compiler.compile_gaps(node, "{}", [0.3])
assert gap.varied
compare(replace(gap, chosen=[0.45]), node, "0.45")

node = nodes["m * g * lever.dot(N.y)"]
compare(compiler.scale_places()[id(node)], node, f"{1 + derivation.SHARE} * ({ast.unparse(node)})")
"""


def test_edits_of_a_derivation_answer_as_equations_that_are_derived_anew(tmp_path):
    """Of scalars, matrices and vectors, in a loop too; numbers to be chosen; places that scale."""
    assert command_line(python=("-c", COMPARED, str(tmp_path))).returncode == 0


LAGRANGE = """
import sympy as sp
from crosscheck.testing import from_sympy
from sympy.physics.mechanics import dynamicsymbols

def model():
    t = sp.Symbol("t")
    a1, a2 = dynamicsymbols("psi phi")
    m1, m2, l1, d1, d2, g = sp.symbols("m1 m2 l1 d1 d2 g")
    x2 = l1 * sp.cos(a1) + d2 * sp.cos(a1 + a2)
    y2 = l1 * sp.sin(a1) + d2 * sp.sin(a1 + a2)
    T1 = m1 * (d1 * a1.diff(t)) ** 2 / 2
    T2 = m2 * (x2.diff(t) ** 2 + y2.diff(t) ** 2) / 2
    V = g * m1 * d1 * sp.sin(a1) + g * m2 * y2
    L = T1 + T2 - V
    th, thd = sp.Matrix([a1, a2]), sp.Matrix([a1, a2]).diff(t)
    rows = [sp.expand(L.diff(r).diff(t) - L.diff(c)) for r, c in zip(thd, th)]
    M = sp.Matrix(rows).jacobian(thd.diff(t))
    rest = sp.Matrix(rows).subs(dict.fromkeys(thd.diff(t), 0))
    G = rest.subs(dict.fromkeys(thd, 0))
    q, v = sp.symbols("psi phi"), sp.symbols("v1 v2")
    plain = dict(zip([*thd, *th], [*v, *q]))
    M, C, G = (each.subs(plain) for each in (M, sp.expand(rest - G), G))
    values = {m1: "m1", m2: "m2", l1: "L1", d1: "d1", d2: "d2", g: 9.81}
    return from_sympy(q, v, mass_matrix=M, bias=C, gravity=G, values=values)
"""


def point_masses(joints: int) -> Arm:
    plain = make_plain_arm("tested", joints)
    points = tuple(link.model_copy(update={"inertia_kg_m2": 0.0}) for link in plain.links)
    return plain.model_copy(update={"payload_mass_kg": 0.0, "links": points})


@pytest.mark.parametrize(
    ("right", "wrong", "new", "is_split"),
    [("d2 * sp.cos", "d2 * sp.sin", "sp.cos", True), ("g * m2 * y2", "g * m2 * x2", "y2", False)],
)
def test_a_slip_before_the_energies_is_named(tmp_path, right, wrong, new, is_split):
    """is_split: whether V is a variable of its own, and the weights are no part of a force."""
    assert right in LAGRANGE
    text = LAGRANGE.replace(right, wrong, 1)
    if not is_split:
        potential = text[text.index("V = ") + 4 :].partition("\n")[0]
        text = text.replace(f"    V = {potential}\n", "\n").replace("- V", f"- ({potential})")
        text = text.replace("bias=C, gravity=G", "forcing=-C - G")
    file = tmp_path / "mine.py"
    file.write_text(text, encoding="utf-8")
    change = try_equations(f"{file}:model", point_masses(2)).change
    assert change.wrong == ()
    (edit,) = change.edits
    assert edit.line == text[: text.index(wrong) + len(wrong)].count("\n") + 1
    assert edit.new == new


ONE_JOINT = """
import sympy as sp
from crosscheck.testing import from_sympy

def model():
    q, v, m, d, g = sp.symbols("q v m d g")
    speed = d * v
    T = m * speed**2 / 2
    V = g * m * d * sp.sin(q)
    M, C, G = (sp.Matrix([each]) for each in (T.diff(v, 2), 0, V.diff(q)))
    values = {m: "m1", d: "d1", g: 9.81}
    return from_sympy([q], [v], mass_matrix=M, bias=C, gravity=G, values=values)
"""


@pytest.mark.parametrize(("argument", "new"), [("", ("1 - d", "d")), ("arm", ("d",))])
def test_an_energy_of_rates_alone_is_one(tmp_path, argument, new):
    """On an arm of another length, where equations take one, 1 - d is not d."""
    file = tmp_path / "mine.py"
    text = ONE_JOINT.replace("d * v", "(1 + d) * v").replace("model()", f"model({argument})")
    file.write_text(text, encoding="utf-8")
    (edit,) = try_equations(f"{file}:model", point_masses(1)).change.edits
    assert edit.start.strip() == "speed = ("
    assert edit.new in new


OF_ROBOT = f"""
import sympy as sp
from crosscheck import from_sympy

q, v, m, c, J, g = sp.symbols("q v m c J g")
T = (m * c**2 + J) * v**2 / 2
V = -g * m * c * sp.cos(q)
M, C, G = (sp.Matrix([each]) for each in (T.diff(v, 2), 0, V.diff(q)))
numbers = {{m: {chains.MASS}, c: {chains.LENGTH}, J: {chains.INERTIA}, g: 9.81}}
model = from_sympy([q], [v], mass_matrix=M, bias=C, gravity=G, values=numbers)
"""


@pytest.mark.parametrize(
    ("right", "wrong"),
    [(f"J: {chains.INERTIA}", "J: 0.047"), ("m * c**2 + J", "m * c + J"), ("g * m * c", "g * m")],
)
def test_the_energies_of_a_robot_and_the_numbers_behind_them_are_edited(tmp_path, right, wrong):
    file, text = tmp_path / "mine.py", OF_ROBOT.replace(right, wrong, 1)
    file.write_text(text, encoding="utf-8")
    (edit,) = try_equations(f"{file}:model", chains.robot(chains.BOB)).change.edits
    assert edit.line == text[: text.index(wrong)].count("\n") + 1


@pytest.mark.parametrize(
    ("statement", "is_selected"),
    [
        ("for part in parts:\n    part['S'] = 1", True),
        ("for part in parts:\n    print(part)", False),
        ("done = method.equations()", True),
        ("done = max(parts)", False),
    ],
)
def test_statements_are_selected_that_change_what_is_used(statement, is_selected):
    """Elements in a loop, and an object by a method whose result nobody uses."""
    body, names = ast.parse(statement).body, {"parts": [{}], "method": object()}
    assert bool(select_statements("mine.py", body, names, {"parts", "method"}, [])) == is_selected


QUICKENED = """
import sympy as sp
from crosscheck.trial.source.libraries import quicken_libraries

t, a, b = sp.symbols("t a b")
x, y = sp.Function("x")(t), sp.Function("y")(t)
s = a * sp.sin(x + y) ** 2 * (x.diff(t) + 3) + b * (y - x) * (x + 2) + a * b

def ask():
    rates = [(x.diff(t), b), (x, a), (y, a + b)]
    return [
        s.diff(t), s.diff(x), s.diff(a, 2), s.expand(), sp.expand(s, trig=True), s.subs(rates),
        s.subs(zip([a, b], [1, 2])), s.subs(a, b), s.subs({a: 0.5, b: x}), s.subs({a: 1, b: 2}),
        (a + b + x).subs(a + b, y), sp.Matrix([s, a]).subs(rates), sp.Matrix([s]).diff(x),
    ]

right = ask()
quicken_libraries()
for _ in range(2):
    assert all(one.equals(other) for one, other in zip(ask(), right, strict=True))
"""


def test_what_sympy_returns_stays_as_it_is():
    assert command_line(python=("-c", QUICKENED)).returncode == 0


def test_equal_symbols_are_what_a_statement_makes():
    """Also if they are objects of their own, which pickle tells from one that is there twice."""
    body, (x, y) = ast.parse("Q = [x - y, x - y]").body, sp.symbols("x y")
    first = x - y
    clear_cache()
    names = {"x": x, "y": y, "Q": [first, x - y]}
    assert select_statements("mine.py", body, names, {"Q"}, []) == body
    assert select_statements("mine.py", body, names | {"Q": [y - x, first]}, {"Q"}, []) == []


def test_a_force_beside_right_energies_is_edited(tmp_path):
    text = OF_ROBOT.replace(
        "model = from_sympy([q], [v], mass_matrix=M, bias=C, gravity=G, values=numbers)",
        'tau = sp.Symbol("tau")\nQ = [tau - tau**2 - G[0]]\n'
        "model = from_sympy([q], [v], mass_matrix=M, forcing=sp.Matrix(Q), torque=[tau],"
        " values=numbers)\nassert Q[0].is_real is None",
    )
    file = tmp_path / "mine.py"
    file.write_text(text, encoding="utf-8")
    (edit,) = try_equations(f"{file}:model", chains.robot(chains.BOB)).change.edits
    assert edit.line == text[: text.index("tau**2")].count("\n") + 1


LAMBDIFIED = """
import sympy as sp
from crosscheck import Equations

def derive(q, w):
    m1, m2, l1, d1, d2, g = sp.symbols("m1 m2 l1 d1 d2 g")
    square = (l1 * w[0]) ** 2 + (d2 * (w[0] + w[1])) ** 2
    square += 2 * l1 * d2 * w[0] * (w[0] + w[1]) * sp.cos(q[1])
    y2 = l1 * sp.sin(q[0]) + d2 * sp.sin(q[0] + q[1])
    T = m1 * (d1 * w[0]) ** 2 / 2 + m2 * square / 2
    V = g * (m1 * d1 * sp.sin(q[0]) + m2 * y2)
    return T, V

def model(arm):
    q, w = sp.Matrix(sp.symbols("q1:3")), sp.Matrix(sp.symbols("w1:3"))
    T, V = derive(q, w)
    a, b = arm.links
    numbers = dict(m1=a.mass, m2=b.mass, l1=a.length_m, d1=a.com_m, d2=b.com_m, g=9.81)
    p = sp.Matrix([T]).jacobian(w).T
    h = p.jacobian(q) * w - sp.Matrix([T]).jacobian(q).T
    parts = p.jacobian(w), h, sp.Matrix([V]).jacobian(q).T
    M, h, G = (sp.lambdify([q, w], each.subs(numbers)) for each in parts)
    return Equations(
        mass_matrix=lambda q: M(q, q), bias=lambda q, v: h(q, v).ravel(),
        gravity=lambda q: G(q, q).ravel(),
    )
"""


def test_a_slip_in_each_energy_behind_written_functions_is_named(tmp_path):
    """Numbers take the places of symbols by their names."""
    file, text = tmp_path / "mine.py", LAMBDIFIED.replace("d2 * sp.sin(", "d2 * sp.cos(", 1)
    text = text.replace("2 * l1 * d2", "2 * l1 * d1", 1)
    file.write_text(text, encoding="utf-8")
    change = try_equations(f"{file}:model", point_masses(2)).change
    assert [(each.new, each.line) for each in change.edits] == [("d2", 8), ("sp.sin", 9)]
    assert change.wrong == ()
