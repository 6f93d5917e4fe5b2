"""`crosscheck init --urdf`: a file that loads, names every joint and replaces nothing."""

import numpy as np

from crosscheck.models.robot.file import load_robot
from tests.robots.chains import LIMIT, Solid, joint, link, random_chain, urdf
from tests.tool.test_bad_input import assert_one_line

TEXT = urdf(
    link("ground"),
    link("arm", Solid()),
    link("finger", Solid()),
    joint("the first", "ground", "arm"),
    joint("grip", "arm", "finger", more=LIMIT + '<mimic joint="the first"/>'),
)


def test_init_writes_a_file_that_loads(crosscheck, tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "mine.urdf").write_text(TEXT)
    answer = crosscheck("init", tmp_path / "mine.toml", "--urdf", tmp_path / "parts" / "mine.urdf")
    assert (answer.code, answer.err) == (0, "")
    assert "1 joints, all direct" in answer.out
    text = (tmp_path / "mine.toml").read_text()
    assert '"the first" = { kind = "direct" }' in text
    assert "grip" not in text
    robot = load_robot(str(tmp_path / "mine.toml"))
    assert (robot.name, robot.tip, robot.rotors) == ("mine", "finger", ())
    geared = '{ kind = "geared", ratio = 100.0, rotor_inertia_kg_m2 = 1e-4 }'
    assert f"#     {geared}" in text  # what its comment says is what the reader takes
    (tmp_path / "mine.toml").write_text(text.replace('{ kind = "direct" }', geared))
    assert [rotor.ratio for rotor in load_robot(str(tmp_path / "mine.toml")).rotors] == [100.0]
    lines = [line.removeprefix("#     ") for line in text.splitlines() if line.startswith("#     ")]
    stage = "\n".join(line for line in lines if line != geared).replace("NAME", '"the first"')
    (tmp_path / "mine.toml").write_text(text.replace('"the first" = ', "# ") + stage)
    assert [own.joint for own in load_robot(str(tmp_path / "mine.toml")).stages] == [0]


def test_every_chain_is_read_back_as_it_was(crosscheck, tmp_path):
    for seed in range(5):
        own = random_chain(seed)
        (tmp_path / "r.urdf").write_text(own.urdf)
        (tmp_path / "r.toml").unlink(missing_ok=True)
        assert crosscheck("init", tmp_path / "r.toml", "--urdf", tmp_path / "r.urdf").code == 0
        again = load_robot(str(tmp_path / "r.toml"))
        assert [each.name for each in again.joints] == [each.name for each in own.joints]
        assert np.array_equal(again.gravity, [0, 0, -9.81])


def test_init_of_a_robot_refuses_what_it_cannot_do(crosscheck, tmp_path):
    (tmp_path / "mine.urdf").write_text(TEXT)
    given = ["init", tmp_path / "mine.toml", "--urdf"]
    assert_one_line(crosscheck(*given, tmp_path / "yours.urdf"), "yours.urdf", "No such file")
    assert_one_line(crosscheck(*given, tmp_path / "mine.urdf", "--joints", 3), "--joints", "3")
    (tmp_path / "mine.toml").write_text("mine")
    assert_one_line(crosscheck(*given, tmp_path / "mine.urdf"), "mine.toml: exists already")
    assert (tmp_path / "mine.toml").read_text() == "mine"
