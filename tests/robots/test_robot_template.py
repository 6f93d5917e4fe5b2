"""`crosscheck init --urdf`: a file that loads, names every joint and replaces nothing."""

import numpy as np

from crosscheck.cli.files.robot_files import load_as_robot
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.urdf_gears import StatedGear, StatedNumber
from tests.robots.chains import LIMIT, Solid, joint, link, random_chain, urdf

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
    assert "1 joint, all direct" in answer.out
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


def test_a_joint_without_motor_is_there_with_its_friction(crosscheck, tmp_path):
    """As a line that loads, whose comment is one that loads too."""
    passive = TEXT.replace("</robot>", '<passive_joint name="the first"/></robot>')
    (tmp_path / "r.urdf").write_text(passive)
    answer = crosscheck("init", tmp_path / "r.toml", "--urdf", tmp_path / "r.urdf")
    assert "1 joint, all direct; no motor drives the first\nedit it, then run" in answer.out
    text = (tmp_path / "r.toml").read_text()
    assert load_robot(str(tmp_path / "r.toml")).joints[0].friction == 0
    rubbed = text.replace('{ kind = "direct" } # no motor; with friction: ', "")
    (tmp_path / "r.toml").write_text(rubbed)
    assert load_robot(str(tmp_path / "r.toml")).joints[0].friction == 0.1


def test_every_chain_is_read_back_as_it_was(crosscheck, tmp_path):
    for seed in range(5):
        own = random_chain(seed)
        (tmp_path / "r.urdf").write_text(own.urdf)
        (tmp_path / "r.toml").unlink(missing_ok=True)
        assert crosscheck("init", tmp_path / "r.toml", "--urdf", tmp_path / "r.urdf").code == 0
        again = load_robot(str(tmp_path / "r.toml"))
        assert [each.name for each in again.joints] == [each.name for each in own.joints]
        assert np.array_equal(again.gravity, [0, 0, -9.81])


GEARS = """
<transmission name="turn"><joint name="a"/><actuator name="m">
<mechanicalReduction>-100</mechanicalReduction><motorInertia>1.1e-4</motorInertia></actuator></transmission>
<transmission name="drakes"><joint name="b"/><actuator name="n">
<drake:gear_ratio value="50"/><drake:rotor_inertia value="2e-5"/></actuator></transmission>
<transmission name="half"><joint name="c"/><mechanicalReduction> 20 </mechanicalReduction>
</transmission>
<transmission><joint name="d"/><mechanicalReduction>7</mechanicalReduction>
</transmission>
<transmission name="both"><joint name="a"/><joint name="b"/></transmission>
"""


def geared_text(gears: str = GEARS, armature: str = "0.08") -> str:
    chain = [link("ground"), *(link(f"link {name}", Solid()) for name in "abcde")]
    parents = ("ground", "link a", "link b", "link c", "link d")
    for name, parent in zip("abcde", parents, strict=True):
        more = LIMIT + (f'<dynamics armature="{armature}"/>' if name in "ce" else "")
        chain.append(joint(name, parent, f"link {name}", more=more))
    return urdf(*chain, gears)


def test_init_takes_gears_where_a_urdf_states_them(crosscheck, tmp_path):
    weld = link("tool") + joint("weld", "link e", "tool", "fixed")
    weld += link("vane", Solid()) + joint("vane", "tool", "vane") + '<passive_joint name="vane"/>'
    for name in ("weld", "vane"):
        weld += f'<transmission><joint name="{name}"/><mechanicalReduction>3</mechanicalReduction>'
        weld += "</transmission>"
    (tmp_path / "r.urdf").write_text(geared_text(GEARS + weld))
    answer = crosscheck("init", tmp_path / "r.toml", "--urdf", tmp_path / "r.urdf")
    assert (answer.code, answer.err) == (0, "")
    assert "6 joints, 3 geared as r.urdf states; no motor drives vane" in answer.out
    assert "weld" not in answer.out
    assert "transmission both left out: of a, b" in answer.out
    assert "e: armature 0.08 kg m^2 of joint e" in answer.out
    text = (tmp_path / "r.toml").read_text()
    assert "# ratio -100 of transmission turn: mechanicalReduction, rotor 0.00011 kg m^2 of" in text
    assert 'd = { kind = "direct" } # ratio 7 of transmission: mechanicalReduction' in text
    robot = load_robot(str(tmp_path / "r.toml"))
    rotors = {robot.joints[each.joint].name: (each.ratio, each.inertia) for each in robot.rotors}
    # 0.08 = 20^2 J of the joint with an armature and a ratio
    assert rotors == {"a": (-100.0, 1.1e-4), "b": (50.0, 2e-5), "c": (20.0, 0.08 / 400)}
    *_, last = load_as_robot(str(tmp_path / "r.urdf"), 20.0, 1e-4).rotors  # e, by its armature
    assert last.inertia == 0.08 / 400


def test_a_stated_gear_is_called_what_its_file_calls_it():
    reduced = StatedNumber(50.0, "transmission", "mechanicalReduction")
    gear = StatedGear(reduced, StatedNumber(2e-4, "rotor"))
    assert gear.elements == "mechanicalReduction 50 of transmission, rotor 0.0002 kg m^2 of rotor"
