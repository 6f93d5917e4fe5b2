"""What the pictures of a cost show, read back and held against the record."""

from collections.abc import Iterator

import numpy as np
import pytest

from crosscheck.cost import output
from crosscheck.cost.shortcuts import ShortcutCosts

SHORTCUTS = ("links", "armature")


<<<<<<< HEAD
=======
def _is_number(shown: str, value: float, digits: int, least: float = 0.0) -> bool:
    """Whether a text is the value to so many digits, or says that it is below the least."""
    if shown.startswith("below "):
        return 0 < value <= float(shown.removeprefix("below ")) * (1 + 1e-9) <= least * (1 + 1e-9)
    if not re.fullmatch(r"[\d.]+", shown):
        return False
    if value == 0:
        return float(shown) == 0
    last = 10.0 ** (np.floor(np.log10(abs(value))) - digits + 1)
    return bool(abs(float(shown) - value) <= 0.5000001 * last)


def is_amount(shown: str, value: float, unit: str) -> bool:
    """Whether a text is a quantity in a unit, to three digits and without an exponent."""
    if shown == "diverged":
        return bool(np.isinf(value))
    found = re.fullmatch(r"((?:below )?[\d.]+) ([kmµn]?)" + unit, shown)
    if found is None:
        return False
    factor = PREFIX[found.group(2)]
    shown_number = float(found.group(1).removeprefix("below "))
    readable = shown_number < 1000 or factor == 1e3
    return readable and _is_number(found.group(1), value / factor, 3, 1.0 if factor < 1e-6 else 0.0)


def is_share(shown: str, value: float) -> bool:
    """Whether a text is a share in per cent."""
    digits = 2 if value < 0.995 else 3
    return shown.endswith(" %") and _is_number(shown[:-2], 100 * value, digits, 0.001)


def _right(pattern: str, text: str, *wanted: tuple[object, ...]) -> bool:
    """Whether a text matches, and its groups are what is wanted: (value, unit), or a name."""
    found = re.fullmatch(pattern, text)
    if found is None or len(found.groups()) != len(wanted):
        return False
    return all(_is(shown, *each) for shown, each in zip(found.groups(), wanted, strict=True))


def _is(shown: str, value: object, unit: object = None) -> bool:
    if unit is None:
        return shown == str(value)
    assert isinstance(value, float)
    if unit == "%":
        return is_share(shown, value)
    return _is_number(shown, value, 3) if unit == "" else is_amount(shown, value, str(unit))


def wrong_terminal(found: ShortcutCosts) -> Iterator[str]:
    """Lines of the terminal that there should be and are not."""
    told = list(output.describe_result(found))
    for pattern, *wanted in _lines(found):
        right = [line for line in told if _right(pattern, line, *wanted)]
        if not right:
            yield f"no line {pattern} of {wanted}"
        else:
            told.remove(right[0])
    identity = _identity(found)
    told = [line for line in told if line not in identity]
    if not identity <= set(output.describe_result(found)):
        yield f"nothing of {identity}"
    motion = found.motion
    if isinstance(motion, SineMotion):
        began = f"motion: sums of sines of seed {motion.seed}, period {motion.period:.3g} s"
    else:
        began = f"motion: {motion.where}, {motion.last - motion.first:.3g} s"
    if not any(line.startswith(began) for line in told):
        yield f"no line {began}"
    notes = ("", f"motion: {motion}; end effector: {found.robot.tip}", *found.beyond)
    left = [line for line in told if line not in notes]
    if left != [f"note: {line}" for line in _notes(found)] or not set(notes) <= set(told):
        yield f"lines that say something else: {left}"


def _identity(found: ShortcutCosts) -> set[str]:
    """The sentence on joints whose stator is on the link before, along the axis, by Pinocchio."""
    robot = found.robot
    model = pin.buildModelFromXML(robot.urdf)
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    names, rotors = [], {rotor.joint for rotor in robot.rotors}
    for rotor in robot.rotors:
        joint, stator = robot.joints[rotor.joint], model.getFrameId(rotor.stator)
        number = model.getJointId(joint.name)
        along = data.oMi[number].rotation @ joint.axis
        sine = np.linalg.norm(np.cross(along, data.oMf[stator].rotation @ rotor.axis))
        before = model.frames[stator].parentJoint == model.parents[number]
        if joint.kind == "revolute" and before and sine < 1e-4:
            names.append(joint.name)
    if not names:
        return set()
    several = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
    where = "every joint" if len(names) == len(rotors) else several
    return {
        f"These costs assume link parameters from CAD. At {where} the stator is on the link before"
        " the joint, with its axis along the joint's, so links identified with an armature model"
        " already absorb this coupling. Such links may be physically impossible."
    }


