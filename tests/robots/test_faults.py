"""Faults planted in the data of one engine, or in a line of its code: each is seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.cost import agreement
from crosscheck.cost.agreement import compared, drawn
from crosscheck.models.robot.robot import Joint, Robot, RobotBody, Rotor
from tests.faults.faults import edit
from tests.robots.chains import ENGINES, LIMIT, Solid, geared, joint, link, robot, teeth, urdf

Change = Callable[[Robot], Robot]
TEETH = teeth(0.02, 1e6, 100.0, 2e-5)
TURNED = Solid(1.7, (0.11, -0.04, 0.07), (0.03, 0.004, -0.006, 0.05, 0.002, 0.06), (0.3, -0.2, 0.5))


@pytest.fixture(scope="module")
def unlike() -> Robot:
    """A revolute and a prismatic joint, a fixed link, a mimic, rotors on three links."""
    text = urdf(
        link("ground"),
        link("a", TURNED),
        link("b", TURNED._replace(mass=0.9)),
        link("c", TURNED._replace(com=(0.02, 0.09, -0.1))),
        link("plate", TURNED._replace(mass=0.4)),
        link("d", TURNED),
        link("tool"),
        joint("flange", "d", "tool", "fixed", at=(0.1, 0.0, 0.2), rpy=(0.0, 0.3, 0.0)),
        joint("one", "ground", "a", axis=(0.2, 0.3, 0.9), at=(0.1, 0.2, 0.3), rpy=(0.1, 0.2, 0.4)),
        joint("two", "a", "b", axis=(1, 0, 0), at=(0.3, 0.0, 0.1), rpy=(0.5, -0.4, 0.7)),
        joint("fixed", "b", "plate", "fixed", at=(0.1, 0.1, 0.0), rpy=(0.2, 0.6, -0.3)),
        joint("three", "plate", "c", "prismatic", (0.6, 0.0, 0.8), (0.2, 0.1, 0.2), (1, 0.3, 0.2)),
        joint(
            *("four", "c", "d", "revolute", (0, 1, 0), (0.1, 0.2, 0.1), (0.4, 0.2, 0.9)),
            more=LIMIT + '<mimic joint="two" multiplier="-0.5" offset="0.3"/>',
        ),
    )
    return robot(
        text,
        {
            "one": geared(9.0),
            "two": geared(-7.0, stator="plate", rotor_axis=[0.5, 0.5, 0.2], mesh=TEETH),
            "three": geared(30.0, mesh=TEETH),
        },
        tip="tool",
    )


@pytest.fixture(scope="module")
def all_sprung() -> Robot:
    """Two joints whose rotors all have meshes: every joint of the engines' trees moves freely."""
    text = urdf(
        link("ground"),
        link("a", TURNED),
        link("b", TURNED),
        joint("one", "ground", "a", axis=(0.2, 0.3, 0.9)),
        joint("two", "a", "b", axis=(1, 0, 0), at=(0.3, 0.0, 0.1)),
    )
    return robot(text, {"one": geared(5.0, mesh=TEETH), "two": geared(-4.0, mesh=TEETH)})


def seen(own: Robot) -> set[str]:
    """The quantities that differ."""
    return {each.quantity for each in compared(own, drawn(own, 3, 0)) if not each.agrees}


def test_without_a_fault_nothing_differs(unlike):
    assert seen(unlike) == set()


def body(number: int, change: Callable[[RobotBody], RobotBody]) -> Change:
    def changed(own: Robot) -> Robot:
        bodies = list(own.bodies)
        bodies[number] = change(bodies[number])
        return replace(own, bodies=tuple(bodies))

    return changed


def moved(number: int, change: Callable[[Joint], Joint]) -> Change:
    def changed(own: Robot) -> Robot:
        joints = list(own.joints)
        joints[number] = change(joints[number])
        return replace(own, joints=tuple(joints))

    return changed


def spun(number: int, change: Callable[[Rotor], Rotor]) -> Change:
    def changed(own: Robot) -> Robot:
        rotors = list(own.rotors)
        rotors[number] = change(rotors[number])
        return replace(own, rotors=tuple(rotors))

    return changed


def meshed(field: str, factor: float) -> Change:
    """Of the last rotor."""

    def changed(rotor: Rotor) -> Rotor:
        assert rotor.mesh
        update = {field: factor * getattr(rotor.mesh, field)}
        return replace(rotor, mesh=rotor.mesh.model_copy(update=update))

    return spun(2, changed)


