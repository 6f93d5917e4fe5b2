"""The Python interface: what tools see of it, and the examples of its reference."""

import doctest
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import crosscheck
import crosscheck.testing
from crosscheck.models.errors import CannotDo
from crosscheck.models.interface import Model

ROOT = Path(__file__).parents[2]
REFERENCE = ROOT / "docs" / "reference" / "python.md"
SCRIPT = """
import crosscheck
from crosscheck.testing import Equations, assert_agrees, from_sympy

arm = crosscheck.load_arm("paper-labelled")
model = crosscheck.build("analytic:coupled", arm, crosscheck.load_scenario("pd"))
reveal_type(arm)
reveal_type(model)
reveal_type(model.mass_matrix)
reveal_type(crosscheck.load_robot)
reveal_type(crosscheck.check)
reveal_type(crosscheck.simulate)
reveal_type(crosscheck.sweep)
reveal_type(Equations())
reveal_type(from_sympy)
reveal_type(assert_agrees)
crosscheck.check(quick="yes")
"""


@pytest.mark.system
def test_type_checker_knows_every_type(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    words = ["-m", "mypy", "--follow-imports=silent", "--cache-dir", str(tmp_path / "cache")]
    environment = {**os.environ, "MYPYPATH": str(ROOT)}  # an editable install is an import hook
    checked = subprocess.run(
        [sys.executable, *words, str(script)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    types = re.findall(r'Revealed type is "(.*)"', checked.stdout)
    assert len(types) == SCRIPT.count("reveal_type"), checked.stdout
    for revealed in types:
        assert not re.search(r"-> Any$|^Any$", revealed), checked.stdout
    assert "-> numpy.ndarray" in types[2]
    assert 'incompatible type "str"; expected "bool"' in checked.stdout


@pytest.mark.parametrize("module", [crosscheck, crosscheck.testing], ids=lambda m: m.__name__)
def test_every_public_name_is_listed_and_imported(module):
    assert sorted(module.__all__) == [name for name in dir(module) if name[:1] != "_"]
    for name in module.__all__:
        assert getattr(module, name).__doc__
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        module.nothing  # noqa: B018


@pytest.mark.parametrize("module", [crosscheck, crosscheck.testing], ids=lambda m: m.__name__)
def test_example_of_the_module_runs(module):
    results = doctest.testmod(module)
    assert results.attempted
    assert not results.failed


@pytest.mark.slow
def test_examples_of_the_reference_run():
    results = doctest.testfile(str(REFERENCE), module_relative=False)
    assert results.attempted
    assert not results.failed


def test_reference_shows_every_public_name():
    text = REFERENCE.read_text(encoding="utf-8")
    examples = " ".join(re.findall(r"```pycon\n(.*?)```", text, flags=re.S))
    for name in {*crosscheck.__all__, *crosscheck.testing.__all__}:
        assert re.search(rf"auto\w+:: crosscheck\.(testing\.)?{name}$", text, re.M), name
        assert name[:1].isupper() or name in examples, name


@pytest.mark.parametrize("name", ["pinocchio:gears", "analytic:physical", "exudyn:tree"])
def test_model_takes_lists_and_refuses_what_is_no_state(name, labelled):
    model = crosscheck.build(name, labelled, crosscheck.load_scenario("pd"))
    state = [0] * 6
    assert model.mass_matrix(state).shape == (6, 6)
    assert model.acceleration(0.0, v=state, q=state).shape == (6,)
    for wrong in (state[1:], "ab", None, [state], [1j, *state[1:]]):
        with pytest.raises(crosscheck.InputError, match=r"q.*must be numbers of shape \(6,\)"):
            model.mass_matrix(wrong)
    if "simulate" not in model.abilities:
        with pytest.raises(CannotDo, match=f"{name} has no simulate"):
            model.simulate()


class Bare(Model):
    """A plug-in's model that answers nothing."""

    name = "mine:bare"


# What a model may be asked, with as many arguments as it has.
ASKED = {
    "mass_matrix": (None,),
    "simulate": (),
    "reference": (1e-6,),
    "precise": (1e-6,),
    "mesh_modes": (),
    "contact_poles": (),
    "constraint_residual": (None, None, None),
}


@pytest.mark.parametrize("asked", ASKED)
def test_a_model_says_what_it_does_not_answer(asked, labelled):
    model = Bare(labelled, crosscheck.load_scenario("pd"))
    with pytest.raises(CannotDo, match=f"mine:bare has no {asked}"):
        getattr(model, asked)(*ASKED[asked])
