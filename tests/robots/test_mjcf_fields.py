"""Every field of a compiled MuJoCo model is used, or named in a note, or none of the motion's."""

import re
import tomllib
from pathlib import Path

import mujoco
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.mjcf import notes, writer

TABLES = tomllib.loads(Path(__file__).with_name("mjcf_fields.toml").read_text(encoding="utf-8"))
NO_MOTION, COMPANIONS, STATED = (TABLES[name] for name in ("no_motion", "companions", "stated"))
ARM = """<mujoco>{option}<worldbody><body name="a" {body}><joint name="j" axis="0 1 0" {joint}/>
<inertial pos=".3 0 0" mass="2" diaginertia=".02 .1 .1"/><site name="s"/>{geom}
<body name="b" pos=".6 0 0"><joint name="k" type="slide"/>
<inertial pos=".2 0 0" mass="1" diaginertia=".01 .04 .04"/></body></body>{world}</worldbody>
<tendon><fixed name="t" {tendon}><joint joint="j" coef="1"/></fixed></tendon>
<actuator>{actuator}</actuator>{more}</mujoco>"""
PLACES = ("option", "body", "joint", "geom", "world", "tendon", "actuator", "more")


class Recorder:
    """A compiled model that keeps in ``fields`` what is asked of it."""

    def __init__(self, model, fields, prefix=""):
        self.model, self.fields, self.prefix = model, fields, prefix

    def __getattr__(self, name):
        self.fields.add(self.prefix + name)
        value = getattr(self.model, name)
        return Recorder(value, self.fields, "opt.") if name == "opt" else value


def write_file(**places: str) -> str:
    return ARM.format(**dict.fromkeys(PLACES, "") | places)


def test_every_field_of_a_compiled_model_is_used_or_of_no_motion():
    text = write_file(
        joint='range="0 1" frictionloss="1"',
        more='<equality><joint joint1="j" joint2="k"/></equality>',
        actuator='<motor joint="j" gear="7"/>',
    )
    spec = mujoco.MjSpec.from_string(text)
    model, used = spec.compile(), set[str]()
    recorder = Recorder(model, used)
    writer._Writer(mujoco, spec, recorder, "arm.xml").write(notes.list_notes(mujoco, recorder, 0))
    writer._find_gravity(mujoco, recorder)
    owners = (("", model), ("opt.", model.opt))
    every = {f"{at}{n}": getattr(own, n) for at, own in owners for n in dir(own) if n[0] != "_"}
    fields = {name for name, value in every.items() if not callable(value)} - {"opt"}
    assert {field.name for field in notes.FIELDS} | set(COMPANIONS.values()) <= used & fields
    idle = {f for f in fields if any(re.fullmatch(each, f) for each in NO_MOTION.values())}
    assert fields - used - idle - COMPANIONS.keys() == set()
    # Nothing that decides a motion is on the list of what does not.
    assert {f for f in used & idle if not re.match("n|body_dofadr|.*adr$|.*num$", f)} == set()


def test_every_field_that_is_noted_is_in_the_table():
    noted = {field.name for field in notes.FIELDS} | {f"opt.{name}" for name in notes.OPTIONS}
    assert noted <= STATED.keys()


@pytest.mark.parametrize("field", STATED)
def test_what_is_not_used_is_noted_with_its_name(tmp_path, field, snapshot: SnapshotAssertion):
    place, text = STATED[field]
    file = tmp_path / "arm.xml"
    file.write_text(write_file())
    before = load_robot(str(file)).notes
    file.write_text(write_file(**{place: text}))
    assert [note for note in load_robot(str(file)).notes if note not in before] == snapshot


@pytest.mark.parametrize(
    ("flag", "place", "text"),
    [
        ("spring", "joint", 'stiffness="3"'),
        ("damper", "joint", 'damping="3"'),
        ("frictionloss", "tendon", 'frictionloss="3"'),
        ("contact", "geom", '<geom size="1"/>'),
        ("gravity", "body", 'gravcomp="1"'),
    ],
)
def test_what_a_file_switches_off_is_not_noted(tmp_path, flag, place, text):
    off = f'<option><flag {flag}="disable"/></option>'
    for option, count in ((off, 0), ("", 1)):
        (tmp_path / "arm.xml").write_text(write_file(**{"option": option, place: text}))
        assert len(load_robot(str(tmp_path / "arm.xml")).notes) == count