SWAPPED = [0, 2, 1]
IN_LINKS: dict[str, Change] = {
    "sign of a centre of mass": body(1, lambda b: replace(b, com=b.com * [1, -1, 1])),
    "Ixy and Ixz swapped": body(
        1,
        lambda b: replace(
            b,
            inertia=np.diag(np.diag(b.inertia))
            + (b.inertia - np.diag(np.diag(b.inertia)))[np.ix_(SWAPPED, SWAPPED)],
        ),
    ),
    "inertia about the joint": body(
        0,
        lambda b: replace(
            b, inertia=b.inertia + b.mass * (b.com @ b.com * np.eye(3) - np.outer(b.com, b.com))
        ),
    ),
    "mass a millionth off": body(3, lambda b: replace(b, mass=b.mass * (1 + 1e-6))),
    "axis turned about": moved(1, lambda j: replace(j, axis=-j.axis)),
    "axis of a slide": moved(2, lambda j: replace(j, axis=j.axis[[2, 1, 0]])),
    "placement transposed": moved(
        0, lambda j: replace(j, placement=replace(j.placement, rotation=j.placement.rotation.T))
    ),
    "the link before the fixed one": moved(3, lambda j: replace(j, parent=1)),
    "a slide that turns": moved(2, lambda j: replace(j, kind="revolute")),
}
IN_ROTORS: dict[str, Change] = {
    "sign of a ratio": spun(2, lambda r: replace(r, ratio=-r.ratio)),
    "axis of a rotor": spun(1, lambda r: replace(r, axis=r.axis[[1, 2, 0]])),
    "stator's link": spun(2, lambda r: replace(r, stator="a")),
    "stator on the ground": spun(1, lambda r: replace(r, stator="ground")),
    "frame of the stator": spun(1, lambda r: replace(r, stator="b")),
    "rotor of another joint": spun(2, lambda r: replace(r, joint=0)),
    "inertia of a rotor": spun(2, lambda r: replace(r, inertia=r.inertia * 1.0001)),
    "multiplier of a mimic": moved(
        3, lambda j: replace(j, mimic=j.mimic and replace(j.mimic, multiplier=0.5))
    ),
    "offset of a mimic": moved(
        3, lambda j: replace(j, mimic=j.mimic and replace(j.mimic, offset=-0.3))
    ),
    "radius of a pinion": meshed("pinion_base_radius_m", 1.0001),
    "stiffness of a mesh": meshed("stiffness_N_per_m", 1.0001),
    "damping of a mesh": meshed("damping_N_s_per_m", 1.0001),
    "play of a mesh": meshed("backlash_m", 1.0001),
    "gravity upside down": lambda own: replace(own, gravity=-own.gravity),
}


def assert_data_seen(monkeypatch, own: Robot, engine: str, change: Change) -> None:
    right = agreement.model_of

    def model_of(name, given, level):
        return right(name, change(given) if name == engine else given, level)

    monkeypatch.setattr(agreement, "model_of", model_of)
    assert seen(own)


@pytest.mark.parametrize("fault", IN_LINKS)
@pytest.mark.parametrize("engine", ["analytic", "exudyn"])  # Pinocchio reads the URDF itself
def test_wrong_links_are_seen(monkeypatch, unlike, engine, fault):
    assert_data_seen(monkeypatch, unlike, engine, IN_LINKS[fault])


@pytest.mark.parametrize("fault", IN_ROTORS)
@pytest.mark.parametrize("engine", ENGINES)
def test_wrong_rotors_are_seen(monkeypatch, unlike, engine, fault):
    assert_data_seen(monkeypatch, unlike, engine, IN_ROTORS[fault])


IN_READING = {
    "roll and yaw swapped": ("urdf:_Reader._placement", "roll, pitch, yaw", "yaw, pitch, roll"),
    "rotation's sense": ("urdf:_about", "= s, -s", "= -s, s"),
    "inertia not turned": (
        "urdf:_Reader.link",
        "placement.rotation @ own @ placement.rotation.T",
        "own",
    ),
    "products of inertia swapped": (
        "urdf:_Reader.link",
        '"ixy", "ixz"',
        '"ixz", "ixy"',
    ),
    "fixed link not moved out": ("tree:composed", "+ outer.rotation @ inner.position", ""),
    "fixed link's rotation": (
        "tree:composed",
        "outer.rotation @ inner.rotation",
        "inner.rotation @ outer.rotation",
    ),
    "Steiner's sign": ("tree:_merged", "- np.outer", "+ np.outer"),
    "com of a fixed link not turned": ("tree:_parts", "turn @ own.com", "own.com"),
    "inertia of a fixed link not turned": (
        "tree:_parts",
        "turn @ own.inertia @ turn.T",
        "own.inertia",
    ),
    "axis in the parent's frame": (
        "urdf:_Reader._axis",
        "return axis / length",
        "return np.roll(axis, 1) / length",
    ),
}


