"""Which edit of a source a search finds: one of every kind, two together, or none."""

import ast
import re
import sys
import textwrap
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from crosscheck.runner.progress_update import ignore_progress
from crosscheck.trial.input.loading import find_named_code, import_object
from crosscheck.trial.source.answer_key import AnswerKey, LevelAnswers
from crosscheck.trial.source.code import MODULE, UserCode
from crosscheck.trial.source.libraries import cross_vectors
from crosscheck.trial.source.search import EditSearch
from crosscheck.trial.source.source_edit import SourceAnswer
from crosscheck.trial.source.syntax import SourceTree
from crosscheck.trial.source.worker import find_source_answer

CODE = """
import numpy as np

class Body:
    def __init__(self, mass, lever):
        self.mass, self.lever = mass, lever

R = np.array([[0.6, -0.8, 0.0], [0.64, 0.48, -0.6], [0.48, 0.36, 0.8]])

def make():
    a, b = bodies = Body(1.3, 0.7), Body(2.9, 0.45)
    c1, c2, s = 0.31, 0.83, 1.7

    def weights(q):
        first = a.mass * (c1 + b.lever) * np.cos(q[0]) + s * q[1] + c2
        second = b.mass * c2**2 - 2 * c1 * np.sin(q[0] + q[1])
        return np.array([first + 0.25 * second, second])

    def moment(q):
        w, p, total = np.array([q[0], q[1], 0.4]), np.array([c1, c2, s]), np.zeros(3)
        for i in range(3):
            total = total + w * p[i] + np.cross(p, w)
            p = np.cross(w, p) + R.T @ w
        return total

    def spin(q):
        w, levers = np.array([q[0], q[1], 0.4]), np.zeros((3, 3))
        for i in range(3):
            levers[: i + 1, i] = w[i] if i <= 2 else 0.0
        inertia = R @ np.diag([1.3, 2.1, 0.7]) @ R.T
        torque = inertia @ levers[0] + np.cross(w, inertia @ w)
        k, n = [each for each in (0.37, 1.9)]
        scale = k * n**2 + 2 * q[0]
        return scale * levers @ w, torque

    def turn(a):
        return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])

    def sweep(q):
        rate, lever = np.array([q[0], q[1], 0.4]), np.array([c1, c2, s])
        speed = lever + turn(rate) @ lever
        pairs, turns, kept = [[R, lever - rate], [R.T, rate]], [R, R.T, R @ R], 2
        for i in range(2):
            speed = speed + R @ turn(rate) @ lever + R @ turn(speed) @ rate
            speed = pairs[i][0] @ speed + turn(rate) @ (speed - pairs[i][1])
        return turns[kept] @ turn(speed) @ rate

    def lift(q):
        ends = [np.array([0.0, 0.3, c1]), np.array([q[0], c2, q[1]])]
        spread = np.diag([1.3, 2.1, 0.7]) + R + c2 * np.outer(ends[0], ends[0])
        arm = np.cross(ends[1] - ends[0], np.array([0.4, 1.7, -1.2]))
        return np.einsum("ij,j->i", spread, arm) + spread[1, 1] * arm

    def inertia(q):
        total, middle = a.mass * 0.3 + c2, a.lever * c2
        return [a.mass + b.mass * (b.lever - middle) ** 2, total * q[0]]

    def order(q):
        n, turns = 3, np.array([[q[0], c1, s], [c2, q[1], 0.6], [0.2, s, q[0]]])
        carried, shares = np.array([0.3, -0.7, c1]), np.zeros(3)
        tensor = np.arange(27.0).reshape(3, 3, 3)
        for i in range(n):
            carried = turns @ carried
            carried = carried + c1
            scaled = carried * q[0]
            shares[i] = scaled[2] if i == 0 else carried[i]
            carried = np.cross(scaled, carried) + scaled
        for i in reversed(range(n)):
            for j in range(i):
                shares[i] = shares[i] + c2 * shares[j] ** 2
        bonus = c1 * np.sin(q[1])
        ratio = n / 2
        return shares + bonus + ratio * tensor[0, 1, 2]

    def push(q):
        pull, held = [q[0], c2, q[1] ** 2], np.zeros(3)
        spun, lever = np.array([q[0], q[1], 0.4]), np.array([c1, c2, s])
        held[1:] = lever[1:] * (spun[0] * s) ** 2
        moments = [bodies[i].mass * bodies[i].lever for i in range(2)]
        for i in range(3):
            held[i] += pull[i] - (pull[i + 1] if i < 2 else 0.0)
        return moments[1] * held + np.cross(lever, held) + np.cross(spun, np.cross(spun, lever))

    def undo(matrix):
        return np.linalg.inv(matrix)

    def mate(q):
        frames = [[R + q[0] * np.eye(3), c1], [R - q[1] * np.eye(3), c2]]
        pull, back, last = np.array([q[0], c2, q[1]]), np.array([c1, q[1], s]), 1
        total = np.zeros(3)
        for i in range(2):
            total += c1 * pull
            total += q[0] * back
            held = frames[i][0] @ pull
        turned = np.dot(undo(frames[0][0] @ R), pull)
        held += np.hypot(c2, s) * R.T @ (R @ back + turn(back) @ R @ back)
        return held + total * turned + frames[last][0] @ back

    parts = weights, moment, spin, sweep, lift, inertia, order, push, mate
    return {each.__name__: each for each in parts}
"""
PARTS = "weights", "moment", "spin", "sweep", "lift", "inertia", "order", "push", "mate"
STATES = ([0.4, -1.1], [-0.7, 0.9], [1.9, 0.3])


