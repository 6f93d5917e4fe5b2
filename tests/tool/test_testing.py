"""`assert_agrees`: a trial as a plain assertion; what it raises is what the command prints."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.testing import Equations, assert_agrees
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.source.source_edit import SourceEdit
from tests.processes import command_line
from tests.tool.supplied import model_file


@pytest.fixture
def file(tmp_path):
    return model_file(tmp_path)


@pytest.fixture
def equations(file, labelled) -> Equations:
    """Of the paper's arm, all of them right."""
    return load_equations(f"{file}:two_link", labelled, None)


def test_right_equations_are_returned_judged(file, equations, labelled):
    trial = assert_agrees(equations, labelled, level="links", name="right")
    assert (trial.problem.name, trial.level, trial.exit_code) == ("right", "links", 0)
    assert assert_agrees(f"{file}:two_link").problem.name == "two_link"


def test_factories_and_objects_are_taken(equations):
    assert_agrees(lambda arm: equations)
    parts = SimpleNamespace(mass_matrix=equations.mass_matrix)
    assert "bias (not supplied), force (not supplied)" in assert_agrees(parts).scope[-1]


def test_wrong_equations_raise_what_the_command_prints(equations):
    slipped = replace(equations, force=lambda torque: -torque)
    with pytest.raises(AssertionError) as raised:
        assert_agrees(slipped)
    text = str(raised.value)
    first = text.splitlines()[0]
    assert first.startswith("force[theta_1]")
    assert "opposite sign" in first
    assert text.count(first) == 1
    assert raised.traceback[-1].frame.f_locals["__tracebackhide__"]
    assert "paper-labelled: force[theta_1] and 1 more entry are wrong" in text
    assert text.endswith("checks agree")
    with pytest.raises(AssertionError, match=r"^yours on paper-labelled: bias raised ZeroDivision"):
        assert_agrees(replace(equations, bias=lambda q, v: 1 / 0))


def test_what_is_refused_shows_no_source_of_ours():
    with pytest.raises(InputError) as raised:
        assert_agrees(None)
    assert len(raised.traceback) == 2  # this test's frame, and one that is hidden
    assert raised.traceback[-1].frame.f_locals["__tracebackhide__"]


def test_a_function_gives_its_own_name(equations):
    def my_arm(arm):
        return equations

    assert assert_agrees(my_arm).headline.startswith("my_arm on")

    def pinocchio(arm):
        return equations

    assert assert_agrees(pinocchio).problem.name == "yours"


def test_another_level_than_promised_is_wrong(equations):
    with pytest.raises(AssertionError, match=r"compared with armature(.|\n)*theta_2"):
        assert_agrees(replace(equations, rebuild=None), level="armature")


def test_scenarios_are_run(equations, labelled):
    from crosscheck.models.loading import load_scenario

    short = load_scenario("constant-torque").model_copy(update={"duration_s": 0.002})
    trial = assert_agrees(equations, labelled, scenarios=[short])
    assert {f.about.key.case for f in trial.agreement.findings} == {"paper-labelled", short.name}
    with pytest.raises(InputError, match="needs force"):
        assert_agrees(replace(equations, force=None), scenarios=[short])


def test_what_cannot_be_tried_is_an_input_error(equations):
    with pytest.raises(InputError, match="'analytic:links': a model of this name exists already"):
        assert_agrees(equations, name="analytic:links")
    with pytest.raises(InputError, match="three-unlike, 3 joints"):
        assert_agrees(replace(equations, rebuild=None), load_arm("three-unlike"))
    with pytest.raises(InputError, match="yours: is an int"):
        assert_agrees(5)


def test_part_put_in_the_place_of_another_is_what_is_judged(equations, labelled):
    slipped = replace(equations, force=lambda torque: -torque)
    assert slipped.adapt_to_arm(labelled) is slipped
    assert equations.rebuild is not None
    assert replace(equations, rebuild=lambda arm, scenario: equations).rebuild is not None


@pytest.mark.parametrize(
    ("module", "library"), [("testing", "numpy"), ("models.exudyn.robot", "numba")]
)
def test_import_is_light(module, library):
    code = f"import crosscheck.{module}, sys; sys.exit({library!r} in sys.modules)"
    assert command_line(python=("-c", code)).returncode == 0


LONG = "I1 + m1 * d1**2 + 2 * m12 - m22"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (f"{LONG} - m2 * d2**2", LONG.replace("**", " ** "), "- m2 * d2**2 should be left out"),
        (LONG, LONG.replace("m12", "m21"), "m12 should be m21"),
        (LONG, f"({LONG}) / 2", f"{LONG} should be ({LONG}) / 2"),
        ("m12 - m22", "m12", "m12 - m22 should be m12"),
        ("f(1, 0) + 3.25 + f(1, 0)", "f(0, 1) + 3.25 + f(1, 0)", ""),
        ("[[0.03, 0.21], [0.5, 1]]", "[[-0.03, 0.21], [-0.5, 1]]", ""),
    ],
)
def test_a_long_fix_is_said_without_the_ends_that_stay(old, new, said):
    """But where the rest would be ambiguous, or cut through brackets."""
    said = said or f"{old} should be {new}"
    edit = SourceEdit("mine.py", 3, old, new, "", old, new, "", (), 1)
    assert edit.short_remedy == said