@pytest.mark.parametrize("fault", IN_READING)
def test_what_the_reader_gets_wrong_pinocchio_reads_right(monkeypatch, unlike, fault):
    place, old, new = IN_READING[fault]
    edit(f"crosscheck.models.robot.{place}", old, new)(monkeypatch)
    again = robot(unlike.urdf, tip="tool")
    assert seen(again)


ANALYTIC, PIN, EXUDYN = (
    "crosscheck.analytic.robot.model:AnalyticRobot.",
    "crosscheck.models.pinocchio.robot:PinocchioRobot.",
    "crosscheck.models.exudyn.robot:ExudynRobot.",
)
TOOTH_FORCE = "crosscheck.models.pinocchio.robot:_tooth_force"
TEETH_OF_EXUDYN = "crosscheck.models.exudyn.robot:_teeth"
IN_CODE = [
    (ANALYTIC + "_held", "moment += _cross(rate.angular", "moment -= _cross(rate.angular"),
    (ANALYTIC + "_held", "_carried(rate, pose.arm)", "rate.acceleration"),
    (ANALYTIC + "_held", "speed * turned", "0 * turned"),
    (ANALYTIC + "_held", "growth * spin", "0 * spin"),
    (ANALYTIC + "_poses", "_cross(turning, arm)", "0"),
    (ANALYTIC + "__init__", "turns = rotor.ratio *", "turns = 1.01 * rotor.ratio *"),
    (ANALYTIC + "_spin", "turns + _power", "turns - _power"),
    (ANALYTIC + "_spin", "frame.placement.rotation @ rotor.axis", "rotor.axis"),
    (ANALYTIC + "_rates", "2 * turned", "turned"),
    (ANALYTIC + "_rates", "under.angular_rate + turned", "under.angular_rate"),
    (ANALYTIC + "_poses", "+ value[:, None] * axis", ""),
    (ANALYTIC + "_poses", "np.sin(value)", "-np.sin(value)"),
    (ANALYTIC + "_weight", "-np.sum", "np.sum"),
    (ANALYTIC + "tip", "+ pose.rotation @ frame.placement.position", ""),
    ("crosscheck.analytic.robot.model:_carried", "+ _cross(rate.angular_rate, arm)", ""),
    (ANALYTIC + "__init__", "1 / rotor.mesh.pinion", "rotor.mesh.pinion"),
    (ANALYTIC + "__init__", "= turns / rotor.ratio", "= turns"),
    (ANALYTIC + "__init__", "if rotor.joint in free:", "if False:"),
    (ANALYTIC + "_mass", "WITH_ROTORS", '("coupled",)'),
    (ANALYTIC + "_held", "WITH_ROTORS", '("coupled",)'),
    (ANALYTIC + "_pressed", "x - np.clip(x, -play, play)", "x"),
    (ANALYTIC + "_pressed", "np.where(np.abs(x) > play, force, 0.0)", "force"),
    (ANALYTIC + "_pressed", "+= mesh.damping", "-= mesh.damping"),
    (ANALYTIC + "_pressed", "force = mesh.stiff", "force = -mesh.stiff"),
    (ANALYTIC + "energy", "-= body.mass", "+= body.mass"),
    (ANALYTIC + "energy", "pose.position + pose.arm", "pose.position"),
    (ANALYTIC + "energy", ").sum(axis=1) / 2", ").sum(axis=1)"),
    (ANALYTIC + "momentum", "np.cross(pose.position + pose.arm", "np.cross(pose.position"),
    (ANALYTIC + "momentum", "_times(inertia, _times", "0 * _times(inertia, _times"),
    (ANALYTIC + "momentum", "total[:, :3] += linear", "total[:, :3] -= linear"),
    (ANALYTIC + "momentum", "WITH_ROTORS", '("coupled",)'),
    (ANALYTIC + "inverse_dynamics", "+ self._pressed(q, v)", ""),
    (ANALYTIC + "forward_dynamics", "+ self._pressed(q, v)", ""),
    (PIN + "_added", "rotor.inertia * np.outer(axis, axis)", "rotor.inertia * np.eye(3)"),
    (PIN + "_added", "frame.parentJoint, spin", "0, spin"),
    (PIN + "_added", "frame.placement.rotation @ rotor.axis)", "rotor.axis)"),
    (PIN + "__init__", "rotor.inertia * rotor.ratio**2", "rotor.inertia * rotor.ratio"),
    (PIN + "_placed", "+ self._offset", ""),
    (PIN + "forward_dynamics", "self._given - held", "self._given + held"),
    (PIN + "energy", "/ 2", ""),
    (PIN + "energy", "+ rates**2 @ self._tree.armature / 2", ""),
    (PIN + "momentum", "central.angular + np", "central.angular - np"),
    (PIN + "__init__", "1 / rotor.mesh.pinion", "rotor.mesh.pinion"),
    (PIN + "__init__", "place] = 1 / rotor.ratio", "place] = 1.0"),
    (PIN + "__init__", "[free.index(rotor.joint)] = 0.0", "[free.index(rotor.joint)] += 0.0"),
    (PIN + "__init__", "column, turned, moved[rotor.joint]", "column, turned, turned"),
    (PIN + "_pushes", "(turned, -moment)", "(turned, moment)"),
    (PIN + "_pushes", "ratio * moment", "moment"),
    (PIN + "_pushes", "-= self._data", "+= 0 * self._data"),
    (PIN + "_pushes", ".act(wrench)", ".actInv(wrench)"),
    (PIN + "_pushes", "* mesh.pinion_base_radius_m", ""),
    (TOOTH_FORCE, "else x + mesh", "else x - mesh"),
    (TOOTH_FORCE, "x - mesh.backlash_m if", "x if"),
    (TOOTH_FORCE, "* deflection +", "* deflection -"),
    (TOOTH_FORCE, "return 0.0", "return mesh.damping_N_s_per_m * rate"),
    (EXUDYN + "_link", "own.T @ body.com", "body.com"),
    (EXUDYN + "_link", "own.T @ body.inertia @ own", "body.inertia"),
    (EXUDYN + "_link", "rotation @ own,", "rotation,"),
    (EXUDYN + "_rotor", "np.diag([0.0, 0.0, rotor.inertia])", "rotor.inertia * np.eye(3)"),
    (EXUDYN + "energy", "-= part.mass", "+= part.mass"),
    (EXUDYN + "energy", "v) / 2", "v)"),
    (EXUDYN + "momentum", "* np.cross(at, velocity)", "* np.cross(velocity, at)"),
    (EXUDYN + "momentum", "rotation.reshape(3, 3) @", ""),
    (EXUDYN + "momentum", "= part.mass * velocity", "= velocity"),
    (EXUDYN + "_sensors", "part.com, kind", "0 * part.com, kind"),
    (EXUDYN + "_rotor", "stator.mass - count * mass", "stator.mass"),
    (EXUDYN + "_rotor", "count = 2 if mesh", "count = 1 if mesh"),
    (EXUDYN + "_rotor", "inertia=0 * spinning", "inertia=spinning"),
    (EXUDYN + "_rotor", "parent=len(parts)", "parent=frame.body"),
    (EXUDYN + "_rotor", "rotation=np.eye(3), position=at", "position=at"),
    (EXUDYN + "__init__", "1 / rotor.mesh.pinion", "rotor.mesh.pinion"),
    (EXUDYN + "__init__", "turned: 1 / rotor.ratio", "turned: 0.0"),
    (EXUDYN + "__init__", "{shaft: 1 / rotor.ratio", "{shaft: 1.0"),
    (TEETH_OF_EXUDYN, "- play, 0.0)", ", 0.0)"),
    (TEETH_OF_EXUDYN, "+ min(ahead + play, 0.0)", ""),
    (TEETH_OF_EXUDYN, "-lever * (", "lever * ("),
    (TEETH_OF_EXUDYN, "pressed + damped", "pressed - damped"),
    (TEETH_OF_EXUDYN, "if pressed:", "if True:"),
    (TEETH_OF_EXUDYN, "lever * rates[place]", "rates[place]"),
    (EXUDYN + "_rotor", "com = stator.com", "com = 2 * stator.com"),
    (EXUDYN + "_within", "back @ position", "position"),
    (EXUDYN + "_held", "-system", "+system"),
    (EXUDYN + "__init__", "added if level", "0 * added if level"),
]


@pytest.mark.parametrize(("place", "old", "new"), IN_CODE)
def test_a_wrong_line_of_an_engine_is_seen(monkeypatch, unlike, place, old, new):
    edit(place, old, new)(monkeypatch)
    assert seen(unlike)


WHERE_ALL_MOVE = [
    (PIN + "forward_dynamics", "torques @ self._motors", "torques @ self._given.T"),
    (PIN + "forward_dynamics", "effort, *push", "effort"),
    (PIN + "forward_dynamics", "solve(self._given, ", "solve(np.abs(self._given), "),
]


@pytest.mark.parametrize(("place", "old", "new"), WHERE_ALL_MOVE)
def test_a_wrong_line_is_seen_where_every_joint_of_the_tree_moves(
    monkeypatch, all_sprung, place, old, new
):
    assert seen(all_sprung) == set()
    edit(place, old, new)(monkeypatch)
    assert seen(all_sprung)