def select_parts(*names: str) -> str:
    """The code with these functions and what they call; a search of all takes four times as long.

    Lines of the file are those of the whole code: what is left out is empty lines.
    """
    text, listed = CODE, ", ".join(names)
    for name in {*PARTS} - {*names}:
        found = re.search(rf"    def {name}\(.*?(?=    def |    parts =)", text, re.DOTALL)
        assert found
        text = text.replace(found[0], "\n" * found[0].count("\n"))
    return text.replace(", ".join(PARTS), f"{listed},")


def indent(lines: str, by: int) -> str:
    return textwrap.indent(lines, by * " ") + "\n"


def find_part(piece: str) -> str:
    """The function that the first such piece of the code stands in."""
    return max(PARTS, key=lambda name: CODE.rfind(f"    def {name}(", 0, CODE.index(piece)))


def write_code(folder: Path, text: str, *replaced: tuple[str, str]) -> UserCode:
    """The code of a file with pieces of its text replaced."""
    for right, wrong in replaced:
        assert right in text
        text = text.replace(right, wrong, 1)
    file = folder / "mine.py"
    file.write_text(text, encoding="utf-8")
    import_object(f"{file}:make")
    return find_named_code(f"{file}:make")


def make_answer_key(text: str, states: Sequence[Sequence[float]] = STATES) -> AnswerKey:
    """What right code answers at states, which take a mechanism's place."""
    names: dict = {}
    exec(text, names)

    shapes = {}

    def bind(source):
        functions = source()

        def answer(part, state):
            values = np.asarray(functions[part](list(states[state])))
            assert values.shape == shapes.setdefault(part, values.shape)
            return values

        return answer

    answer = bind(names["make"])
    right = {part: np.array([answer(part, k) for k in range(3)]) for part in names["make"]()}
    allowed = dict.fromkeys(right, np.array(1e-9))
    return AnswerKey(bind, {"": LevelAnswers(right, allowed)}, ("x", "y", "z"))


def search(
    folder: Path, text: str, *replaced: tuple[str, str], keys: Sequence[AnswerKey] = ()
) -> SourceAnswer | None:
    """The answer to mistakes in a text, by right answers of its own or by others."""
    code = write_code(folder, text, *replaced)
    return find_source_answer(code, lambda: keys or [make_answer_key(text)], ignore_progress).answer


def find_answer(
    folder: Path, *replaced: tuple[str, str], beside: Sequence[str] = ("weights",)
) -> SourceAnswer | None:
    """The answer to mistakes in the functions that they stand in, beside right ones."""
    text = select_parts(*dict.fromkeys([*beside, *(find_part(right) for right, _ in replaced)]))
    return search(folder, text, *replaced)