def _notes(found: ShortcutCosts) -> list[str]:
    """Which joints have no gears, which follow others, and what of the files is not used."""
    robot = found.robot
    driven = {part.joint for part in (*robot.rotors, *robot.stages)}
    direct = [joint.name for number, joint in enumerate(robot.joints) if number not in driven]
    follow = [joint.name for joint in robot.joints if joint.mimic]
    told = [f"without gears: {', '.join(direct)}"] if direct else []
    told += [f"follow other joints: {', '.join(follow)}"] if follow else []
    return [*told, *robot.notes]


def _lines(found: ShortcutCosts) -> Iterator[tuple]:
    for level, head in (
        ("links", f"Leaving the rotors out of {found.robot.name}"),
        ("armature", "Counting them as armature only"),
    ):
        shares = {each.joint: each.share for each in found.by_joint if each.level == level}
        (away,) = (tip.distances for tip in found.tips if tip.level == level)
        most = max(shares.values())
        worst = [joint for joint, share in shares.items() if share >= 0.9 * most]
        several = ", ".join(worst[:-1]) + " and " + worst[-1]
        whose = "s of every joint are" if len(worst) == len(shares) else f"s of {several} are"
        whose = f" of {worst[0]} is" if len(worst) == 1 else whose
        yield (
            rf"{head}: the torque{whose} wrong by up to ({SHARE}) of the largest, and after 1 s of"
            rf" feed-forward {found.robot.tip} is ({AMOUNT}) off \(median of (\d+) runs,"
            rf" ({AMOUNT}) at most\)\.",
            (most, "%"),
            (float(np.median(away)), "m"),
            (len(away),),
            (float(away.max()), "m"),
        )
    digits = int(-np.log10(max(each.measured for each in found.agreement)))
    yield (
        r"(\w+) programs agree on this robot to (\d+) digits: analytic, pinocchio and exudyn, on"
        r" (\d+) quantities, (\d+) levels and (\d+) states\.",
        ("Three",),
        (min(digits, 15),),
        (len({each.quantity for each in found.agreement}),),
        (len({each.about.key.case for each in found.agreement}),),
        (found.extent.states,),
    )
    pairs = [f"{pair.at} by {pair.by} \\(({SHARE})\\)" for pair in found.pairs[:3]]
    yield (
        rf"What armature leaves out, rms, of the largest torque: {', '.join(pairs)}\.",
        *((pair.share, "%") for pair in found.pairs[:3]),
    )
    small = max(each.share for each in found.by_joint if each.level == "armature") < 0.01
    yield (
        rf"This coupling would {'still ' if small else ''}be below 1 % of every joint's largest"
        r" torque with all ratios ([\d.]+) times as large, if the reflected inertias are kept\.",
        (found.factor, ""),
    )
    assert found.geared
    for mesh in found.geared.meshes:
        yield (
            rf"The {mesh.name}, rigid at coupled, has a backlash of ({AMOUNT}), a wind-up of"
            rf" ({AMOUNT}) at most, and swings at ({AMOUNT}) or more\.",
            (mesh.backlash, mesh.unit),
            (mesh.windup, mesh.unit),
            (mesh.slowest, "Hz"),
        )
    away = found.geared.distances
    if away is None:
        yield (
            rf"No run of the level geared: ({AMOUNT}) ask for (\d+) steps a second\.",
            (found.geared.steps * 0.4 / (2 * np.pi), "Hz"),
            (found.geared.steps,),
        )
    else:
        yield (
            r"With teeth that give way, under the torques of coupled, the end effector is"
            rf" ({AMOUNT}) off \(median of (\d+) runs, ({AMOUNT}) at most\)\.",
            (float(np.median(away)), "m"),
            (len(away),),
            (float(away.max()), "m"),
        )


