"""Every field of a compiled MuJoCo model is used, or named in a note, or none of the motion's."""

import re
from collections.abc import Iterator

import mujoco
import pytest
from syrupy.assertion import SnapshotAssertion

from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.mjcf import notes, writer

# What no motion of rigid bodies without contact depends on, by the names of fields.
NO_MOTION = {
    "counts, addresses and names": r"n[a-zA-Z_]*|signature|\w*(adr|num)|names|names_map|paths",
    "pictures": r"(cam|light|mat|tex|skin|site|hfield|mesh|bvh|oct)_\w+|vis|stat|\w+_(rgba|matid)",
    "contact, noted by the count of geoms": (
        r"(geom|pair|exclude)_\w+|body_(margin|con\w+)|opt.o_\w+"
    ),
    "sensors, and texts, poses and numbers for programs": (
        r"(sensor|text|tuple|numeric|key)_\w+|\w+_(user|group)|opt.magnetic"
    ),
    "flexes, which are refused": r"flex\w+",
    "paths of tendons and how wide they are, each of whose effects is noted": (
        r"wrap_\w+|tendon_(adr|num|width|length0)"
    ),
    "softness of constraints, which hold exactly here": r"\w+_(solref|solimp)(_\w+)?|\w+_margin",
    "what the compiler derives of others": (
        r"[BDM]_\w+|map\w+|\w+_(invweight0|sameframe|treeid|simple\w*|M0|acc0|length0|lengthrange)"
        r"|body_(rootid|subtreemass|bvh\w+|geom\w+|dof\w+)|dof_(bodyid|parentid|Madr)|jnt_bodyid"
    ),
    "how MuJoCo integrates and solves": (
        r"opt\.(timestep|integrator|solver|cone|jacobian|impratio|enableflags|disableactuator"
        r"|\w*(iterations|tolerance)|sdf_\w+)"
    ),
    "plugins' own data": r"plugin\w*",
    "what an equality constrains, by its type": r"eq_objtype",
}
# By the field whose note names them.
COMPANIONS = {
    "qpos_spring": "jnt_stiffness",
    "tendon_lengthspring": "tendon_stiffness",
    "tendon_range": "tendon_limited",
    "tendon_actfrcrange": "tendon_actfrclimited",
    "actuator_ctrlrange": "actuator_ctrllimited",
    "actuator_forcerange": "actuator_forcelimited",
    "actuator_actrange": "actuator_actlimited",
    "actuator_dynprm": "actuator_dyntype",
    "actuator_actearly": "actuator_dyntype",
    "actuator_cranklength": "actuator_trntype",
    "jnt_actgravcomp": "body_gravcomp",
}
ARM = """<mujoco>{option}<worldbody><body name="a" {body}><joint name="j" axis="0 1 0" {joint}/>
<inertial pos=".3 0 0" mass="2" diaginertia=".02 .1 .1"/><site name="s"/>{geom}
<body name="b" pos=".6 0 0"><joint name="k" type="slide"/>
<inertial pos=".2 0 0" mass="1" diaginertia=".01 .04 .04"/></body></body>{world}</worldbody>
<tendon><fixed name="t" {tendon}><joint joint="j" coef="1"/></fixed></tendon>
<actuator>{actuator}</actuator>{more}</mujoco>"""
PLACES = ("option", "body", "joint", "geom", "world", "tendon", "actuator", "more")
# By the field: where in the file above, and what stands there.
STATED = {
    "opt.density": ("option", '<option density="1.2"/>'),
    "opt.viscosity": ("option", '<option viscosity="2e-5"/>'),
    "opt.wind": ("option", '<option wind="1 0 0"/>'),
    "body_gravcomp": ("body", 'gravcomp="1"'),
    "body_mocapid": ("world", '<body name="m" mocap="true"/>'),
    "jnt_stiffness": ("joint", 'stiffness="3"'),
    "dof_frictionloss": ("joint", 'frictionloss="3"'),
    "dof_damping": ("joint", 'damping="3"'),
    "dof_armature": ("joint", 'armature="3"'),
    "tendon_stiffness": ("tendon", 'stiffness="3"'),
    "tendon_damping": ("tendon", 'damping="3"'),
    "tendon_armature": ("tendon", 'armature="3"'),
    "tendon_frictionloss": ("tendon", 'frictionloss="3"'),
    "tendon_limited": ("tendon", 'range="0 1"'),
    "tendon_actfrclimited": ("tendon", 'actuatorfrcrange="-1 1" actuatorfrclimited="true"'),
    "actuator_plugin": (
        "more",
        '<extension><plugin plugin="mujoco.pid"/></extension><actuator><plugin'
        ' name="m" joint="j" plugin="mujoco.pid"/></actuator>',
    ),
    "body_plugin": (
        "more",
        "<extension><plugin"
        ' plugin="mujoco.elasticity.cable"/></extension><worldbody><body'
        ' name="p"><joint/><geom size="1"/><plugin'
        ' plugin="mujoco.elasticity.cable"/></body></worldbody>',
    ),
    "actuator_gear": ("actuator", '<motor joint="j" gear="7"/>'),
    "actuator_trntype": ("actuator", '<motor name="m" site="s"/>'),
    "actuator_biastype": ("actuator", '<position name="m" joint="j"/>'),
    "actuator_gainprm": ("actuator", '<general name="m" joint="j" gainprm="2"/>'),
    "actuator_dyntype": ("actuator", '<general name="m" joint="j" dyntype="integrator"/>'),
    "actuator_actlimited": (
        "actuator",
        '<general name="m" joint="j" dyntype="integrator" actrange="0 1"/>',
    ),
    "actuator_ctrllimited": ("actuator", '<motor name="m" joint="j" ctrlrange="0 1"/>'),
    "actuator_forcelimited": ("actuator", '<motor name="m" joint="j" forcerange="0 1"/>'),
    "eq_active0": (
        "more",
        '<equality><joint name="e" joint1="j" joint2="k" active="false"/></equality>',
    ),
    "geom_contype": ("geom", '<geom size="1"/>'),
    "pair_geom1": (
        "more",
        '<worldbody><geom name="g" size="1" contype="0" conaffinity="0"/><geom'
        ' name="h" size="1" contype="0" conaffinity="0"/></worldbody><contact><pair'
        ' geom1="g" geom2="h"/></contact>',
    ),
}


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


def list_fields(model) -> Iterator[str]:
    for owner, prefix in ((model, ""), (model.opt, "opt.")):
        for name in dir(owner):
            if not name.startswith("_") and not callable(getattr(owner, name)):
                yield prefix + name


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
    fields = set(list_fields(model)) - {"opt"}
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