EDITS = tomllib.loads(Path(__file__).with_name("edits.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("right", "wrong", "rank"), EDITS["edits"])
def test_an_edit_of_every_kind_is_found(tmp_path, right, wrong, rank):
    # What is missing is written as a like term of another function is.
    beside = ("weights", "moment") if rank == 5 else ("weights",)
    answer = find_answer(tmp_path, (right, wrong), beside=beside)
    if not rank:  # the text differs, the values do not
        assert answer is None
        return
    assert answer.wrong == ()
    line = CODE[: CODE.index(right) + len(right)].rstrip().count("\n") + 1
    assert line in [each.line for each in (*answer.edits, *answer.alternatives)]
    assert answer.edits[0].rank <= rank
    assert not answer.is_unequal  # judged on one mechanism


def test_a_statement_like_another_one_that_was_forgotten_is_added(tmp_path):
    answer = find_answer(tmp_path, ("            total += q[0] * back\n", ""), beside=())
    assert answer is not None
    assert [each.remedy for each in answer.edits] == [
        "total += q[0] * back should follow total += c1 * pull"
    ]


def test_a_statement_that_was_forgotten_is_added(tmp_path):
    answer = find_answer(tmp_path, ("total = total + w * p[i]", "u = w * p[i]"))
    assert answer.edits[0].new == "total += u"
    assert answer.edits[0].remedy == "total += u should follow u = w * p[i] + np.cross(p, w)"


TURN = "p = np.cross(w, p) + R.T @ w"
SUM = "total = total + w * p[i] + np.cross(p, w)"
CARRY, SCALE = "carried = turns @ carried\ncarried = carried + c1", "scaled = carried * q[0]"
MOVED = {
    "return total should stand after the loop of line 21": (
        indent(TURN, 12) + indent("return total", 8),
        indent(TURN, 12) + indent("return total", 12),
    ),
    f"{TURN} should stand in the loop of line 21": (indent(TURN, 12), indent(TURN, 8)),
    f"{SUM} should stand before {TURN}": (
        indent(f"{SUM}\n{TURN}", 12),
        indent(f"{TURN}\n{SUM}", 12),
    ),
    f"{SCALE} should stand after carried = carried + c1": (
        indent(f"{CARRY}\n{SCALE}", 12),
        indent(f"{SCALE}\n{CARRY}", 12),
    ),
}


@pytest.mark.parametrize("remedy", MOVED)
def test_a_statement_at_a_wrong_place_is_moved(tmp_path, remedy):
    right, wrong = MOVED[remedy]
    answer = find_answer(tmp_path, (right, wrong))
    assert answer.wrong == ()
    (edit, *_) = answer.edits
    assert edit.remedy == remedy
    text = (tmp_path / "mine.py").read_text(encoding="utf-8")
    assert text.count(edit.removed) == 1
    assert text.replace(edit.removed, edit.added) == select_parts("weights", find_part(right))


def test_a_quick_cross_product_has_the_bits_of_a_slow_one():
    draw = np.random.default_rng(3)
    for _ in range(200):
        a, b = draw.normal(size=(2, 3)) * 10.0 ** draw.integers(-9, 9, (2, 1))
        assert np.array_equal(cross_vectors(a, b), np.cross(a, b))
    for left, right in ((np.eye(3), b), ([1, 0, 0], [0, 1, 0]), (a + 1j, b)):
        quick, slow = cross_vectors(left, right), np.cross(left, right)
        assert quick.dtype == slow.dtype
        assert np.array_equal(quick, slow)


def test_a_lost_summand_is_named_behind_the_formula_as_that_is_written(tmp_path):
    lost = "a.mass*(c1 + b.lever)*np.cos(q[0]) + s*q[1]"
    answer = find_answer(tmp_path, ("a.mass * (c1 + b.lever) * np.cos(q[0]) + s * q[1] + c2", lost))
    assert answer is not None
    assert [each.remedy for each in answer.edits] == [f"+ c2 should follow {lost}"]


def test_the_sign_of_a_long_formulas_last_summand_is_named_alone(tmp_path):
    (edit,) = find_answer(tmp_path, ("s * q[1] + c2", "s * q[1] - c2")).edits
    assert (edit.remedy, edit.removed, edit.added) == ("- c2 should be + c2", "-", "+")
    assert f"{edit.start}{edit.added}{edit.end}" == CODE.splitlines()[edit.line - 1]


OBJECTS = """
import numpy as np

class Frame:
    def __init__(self, p):
        self.p = p

def make():
    row = [1.3, 0.2, -0.4, 2.1, 0.3, 0.9]

    def turn(q):
        xx, xy, xz, yy, yz, zz = row
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ np.array([q[0], q[1], 0.7])

    def pull(q):
        frames, total = [Frame(q[0]), Frame(q[1])], 0.0
        for i, f in enumerate(frames):
            for j in range(2):
                first = max(j, i)
                total += (first + 1) * f.p ** 2 * frames[j].p * row[j]
        return [total]

    def map(q):
        W, H = np.array([[0.0, q[0], 0.3], [0.0, 0.0, q[1]], [0.0, 0.0, 0.0]]), np.zeros((3, 3))
        L = np.eye(3) + W + W @ W
        H[1:3, 1:3] += q[0] * q[1]
        return H + L

    def sum(q):
        sizes = [len(j) for j in ([1.0], [2.0, 3.0])]
        total = np.array([[2.1, 0.7], [0.7, 1.3]]) @ np.array(q)
        for j in range(2):
            for k in range(j + 1):
                total[j] += sizes[j] * q[k] ** 2
        return total

    def drive(q):
        torques = []
        for i in range(3):
            scale = 1.7 if i < 2 else 2.3
            force, moment = np.array([q[0], 2.1 * i]), np.array([q[1], i * q[0]])
            torques.append(np.array([scale, q[1]]) @ (moment if i < 2 else force))
        return torques

    def reduce(q):
        H, c = np.diag([2.1, 1.3, 0.7]) + q[0], np.array([q[1], 0.4, q[0]])
        base, side = np.linalg.inv(H[:2, :2]), H[:2, 2:]
        reduced = H[2:, 2:] - side.T @ base @ side
        bias = c[2:] - side.T @ base @ c[:2]
        return reduced @ bias * (c[:2] @ c[:2])

    def weigh(q):
        load, ends = 1.9, [0.3, q[0], 0.8]
        bodies = [(k, row[k], ends[k]) for k in range(2)]
        bodies.append((len(bodies) - 1, load, ends[-1]))
        return [np.sum([mass * end * ends[k] for k, mass, end in bodies])]

    def lean(r):
        return 2.1 * r

    def tilt(r):
        return r[::-1]

    def rub(q):
        first, other, place = 0.8, 1.9, np.array([q[0], 0.7])
        held = place - np.array([first * q[0], other * q[1]])
        return lean(held)

    def join(q):
        VA, VB = np.array([q[0], 1.2]), np.array([0.4, q[1]])
        AA, AB, ma, mb = np.array([1.7, q[0]]), np.array([q[1], 0.7]), 2.3, 0.9
        return [VA @ (ma * AA) + VB @ (mb * AB)]

    parts = turn, pull, map, sum, drive, reduce, weigh, rub, join
    return {each.__name__: each for each in parts}
"""


@pytest.mark.parametrize(("right", "wrong"), EDITS["objects"])
def test_orders_of_inertias_larger_indices_and_other_objects_are_found(tmp_path, right, wrong):
    answer = search(tmp_path, OBJECTS, (right, wrong))
    assert answer.is_whole
    written = [each.new.replace(" ", "") for each in (*answer.edits, *answer.alternatives)]
    right = right.removeprefix("return").replace(" ", "")
    assert any(right in each for each in written), written


def test_a_value_that_a_line_has_twice_is_named_with_its_key(tmp_path):
    text = """
def make():
    a, b = 1.3, 0.7
    def lift(q):
        lever = {
            "one": a, "two": b,
        }
        return [lever["one"] * q[0] + lever["two"] * q[1]]
    return {"lift": lift}
"""
    (edit,) = search(tmp_path, text, ('"two": b', '"two": a')).edits
    assert (edit.line, edit.remedy) == (6, "'two': a should be 'two': b")


def test_an_element_beside_one_that_is_0_may_be_0(tmp_path):
    """Also where a function has an array without dimensions, which has no length."""
    text = """
import numpy as np
def make():
    a, b = 1.3, 0.7
    def push(q):
        now = np.array(0.9)
        return [0.0, 0.0, a * q[0] - b * q[1] ** 2]
    return {"push": push}
"""
    (edit,) = search(tmp_path, text, ("0.0, 0.0", "0.0, b * q[1] + a * q[0]")).edits
    assert edit.remedy == "b * q[1] + a * q[0] should be 0"


def test_an_attribute_of_a_class_that_nothing_reads_is_tried(tmp_path):
    text = """
def make():
    class Arm:
        a, b = 1.3, 0.7
        def push(self, q):
            return [self.a * q[0], self.b * q[1]]
    return {"push": Arm().push}
"""
    (edit,) = search(tmp_path, text, ("self.b", "self.a")).edits
    assert edit.remedy == "self.a * q[1] should be self.b * q[1]"


def test_the_derivative_by_coordinates_that_lagrange_needs_is_found(tmp_path):
    text = """
import sympy as sp

def make():
    q, w = sp.symbols("x:2"), sp.symbols("v:2")
    T = w[0] ** 2 * sp.cos(q[1]) + w[1] ** 2 * (2 + sp.sin(q[0]))
    forces = []
    for i in range(2):
        p = sp.diff(T, w[i])
        rate = sum(sp.diff(p, q[k]) * w[k] for k in range(2))
        forces.append(rate - sp.diff(T, q[i]))
    evaluate = sp.lambdify((q, w), forces)
    return {"bias": lambda x: evaluate(x[:2], [0.3, x[1]])}
"""
    (edit,) = search(tmp_path, text, (" - sp.diff(T, q[i])", "")).edits
    assert edit.remedy.startswith("- sp.diff(T, q[i]) should follow ")


def test_two_errors_are_one_answer(tmp_path):
    answer = find_answer(tmp_path, ("- 2 * c1", "+ 2 * c1"), ("R.T @ w", "R @ w"))
    assert [each.line for each in answer.edits] == [16, 23]
    assert answer.wrong == ()
    (sentence, *_) = answer.sentences
    assert sentence.count("should be") == 2
    assert sentence.endswith("all parts agree")


def test_of_two_errors_each_edit_that_says_the_same_is_offered(tmp_path):
    """Where the link is twice as long as its centre is far, a factor would do as well."""
    text = """
def make():
    lc2, L2, k = 0.375, 0.75, 1.3
    def lift(q):
        return [k * lc2 * q[0]]
    def pull(q):
        return [k + L2 * q[1]]
    return {"lift": lift, "pull": pull}
"""
    answer = search(tmp_path, text, ("+ L2", "+ lc2"), ("k * lc2 * q[0]", "k * lc2 * q[1]"))
    assert [each.remedy for each in answer.edits] == ["q[1] should be q[0]", "lc2 should be L2"]
    assert "lc2 * q[1] should be 2 * lc2 * q[1]" in [each.remedy for each in answer.alternatives]


@pytest.mark.parametrize(
    ("right", "wrong", "remedy"),
    [
        ("(2*p/h)**2", "(p/h)**2", "p/h should be 2*p/h"),
        ("-b*q[1]", "b*q[1]", "b*q[1] should be -b*q[1]"),
        ("k*q[0] + 2.5e-1*b", "b*q[0] + 2.5e-1*b", "b*q[0] should be k*q[0]"),
    ],
)
def test_a_formula_is_doubted_before_the_numbers_in_it(tmp_path, right, wrong, remedy):
    """And what should stand there is written as the file is."""
    text = """
p, h, b, k = 3.1, 0.01, 0.5, 1.3

def make():
    def lift(q):
        return [(2*p/h)**2*q[0], k*q[0] + 2.5e-1*b]
    def pull(q):
        return [k*q[0], -b*q[1]]
    return {"lift": lift, "pull": pull}
"""
    answer = search(tmp_path, text, (right, wrong))
    assert [each.remedy for each in answer.edits] == [remedy]


@pytest.mark.parametrize(
    ("right", "wrong", "remedy"),
    [
        ("0.8, 0.025", "0.8, 0.014", "0.014 should be 0.025"),
        ("I + 0.15**2", "I + 0.05**2", "0.05 should be 0.15"),
        ("I + 0.15**2", "I", ""),
    ],
)
def test_a_number_copied_from_the_file_is_mistaken_for_another_of_it(
    tmp_path, right, wrong, remedy
):
    """Else the file's number for I would make up for what is lost; a square takes short steps."""
    text = """
I, J = 0.8, 0.025

def make():
    def mass_matrix(q):
        return [[I + 0.15**2, 0], [0, J]]
    return {"mass_matrix": mass_matrix}
"""
    key = replace(make_answer_key(text), numbers=frozenset((0.8, -0.025, 0.014)))
    answer = search(tmp_path, text, (right, wrong), keys=[key])
    assert [each.remedy for each in (answer.edits if answer else ())] == [remedy] * bool(remedy)


@pytest.mark.parametrize(
    ("right", "wrong"), [("d[i][j, k]", "d[k][j, i]"), ("-(g + q[1]**2) / 2", "-(g + q[1]**2)")]
)
def test_exchanged_indices_and_half_of_a_sum_are_edits(tmp_path, right, wrong):
    text = """
import numpy as np

def make():
    d, g = [np.array([[0.3, 1.2], [0.8, -0.5]]), np.array([[1.1, 0.4], [-0.6, 0.9]])], 1.3
    def lift(q):
        return [sum(d[i][j, k] * q[k] for i in range(2) for k in range(2)) for j in range(2)]
    def pull(q):
        return [g * q[0], -(g + q[1]**2) / 2]
    return {"lift": lift, "pull": pull}
"""
    (edit,) = search(tmp_path, text, (right, wrong)).edits
    assert edit.new.replace(" ", "") in (right.replace(" ", ""), right[1:].replace(" ", ""))


def test_an_edit_that_changes_the_sign_of_a_square_is_not_offered(tmp_path):
    text = """
def make():
    h, L, k, a = 0.35, 1.6, 1.3, 0.12
    def turn(q):
        r = h + L * q[0] - a * q[1]
        return [r**2]
    def pull(q):
        return [k * q[1]]
    return {"turn": turn, "pull": pull}
"""
    answer = search(tmp_path, text, ("- a", "+ a"), ("[k *", "[-k *"))
    assert len(answer.edits) == 2
    assert not answer.alternatives


def test_an_error_that_another_one_hides_is_found_once_that_is_mended(tmp_path):
    """Of two in weights, the second mends no entry as long as the first is there."""
    answer = find_answer(tmp_path, ("- 2 * c1", "+ 2 * c1"), ("s * q[1]", "s * q[0]"))
    assert [each.line for each in answer.edits] == [15, 16]
    assert answer.wrong == ()


def test_an_error_beside_one_that_no_edit_mends_is_named(tmp_path):
    """A number is solved for by its part alone."""
    number, beside = ("[1.3, 2.1, 0.7]", "[1.3, 2.6, 0.7]"), ("w * p[i]", "w**3 * np.exp(p[i] + s)")
    answer = find_answer(tmp_path, number, beside)
    assert [each.line for each in answer.edits] == [30]
    assert {entry.partition("[")[0] for entry in answer.wrong} == {"moment"}
    assert "wrong" in next(iter(answer.sentences))


@pytest.mark.parametrize(
    ("wrong", "seconds", "end"),
    [
        ((), 15.0, None),
        ([("w * p[i]", "w**3 * np.exp(p[i] + s)")], 15.0, ""),
        ([("w * p[i]", "w**3 * np.exp(p[i] + s)")], 0.0, "; time ran out before all were tried"),
    ],
    ids=["right", "vain", "late"],
)
def test_a_search_in_vain_says_where_and_how_far(tmp_path, monkeypatch, wrong, seconds, end):
    monkeypatch.setattr("crosscheck.trial.source.search.BUDGET_S", seconds)
    text = select_parts("moment")
    code = write_code(tmp_path, text, *wrong)
    found = find_source_answer(code, lambda: [make_answer_key(text)], ignore_progress)
    words = "no single change nor pair of changes that was tried makes all parts right"
    lines = f"mine.py:2-{len(text.splitlines())}"
    assert [*found.sentences] == ([] if end is None else [f"{lines}: {words}{end}"])


def test_the_sentence_quotes_the_line(tmp_path):
    answer = find_answer(tmp_path, ("(c1 + b.lever) * np.cos(q[0])", "c1 + b.lever * np.cos(q[0])"))
    (edit,) = answer.edits
    line = edit.start + edit.removed + edit.end
    assert line == (tmp_path / "mine.py").read_text(encoding="utf-8").splitlines()[edit.line - 1]
    body = SimpleNamespace(mass=1.3, lever=0.6)
    names = {"a": body, "b": body, "c1": 0.3, "c2": 0.9, "s": 1.7, "q": [0.2, 0.4], "np": np}
    mended, right = edit.start + edit.added + edit.end, CODE.splitlines()[edit.line - 1]
    values = [eval(each.partition("=")[2], names) for each in (mended, right)]
    assert values[0] == pytest.approx(values[1])


MATRICES = """
import numpy as np

def make():
    A = np.array([[0.6, -0.8, 0.1], [0.7, 0.4, -0.6], [0.5, 0.3, 0.9]])
    B, C = A * A + 0.3, np.array([[1.1, 0.2, 0.0], [0.2, 0.7, 0.4], [0.3, 0.4, 1.9]])
    lever, e = [0.3, -0.7, 0.2], 0.41
    d = 1.7 * e + e * e

    def chain(q):
        w, u = np.array([q[0], q[1], 0.4]), np.array([0.9, q[1], q[0]])
        c, s = np.cos(q[0]), np.sin(q[1])
        spun = A @ B @ C @ w + np.cross(u, lever) + np.cross(u, w)
        turned = np.array([[c, 2.0, s], [0.0, c, 1.0], [s, 0.3, c]]) @ u
        placed = np.tril(B) @ np.array([e, 0.0, d]) * c
        return spun + turned + placed + np.einsum("ij,j->i", A, w) + np.einsum("ij,j->i", A, u)

    return {"chain": chain}
"""


@pytest.mark.parametrize(("right", "wrong"), EDITS["matrices"])
def test_edits_of_matrices_and_vectors_are_found(tmp_path, right, wrong):
    answer = search(tmp_path, MATRICES, (right, wrong))
    assert answer.is_whole
    assert answer.edits[0].line == MATRICES[: MATRICES.index(right)].count("\n") + 1


def test_no_product_of_a_vector_by_itself_stands_for_nothing(tmp_path):
    answer = search(tmp_path, MATRICES, ("np.cross(u, w)", "np.cross(u, w) + np.cross(u, w)"))
    assert answer.is_whole
    written = [each.new for each in (*answer.edits, *answer.alternatives)]
    assert not any(re.search(r"cross\((\w+), \1\)", each) for each in written), written


OF_FILE = "1.93 should be 1.7, as in the file, or the file's 1.7 should be 1.93"
OTHER_SIGN = "-1.7 should be 1.7, as in the file, or the file's 1.7 should be -1.7"


@pytest.mark.parametrize(
    ("stated", "wrong", "remedy"),
    [
        ((), "1.7 * e", "1.7 should be 2.11"),
        ((1.7,), "1.7 * e", "1.7 * e should be 1.7 * e + e ** 2"),
        ((1.93,), "1.93 * e + e * e", "1.93 should be 1.7"),
        ((1.7,), "1.93 * e + e * e", OF_FILE),
        ((1.7,), "-1.7 * e + e * e", OTHER_SIGN),
        ((1.7, -1.7), "-1.7 * e + e * e", "-1.7 should be 1.7"),
    ],
)
def test_numbers_of_the_file_are_solved_for_where_nothing_else_mends(
    tmp_path, stated, wrong, remedy
):
    """Else another number would make up for a term that is lost; the file's are said to be its."""
    key = replace(make_answer_key(MATRICES), numbers=frozenset(stated))
    answer = search(tmp_path, MATRICES, ("1.7 * e + e * e", wrong), keys=[key])
    assert answer.edits[0].remedy == remedy


@pytest.mark.parametrize("stated", [(1.1, 0.2, 0.7, 0.4, 0.3), (1.1, 0.2, 0.7, 0.4, 0.3, 1.9)])
def test_a_matrix_may_be_wrong_in_the_file_too_that_has_all_its_numbers(tmp_path, stated):
    key = replace(make_answer_key(MATRICES), numbers=frozenset(stated))
    slip = "[0.2, 0.7, 0.4], [0.3, 0.4, 1.9]", "[0.2, 0.7, -0.4], [0.3, -0.4, 1.9]"
    (edit,) = search(tmp_path, MATRICES, slip, keys=[key]).edits
    assert edit.is_stated == (1.9 in stated) == ("the file's numbers" in edit.remedy)


def test_a_change_of_a_long_line_is_marked_where_it_differs(tmp_path):
    """A sum with two names exchanged throughout, of which most stays as it is."""
    text = """
def make():
    a, b, s, c = 0.7, 1.9, 0.3, 1.1
    def turn(q):
        return [q[0]**2 + a * s * q[0] + b * c * q[1] + 0.25 * q[1]**2 + 1.5]
    return {"turn": turn}
"""
    (edit,) = search(tmp_path, text, ("a * s * q[0] + b * c", "b * s * q[0] + a * c")).edits
    assert (edit.removed, edit.added) == ("b * s * q[0] + a", "a * s * q[0] + b")
    assert f"{edit.start}{edit.added}{edit.end}" in text


def test_a_number_that_nobody_writes_is_no_answer(tmp_path):
    assert search(tmp_path, MATRICES, ("1.7 * e + e * e", "2.6 * np.exp(np.exp(e))")) is None


def test_an_edit_that_changes_what_equations_are_made_of_hides_no_other(tmp_path):
    """Row a in place of b keeps what is added to it, before a matrix is another one."""
    right = """
import numpy as np

def make():
    row_a = np.array([0.7, 1.9])
    A = np.array([[0.3, 1.2], [0.8, -0.5]])
    B = np.array([[1.1, 0.4], [-0.6, 0.9]])

    def ask(q):
        row_b = np.array([q[1], q[0]])
        summed = row_b
        summed[0] += 2.5 * q[0]
        return B @ A @ summed * row_a[0] + B[0]

    return {"ask": ask}
"""
    answer = search(tmp_path, right, ("B @ A", "A @ A"))
    assert answer.is_whole
    assert (answer.edits[0].new, answer.edits[0].rank) == ("B @ A", 2)


def test_what_names_are_is_seen_without_calling_anything(tmp_path):
    text = """
counts = []

def count():
    counts.append(1)
    return [1j, 2.0]

def make():
    return count()[0].real + count()[-1]
"""
    code = write_code(tmp_path, text)
    compiled = [code.compile(statement) for statement in code.statements]
    made = []
    SourceTree(code).observe(lambda: made.append(code.run(compiled)))
    assert made[0].__globals__["counts"] == []
    SourceTree(code).observe(lambda: made.append(code.run(compiled)()))
    assert len(sys.modules[MODULE].counts) == 2


def test_a_run_changes_none_of_the_users_own_arrays():
    """Else an edit that does would stay made in all that come after it."""
    rows = [np.ones(2)]
    own = {"rows": rows, "pair": (rows[0], {"last": np.ones(1)})}
    text = "def add():\n    rows[0] += 1\n    pair[1]['last'] += 1\n    return rows, pair\n"
    code = UserCode("mine.py", text, ast.parse(text).body, own, lambda names: names["add"])
    changed, pair = code.run(map(code.compile, code.statements))()
    assert [*changed[0], *pair[1]["last"]] == [2, 2, 2]
    assert pair[0] is changed[0]
    assert [*rows[0], *own["pair"][1]["last"]] == [1, 1, 1]


def test_progress_is_reported(tmp_path):
    updates = []
    text = select_parts("weights")
    code = write_code(tmp_path, text, ("- 2 * c1", "+ 2 * c1"))
    find_source_answer(code, lambda: [make_answer_key(text)], updates.append)
    assert updates == ["looking for the line that must change"]


def test_of_edits_of_one_statement_that_say_the_same_the_likeliest_is_the_answer(tmp_path):
    """Judged on one mechanism each is an alternative; on unequal numbers they are one answer."""
    text = select_parts("weights", "moment")
    key, turned = make_answer_key(text), make_answer_key(text, STATES[::-1])
    here, unequal = (
        search(tmp_path, text, ("R.T @ w", "R @ w"), keys=keys) for keys in ([key], [key, turned])
    )
    assert here.alternatives
    assert unequal.is_unequal
    assert not unequal.alternatives
    assert unequal.edits == here.edits


@pytest.mark.parametrize(("level", "said"), [("links", ""), ("carriers", "carriers")])
def test_of_two_edits_another_level_than_the_judged_one_alone_is_named(level, said):
    judge = SimpleNamespace(level="links", is_unequal=True)
    found = EditSearch.find_pair_answer(SimpleNamespace(pair=((), level), judge=judge))
    assert found == SourceAnswer((), level=said)
