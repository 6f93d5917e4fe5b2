"""`crosscheck init` writes an arm that loads, explains itself and replaces nothing."""

import re
import shlex
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from crosscheck import output
from crosscheck.cli.files.template import example_arm, template
from crosscheck.models.arm.arm import Arm, Direct, Link
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.registry import build
from crosscheck.schema import describe_fields
from tests.tool.test_bad_input import assert_one_line
from tools.reference import list_records_below

# Fields in whose place the template has another.
OTHER_FORMS = {
    *("sun_inertia_kg_m2", "planet_inertia_kg_m2", "carrier_inertia_kg_m2"),
    "damping_N_s_per_m",
}


def written(folder: Path, text: str) -> Arm:
    file = folder / "arm.toml"
    file.write_text(text, encoding="utf-8")
    return load_arm(str(file))


@pytest.mark.parametrize("joints", range(1, 8))
def test_template_is_an_arm_that_shrinks_towards_its_tip(tmp_path, joints):
    arm = written(tmp_path, template(example_arm("mine", joints)))
    assert (arm.name, len(arm.joints), len(arm.links)) == ("mine", joints, joints)
    assert all(outer.module_m < inner.module_m for inner, outer in pairwise(arm.joints))
    assert all(outer.length_m < inner.length_m for inner, outer in pairwise(arm.links))


@pytest.mark.parametrize(
    ("arm", "highest_Hz", "step_s"),
    [
        *((joints, 6e3, 5e-5) for joints in (1, 2, 7)),
        *((name, 5e3, 8e-5) for name in ("three-unlike", "direct-between")),
    ],
)
def test_arms_to_start_from_are_well_conditioned(tmp_path, arm, highest_Hz, step_s):
    """Mesh modes of kHz, steps of which a run does not need many, inertias that suit each other."""
    text = template(example_arm("mine", arm)) if isinstance(arm, int) else ""
    arm = written(tmp_path, text) if text else load_arm(arm)
    model = build("analytic:physical", arm, load_scenario("constant-torque"))
    modes = model.mesh_modes()
    assert len(modes) == 2 * len(model.layout.mesh_joints)
    assert 1e3 < modes[0] < modes[-1] < highest_Hz
    assert model.largest_stable_step() > step_s
    mass = model.mass_matrix(np.zeros(len(model.layout)))
    scale = np.sqrt(np.diag(mass))
    assert np.linalg.cond(mass / np.outer(scale, scale)) < 1e3


def test_examples_that_are_commented_out_load(tmp_path):
    text = re.sub(r"^# (?=\[\[|[a-z0-9_]+ = )", "", template(example_arm("mine", 2)), flags=re.M)
    arm = written(tmp_path, text)
    assert arm.gravity_m_per_s2 == (0.0, -9.81)
    assert isinstance(arm.joints[2], Direct)
    assert arm.links[2].mass_kg is not None


@pytest.mark.parametrize(
    "record", [r for r in list_records_below(Arm) if "Stiff" not in r.__name__]
)
def test_every_field_is_explained(record):
    text = template(example_arm("mine", 1))
    for field in describe_fields(record):
        if field.lists or field.records or field.name in OTHER_FORMS:
            continue
        unit = f"[{field.unit}] " if field.unit else ""
        assert re.search(
            rf"^(# )?{field.name} = .* # {re.escape(unit + field.meaning)}$", text, flags=re.M
        )
    assert record is not Link or text.count("length_m = ") == 2


def test_init_writes_and_says_what_is_next(crosscheck, tmp_path):
    file = tmp_path / "my arm.toml"
    answer = crosscheck("init", file, "--joints", 3)
    assert (answer.code, answer.err) == (0, "")
    assert f"crosscheck show {shlex.quote(str(file))}\n" in answer.out
    arm = load_arm(str(file))
    assert (arm.name, len(arm.joints)) == ("my arm", 3)


def test_name_that_is_no_text_is_left_to_the_user(crosscheck, tmp_path):
    for name in ('a"b\\c', "ä", "x\n", "x" * 90):
        file = tmp_path / f"{name}.toml"
        assert crosscheck("init", file).code == 0
        assert load_arm(str(file)).name == (name if name in ('a"b\\c', "ä") else "my-arm")


def test_a_link_to_a_file_that_is_not_there_is_left_alone(crosscheck, tmp_path):
    (tmp_path / "mine.toml").symlink_to("elsewhere/arm.toml")
    assert_one_line(crosscheck("init", tmp_path / "mine.toml"), "exists already")
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]


def test_a_name_with_control_characters_is_shown_with_escapes(crosscheck, tmp_path):
    answer = crosscheck("init", tmp_path / "a\x1b[31m\nb.toml")
    assert answer.code == 0
    assert all(line.isprintable() for line in answer.out.splitlines())
    assert answer.out.count("\n") == 4


def test_of_two_that_begin_one_file_at_once_one_is_refused(tmp_path, monkeypatch):
    """Both have seen that there is none."""
    file = tmp_path / "arm.toml"
    monkeypatch.setattr(output, "require_new", lambda path: path)
    output.write_new_text(file, "first")
    with pytest.raises(InputError, match="exists already"):
        output.write_new_text(file, "second")
    assert file.read_text() == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["arm.toml"]


def test_a_file_of_an_editor_that_marks_the_byte_order_is_read(crosscheck, tmp_path):
    crosscheck("init", tmp_path / "arm.toml")
    (tmp_path / "marked.toml").write_bytes(b"\xef\xbb\xbf" + (tmp_path / "arm.toml").read_bytes())
    assert load_arm(str(tmp_path / "marked.toml")) == load_arm(str(tmp_path / "arm.toml"))
