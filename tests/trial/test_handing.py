"""Equations out of a user's file or package."""

import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.models.robot.file import load_robot
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.loading import build_equations, load_equations
from crosscheck.trial.input.supplied import bind_equations
from crosscheck.trial.source.code import find_code

ARM, PROBE = load_arm("paper-labelled"), load_arm("probe")
SCENARIO = load_scenario("constant-torque")
HEAD = "import numpy as np\nfrom crosscheck.trial.input.equations import Coordinates, Equations\n"


def over(folder: Path, code: str, name: str = "model") -> Equations:
    path = folder / "hand.py"
    path.write_text(HEAD + code)
    return load_equations(f"{path}:{name}", ARM, SCENARIO)


def payload(equations: Equations) -> float:
    own = bind_equations(equations, ARM, build_frame(equations.coordinates, ARM))
    return float(own.mass_matrix(np.zeros(2))[0, 0])


ROWS = tomllib.loads(Path(__file__).with_name("supplied.toml").read_text(encoding="utf-8"))
GIVEN, BAD, PLACES = ROWS["given"], ROWS["bad"], ROWS["places"]
OF_ANY_ARM = set(GIVEN) - {"equations", "factory of nothing", "object", "object of a factory"}


@pytest.mark.parametrize("kind", GIVEN)
def test_everything_that_can_be_handed_over(kind, tmp_path):
    equations = over(tmp_path, GIVEN[kind])
    assert payload(equations) == 10.0
    assert equations.any_arm == (kind in OF_ANY_ARM)
    assert payload(equations.adapt_to_arm(PROBE)) == (7.0 if kind in OF_ANY_ARM else 10.0)
    assert payload(equations.adapt_to_arm(PROBE).adapt_to_arm(ARM)) == 10.0


def test_a_module_itself_and_an_attribute_of_something(tmp_path):
    code = "class Mine:\n model = Equations(mass_matrix=lambda q: np.eye(2))"
    assert payload(over(tmp_path, code, "Mine.model")) == 1.0
    code = "class Mine:\n level = 'links'\n coordinates = Coordinates(links='absolute')\n"
    code += " @staticmethod\n def mass_matrix(q):\n  return np.eye(2)\nmine = Mine()"
    found = over(tmp_path, code, "mine")
    assert found.level == "links"
    assert found.coordinates.links == "absolute"


def test_a_package_in_the_current_folder(tmp_path, monkeypatch):
    (tmp_path / "my_robot_package").mkdir()
    (tmp_path / "my_robot_package" / "hand.py").write_text(HEAD + GIVEN["of an arm"])
    monkeypatch.chdir(tmp_path)
    before = list(sys.path)
    assert payload(load_equations("my_robot_package.hand:model", ARM, None)) == 10.0
    assert sys.path == before


def test_modules_beside_the_file_are_found_and_shadow_nothing(tmp_path):
    (tmp_path / "beside_hand.py").write_text("ten = 10\n")
    (tmp_path / "zipapp.py").write_text("raise RuntimeError\n")  # which nothing has imported
    (tmp_path / "crosscheck").mkdir()
    (tmp_path / "crosscheck" / "__init__.py").write_text("raise RuntimeError\n")
    code = "import zipapp, crosscheck.models.arm.arm\nfrom beside_hand import ten\n"
    code += "model = Equations(mass_matrix=lambda q: np.eye(2) * ten)"
    assert payload(over(tmp_path, code)) == 10.0
    (tmp_path / "later_hand.py").write_text("ten = 10\n")
    code = "def model(arm):\n from later_hand import ten\n"
    code += " return Equations(mass_matrix=lambda q: np.eye(2) * ten)"
    assert payload(over(tmp_path, code)) == 10.0
    (tmp_path / "latest_hand.py").write_text("ten = 10\n")
    code = code.replace("(arm)", "(robot)").replace("later_", "latest_")
    (tmp_path / "robot_hand.py").write_text(HEAD + code)
    of_robot = load_equations(f"{tmp_path}/robot_hand.py:model", load_robot("sliding"))
    assert of_robot.mass_matrix(np.zeros(3))[1, 1] == 10.0
    assert str(tmp_path) not in sys.path


def test_a_file_is_read_anew(tmp_path):
    assert payload(over(tmp_path, GIVEN["equations"])) == 10.0
    changed = GIVEN["equations"].replace("10", "11 + 0 * 100")
    assert payload(over(tmp_path, changed)) == 11.0


@pytest.mark.parametrize("code", BAD)
def test_bad_code_is_one_line(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=BAD[code]) as caught:
        over(Path(), code)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith("hand.py:model: ")


@pytest.mark.parametrize("text", PLACES)
def test_bad_places(text):
    with pytest.raises(InputError, match=PLACES[text]):
        load_equations(text, ARM, None)


def test_from_python_nothing_is_a_file():
    equations = Equations(mass_matrix=lambda q: np.eye(2))
    assert build_equations(equations, ARM, None, "here") is equations
    assert payload(build_equations(lambda arm: equations, ARM, None, "here")) == 1.0


def test_functions_of_the_package_are_nobodys_code():
    assert find_code(Equations(bias=build_frame)) is None

    def bias(x):
        return later * x

    assert find_code(Equations(bias=bias)).file == __file__
    later = 0.0  # what has no value before is no hindrance


def test_equations_of_another_arm_keep_the_code_that_they_came_from():
    """Their own, if rebuilding finds it anew."""
    first, second = (lambda: None), (lambda: None)
    for own, expected in ((None, first), (second, second)):
        rebuilt = Equations(mass_matrix=lambda q: np.eye(2), find_code=own)
        equations = replace(rebuilt, rebuild=lambda *_, new=rebuilt: new, find_code=first)
        assert equations.adapt_to_arm(PROBE).find_code is expected