def wrong_json(found: ShortcutCosts) -> Iterator[str]:
    """Parts of the JSON that are not those of the record."""
    data = json.loads(output.cost_json(found))
    told = list(output.describe_result(found))
    limits = [found.robot.joints[number].limits for number in found.robot.coordinates]
    names = found.names, found.units, found.largest, found.by_rates, limits
    geared = found.geared
    wanted: dict[str, object] = {
        "robot": found.robot.name,
        "answers": told[: told.index("")],
        "engines_agree": True,
        "engines": [
            {
                "quantity": each.quantity.replace("_", " "),
                "level": each.about.key.case.split("/")[1],
                "left": each.left.split(":")[0],
                "right": each.right.split(":")[0],
                **{key: getattr(each, key) for key in ("measured", "tolerance")},
                "failure": "",
            }
            for each in found.agreement
        ],
        "states": found.extent.states,
        "seed": found.seed,
        "motion": {
            "from": str(found.motion),
            "beyond_limits": list(found.beyond),
            "instants": found.extent.instants,
        },
        "tip": found.robot.tip,
        "joints": [
            {
                "joint": name,
                "unit": unit,
                "largest_torque": largest,
                "coupling_by_rates_rms": by_rates,
                "limits": {
                    key: None if np.isinf(getattr(own, key)) else getattr(own, key)
                    for key in ("lower", "upper", "velocity", "effort")
                },
            }
            for name, unit, largest, by_rates, own in zip(*names, strict=True)
        ],
        "shortcuts": [
            {
                "joint": each.joint,
                "level": each.level,
                "largest_error": each.largest,
                "rms_error": each.rms,
                "share_of_largest_torque": each.share,
            }
            for each in found.by_joint
        ],
        "feed_forward": [
            {"level": tip.level, "distances_m": tip.distances.tolist()} for tip in found.tips
        ],
        "pairs": [
            {"joint": pair.at, "by": pair.by, "rms": pair.rms, "share": pair.share}
            for pair in found.pairs
        ],
        "ratios": [
            {
                "rotor_of": each.joint,
                "ratio": each.ratio,
                "most_in": each.at,
                "share": each.share,
                "negligible_from": each.enough,
            }
            for each in found.ratios
        ],
        "geared": geared
        and {
            "meshes": [
                {
                    "mesh": mesh.name,
                    **{key: getattr(mesh, key) for key in ("joint", "unit", "backlash", "windup")},
                    "slowest_Hz": mesh.slowest,
                    "fastest_Hz": mesh.fastest,
                }
                for mesh in geared.meshes
            ],
            "steps": geared.steps,
            "distances_m": None if geared.distances is None else geared.distances.tolist(),
        },
        "negligible_share": 0.01,
        "negligible_with_ratios_times": found.factor,
        "notes": _notes(found),
    }
    for each in data["engines"]:
        each.pop("size")
    for key in ("schema_version", "program"):
        data.pop(key)
    for key in wanted.keys() | data.keys():
        if data.get(key) != wanted.get(key):
            yield f"JSON {key}: {data.get(key)} for {wanted.get(key)}"


def tables(page: str) -> list[list[list[str]]]:
    """The cells of a page's tables, without their heads."""
    return [
        [
            [html.unescape(cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row, re.DOTALL)]
            for row in re.findall(r"<tr>(.*?)</tr>", table, re.DOTALL)[1:]
        ]
        for table in re.findall(r"<table>(.*?)</table>", page, re.DOTALL)
    ]


def _wrong_rows(
    what: str, rows: Sequence[Sequence[str]], wanted: Sequence[Sequence[tuple]]
) -> Iterator[str]:
    if [len(row) for row in rows] != [len(row) for row in wanted]:
        yield f"page, {what}: {rows} for {wanted}"
        return
    for row, own in zip(rows, wanted, strict=True):
        if not all(_is(shown, *each) for shown, each in zip(row, own, strict=True)):
            yield f"page, {what}: {row} for {own}"


def _columns(found: ShortcutCosts) -> list[list[str]]:
    """What heads the columns of the page's tables."""
    share = "share of the largest torque"
    by_level = [[f"{level}: largest error", "rms", share] for level in SHORTCUTS]
    runs = [f"run {number + 1}" for number in range(found.extent.runs)]
    return [
        ["joint", "largest torque", *by_level[0], *by_level[1]],
        ["torques of", *runs],
        ["torque in", "by the acceleration of", "rms", share],
        ["rotor of", "ratio", "largest share", "in", "below 1 % from a ratio of"],
        ["mesh", "backlash", "largest wind-up", "slowest swing", "fastest swing"],
        ["quantity", *LEVELS, "tolerance", "relative to"],
    ]


def wrong_page(found: ShortcutCosts) -> Iterator[str]:
    """Cells of the page's tables, and sentences, that are not those of the record."""
    geared, drawing = found.geared, "<svg>drawn in another guard</svg>"
    assert geared
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "to_svg", lambda figure: drawing)
        page = output.cost_page(found)
    if drawing not in page:
        yield "page: no picture"
    torques, tips, pairs, ratios, meshes, engines = tables(page)
    said = html.unescape(page)
    told = list(output.describe_result(found))
    columns = _columns(found)
    if heads_of(page) != columns:
        yield f"page: columns {heads_of(page)} for {columns}"
    for line in (
        f"<title>Cost of shortcuts: {found.robot.name}</title>",
        f"<h1>Cost of shortcuts: {found.robot.name}</h1>",
        f"<p><strong>{told[1]}</strong></p>",
        f"<p>{found.robot.title or 'What the usual models of its gears leave out'}. In the",
        *(f"<b>{level}</b>: {words}" for level, words in LEVELS.items()),
    ):
        if line not in said:
            yield f"page does not have {line}"
    missing = [line for line in (*told[: told.index("")], *found.beyond) if line not in said]
    if missing:
        yield f"page says nothing of {missing}"
    for quantity, *cells in engines:
        own = [each for each in found.agreement if each.quantity == quantity.replace(" ", "_")]
        right = [
            max(each.measured for each in own if each.about.key.case == case)
            for case in dict.fromkeys(each.about.key.case for each in own)
        ]
        shown = [f"{value:.1e}" for value in (*right, max(each.tolerance for each in own))]
        if cells[:-1] != shown:
            yield f"page, {quantity}: {cells} for {shown}"
    if len(engines) != 9:
        yield "page: quantities are missing"
    units = dict(zip(found.names, found.units, strict=True))
    by = {(each.level, each.joint): each for each in found.by_joint}
    yield from _wrong_rows(
        "torques",
        torques,
        [
            [
                (name,),
                (float(most), units[name]),
                *(
                    cell
                    for own in (by[level, name] for level in SHORTCUTS)
                    for cell in (
                        (own.largest, units[name]),
                        (own.rms, units[name]),
                        (own.share, "%"),
                    )
                ),
            ]
            for name, most in zip(found.names, found.largest, strict=True)
        ],
    )
    rows = [[(tip.level,), *((float(x), "m") for x in tip.distances)] for tip in found.tips]
    yield from _wrong_rows("tips", tips, rows)
    rows = [
        [(pair.at,), (pair.by,), (pair.rms, units[pair.at]), (pair.share, "%")]
        for pair in found.pairs[:6]
    ]
    yield from _wrong_rows("pairs", pairs, rows)
    rows = [
        [
            *((each.joint,), (f"{each.ratio:g}",), (each.share, "%")),
            *(((each.at,), (each.enough, "")) if each.share else (("",), ("any",))),
        ]
        for each in found.ratios
    ]
    yield from _wrong_rows("ratios", ratios, rows)
    rows = [
        [
            *((mesh.name,), (mesh.backlash, mesh.unit), (mesh.windup, mesh.unit)),
            *((mesh.slowest, "Hz"), (mesh.fastest, "Hz")),
        ]
        for mesh in geared.meshes
    ]
    yield from _wrong_rows("meshes", meshes, rows)
    last = said[said.index("What does a rigid gear leave out?") :]
    if not re.search(rf"\b{geared.steps} steps", last):
        yield "page: another number of steps"
    if geared.distances is not None:
        shown = re.findall(AMOUNT, last[last.index("from the plan:") :])[: len(geared.distances)]
        if not all(is_amount(*each, "m") for each in zip(shown, geared.distances, strict=True)):
            yield f"page, geared: {shown} for {geared.distances}"
    if (
        f"{found.extent.runs} instants" not in said
        or f"{found.extent.states} random states" not in said
    ):
        yield "page: another number of runs or states"


>>>>>>> main
def wrong_picture(found: ShortcutCosts) -> Iterator[str]:
    """Curves that are not those of the record, or of a colour that means something else."""
    figure = output.draw_torques(found)
    colours: dict[str, set] = {}
    for left, right in zip(figure.axes[::2], figure.axes[1::2], strict=True):
        name, unit = left.get_ylabel().split("\n")
        joint = found.names.index(name)
        torque = found.torques[:, joint]
        wanted = {
            "coupled": torque,
            "links": torque + found.errors["links"][:, joint],
            "armature minus coupled": found.errors["armature"][:, joint],
        }
        drawn = {line.get_label(): line for line in (*left.get_lines(), *right.get_lines())}
        if unit != f"[{found.units[joint]}]" or drawn.keys() != wanted.keys():
            yield f"picture: {name}, {unit}, {list(drawn)}"
            continue
        for label, line in drawn.items():
            colours.setdefault(line.get_color(), set()).add(label)
            curve = np.column_stack([found.time, wanted[label]])
            if not np.array_equal(line.get_xydata(), curve):
                yield f"picture: {label} of {name}"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(output, "MOST_DRAWN", 1)
        (name, _) = output.draw_torques(found).axes[0].get_ylabel().split("\n")
    (dots,) = output.draw_shares(found).axes
    names = [label.get_text() for label in dots.get_yticklabels()]
    for level, line in zip(SHORTCUTS, dots.get_lines(), strict=True):
        own = {each.joint: 100 * each.share for each in found.by_joint if each.level == level}
        shown = {names[row]: x for x, row in zip(*line.get_data(), strict=True)}
        if shown != own or line.get_color() != output.COLOURS[level]:
            yield f"picture: dots of {level}: {shown} for {own}"
    by = {each.joint: each.share for each in found.by_joint if each.level == "armature"}
    if by[name] != max(by.values()):
        yield f"picture: {name} where there is room for one"
    if len(figure.axes) != 2 * min(8, len(found.names)) or any(
        len(own) > 1 for own in colours.values()
    ):
        yield f"picture: {len(figure.axes)} axes, {colours}"
