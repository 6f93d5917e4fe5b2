"""What is wrong with the numbers of a comparison, by the second program, and with its views."""

import html
import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from crosscheck.models.arm.arm import Arm
from crosscheck.models.interface import Model
from crosscheck.models.loading import load_scenario, validate_record
from crosscheck.provenance import ROOT
from crosscheck.recordings import compare as comparison
from crosscheck.recordings import engines, friction, output, smoothing
from crosscheck.recordings.compare import EngineDisagreement, RecordComparison, Repair, compare
from crosscheck.recordings.forward import Window
from crosscheck.recordings.friction import FrictionFit
from crosscheck.recordings.gravity import GravityEstimate, GravityFit
from crosscheck.recordings.parameters import Estimate, find_parameters
from crosscheck.recordings.record import Record, read_record
from crosscheck.recordings.residual import NormalEquations
from crosscheck.registry import LEVELS as RIGID_WORDS
from crosscheck.registry import RIGID_LEVELS
from tests.faults.views import heads_of
from tests.measured import second

# Slopes by differences over 1e-6 rad leave 1e-8 of chi squared; and runs' own uncertainties, which
# are differences of runs, 1e-8 of themselves.
RELATIVE = 1e-6
TOLERANCES = {"arm.payload_mass_kg": 0.01}
RIGHT, HEAVY, RUBBING, TILTED = "right", "heavy", "rubbing", "tilted"
TILT_RAD = 0.05


@lru_cache
def content() -> dict[str, Any]:
    """An arm of two unlike geared joints with friction and gravity, as its file has it."""
    text = (ROOT / "models" / "arms" / "three-unlike.toml").read_text(encoding="utf-8")
    found = tomllib.loads(text)
    return found | {"joints": found["joints"][:2], "links": found["links"][:2], "name": "unlike"}


@lru_cache
def arm() -> Arm:
    """The same, validated."""
    return validate_record(Arm, content(), "unlike")


@lru_cache
def measured(kind: str) -> tuple[RecordComparison, second.Numbers]:
    """A record as the file has it, with more payload, Coulomb friction or a tilt; both programs."""
    given = second.with_value(content(), "arm.payload_mass_kg", 5.1 if kind == HEAVY else 5.0)
    if kind == TILTED:
        turned = complex(*content()["gravity_m_per_s2"]) * np.exp(1j * TILT_RAD)
        given = {**given, "gravity_m_per_s2": [turned.real, turned.imag]}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        second.write_record(path, given, "coupled", 4.0 if kind == RUBBING else 0.0)
        numbers = second.Numbers(path, content(), TOLERANCES)
        record = read_record(path, 2)
    found = compare(record, arm(), None, TOLERANCES, lambda *doing: None)
    assert isinstance(found, RecordComparison)
    return found, numbers


@lru_cache
def right_windows(kind: str) -> list[dict[str, Any]]:
    """Of the second program."""
    return measured(kind)[1].windows(measured(kind)[1].best)


def data_of(found: RecordComparison | EngineDisagreement) -> dict[str, Any]:
    """The comparison's JSON file, read."""
    data: dict[str, Any] = json.loads(output.comparison_json(found))
    return data


def apart(name: str, said: Any, right: Any, relative: float = RELATIVE) -> Iterator[str]:
    """A line where two numbers, or rows of numbers, differ."""
    one, other = np.asarray(said, dtype=float), np.asarray(right, dtype=float)
    if one.shape != other.shape or not np.allclose(one, other, rtol=relative, atol=0.0):
        yield f"{name}: {said}, must be {right}"


def wrong_smoothing(data: Mapping[str, Any], right: second.Numbers) -> Iterator[str]:
    """Of the splines and their noise."""
    yield from apart("knots", data["knot_spacing_s"], right.spacing_s)
    yield from apart("rows", data["rows"], len(right.time))
    yield from apart("angles", data["angle_noise_rad"], right.mean_noise("angle_noise"))
    yield from apart("torques", data["torque_noise_N_m"], right.mean_noise("torque_noise"))


def wrong_levels(data: Mapping[str, Any], right: second.Numbers) -> Iterator[str]:
    """Of the levels, their order and what follows from it."""
    order = sorted(right.surprise, key=lambda name: right.surprise[name])
    if [level["level"] for level in data["levels"]] != order:
        yield f"order: {data['levels']}, must be {order}"
        return
    for said in data["levels"]:
        name, own = said["level"], right.levels[said["level"]]
        yield from apart(f"{name} chi2", said["chi2"], own.chi2)
        yield from apart(f"{name} freedom", said["degrees_of_freedom"], own.freedom)
        ratio = said["likelihood_ratio_of_the_best"]
        yield from apart(f"{name} ratio", ratio, right.ratio(name), 1e-4)
        yield from apart(f"{name} residual", said["residual_rms_N_m"], own.residual)
        yield from apart(f"{name} noise", said["of_noise_rms_N_m"], own.noise)
    best = right.levels[right.best]
    yield from apart("own chi2", data["own_chi2"], best.chi2)
    yield from apart("own freedom", data["own_degrees_of_freedom"], best.freedom)
    explained = best.chi2 / best.freedom <= 1 + 4 * np.sqrt(2 / best.freedom)
    near = [name for name in order if right.ratio(name) < 100]
    if (data["explained"], data["candidates"]) != (explained, near):
        yield f"verdict: {data['explained']}, {data['candidates']}; must be {explained}, {near}"
    if data["decided"] != (explained and len(near) == 1):
        yield "decided"


def wrong_limits(found: RecordComparison) -> Iterator[str]:
    """Of what counts as noise and as likely, just within the limits and just beyond."""
    freedom = found.residual_freedom
    noise = freedom * (1 + 4 * np.sqrt(2 / freedom))
    best, other = found.levels[0], found.levels[1]
    for factor, within in ((0.999, True), (1.001, False)):
        if replace(found, residual_chi2=factor * noise).explained != within:
            yield f"chi squared {factor} of the limit of noise"
        levels = best, replace(other, ratio=factor * 100)
        if (other.name in replace(found, levels=levels).candidates) != within:
            yield f"likelihood {factor} of the limit"


def wrong_estimates(data: Mapping[str, Any], right: second.Numbers) -> Iterator[str]:
    """Of the parameters alone, together and of what explains the record."""
    best = right.best
    moved = {path for path, own in right.columns(best).items() if np.any(own)}
    said = [each["path"] for each in data["parameters_alone"]]
    if set(said) != moved:
        yield f"parameters: {said}, must be {moved}"
        return
    falls = [each["chi2_falls_by"] for each in data["parameters_alone"]]
    if falls != sorted(falls, reverse=True):
        yield "the order of the parameters"
    for each in data["parameters_alone"]:
        yield from _estimate(each, right.alone(best, each["path"]))
    chosen = [each["path"] for each in data["parameters_together"]]
    for each in data["parameters_together"]:
        yield from _estimate(each, right.together(best, chosen)[each["path"]])
    yield from apart("condition", data["condition_number"], right.condition(best, chosen))
    for path in moved - set(chosen):
        shares, left = right.mixture(best, chosen, path)
        if left > 1e-4:
            yield f"{path} is left out"
        held = [each["holds"].get(path, 0.0) for each in data["parameters_together"]]
        small = np.abs(shares) < 1e-9
        yield from apart(f"{path} in others", held, np.where(small, 0.0, shares))
    for each in data["explained_by"]:
        yield from _estimate(each, right.alone(each["level"], each["path"]))


def _estimate(said: Mapping[str, Any], right: Mapping[str, float]) -> Iterator[str]:
    for name, value in right.items():
        yield from apart(f"{said['path']} {name}", said[name], value)


def wrong_frictions(data: Mapping[str, Any], right: second.Numbers) -> Iterator[str]:
    """Of the friction that explains the record."""
    for said in data["explained_by_friction"]:
        found, better = right.friction(said["level"])
        yield from apart("friction falls by", said["chi2_falls_by"], better)
        left = found["coulomb 0"]["chi2_per_degree_of_freedom_left"]
        yield from apart("friction leaves", said["chi2_per_degree_of_freedom_left"], left)
        for place, joint in enumerate(said["joints"]):
            own = found[f"arm.joints.{place}.friction_N_m_s_per_rad"], found[f"coulomb {place}"]
            half = "half_of_95_percent_interval"
            for name, value in (
                ("joint", place + 1),
                ("viscous_N_m_s_per_rad", own[0]["estimate"]),
                (f"viscous_{half}", own[0][half]),
                ("viscous_in_the_file", own[0]["in_the_file"]),
                ("coulomb_N_m", own[1]["estimate"]),
                (f"coulomb_{half}", own[1][half]),
            ):
                yield from apart(name, joint[name], value)


def wrong_gravities(data: Mapping[str, Any], right: second.Numbers) -> Iterator[str]:
    """Of the gravity that explains the record."""
    for said in data["explained_by_gravity"]:
        own = list(right.gravity(said["level"]).values())
        in_file = right.content["gravity_m_per_s2"]
        half = "half_of_95_percent_interval"
        values = [there + each["estimate"] for there, each in zip(in_file, own, strict=True)]
        yield from apart("gravity", said["gravity_m_per_s2"], values)
        yield from apart("gravity's interval", said[half], [each[half] for each in own])
        yield from apart("gravity in the file", said["in_the_file"], in_file)
        left = "chi2_per_degree_of_freedom_left"
        yield from apart("gravity leaves", said[left], own[0][left])


def wrong_windows(data: Mapping[str, Any], right: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Of the runs: E and the uncertainties of ASME V&V 20."""
    if len(data["windows"]) != len(right):
        yield "number of runs"
        return
    for said, own in zip(data["windows"], right, strict=True):
        for name in said:
            yield from apart(name, said[name], own[name])


NUMBER = re.compile(r"(?<![\w.^])[-+]?(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d+)?(?:e[-+]?\d+)?")


def misread(where: str, text: str, right: Sequence[float]) -> Iterator[str]:
    """A line where the numbers in a text are not the right ones, to the digits that it has."""
    tokens = NUMBER.findall(text.replace("+- ", ""))
    if len(tokens) != len(right):
        yield f"{where}: {text!r} has {len(tokens)} numbers, must have {len(right)}"
        return
    for token, value in zip(tokens, right, strict=True):
        mantissa, _, power = token.replace(",", "").partition("e")
        last = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))
        whole = "." not in mantissa and not power
        digits = len(mantissa.lstrip("-+").rstrip("0")) if whole else 0
        last *= 10.0 ** (len(mantissa.lstrip("-+")) - digits) if digits else 1.0
        if not abs(float(token.replace(",", "")) - value) <= 0.51 * last:
            yield f"{where}: {token} of {text!r}, must be {value}"


def wrong_lines(found: RecordComparison) -> Iterator[str]:
    """Of the terminal, by the JSON file."""
    found = replace(found, windows=(*found.windows, _cut(found.windows[0])))
    data, told = data_of(found), list(output.describe_comparison(found))
    if told[: told.index("")] != data["answer"]:
        yield "the terminal begins with other words than the JSON file"
    yield from _wrong_answer(data)
    rest = iter(told[told.index("") + 1 :])
    for each in data["engines"]:
        right = [each["measured"], each["tolerance"]]
        yield from misread("terminal engine", next(rest), right)
    yield from misread("terminal knots", next(rest), [data["knot_spacing_s"]])
    noises = zip(data["angle_noise_rad"], data["torque_noise_N_m"], strict=True)
    for joint, noise in enumerate(noises, 1):
        yield from misread("terminal noise", next(rest), [joint, *noise])
    for each in data["levels"]:
        right = [*each["residual_rms_N_m"], *each["of_noise_rms_N_m"]]
        right += [each["chi2"] / each["degrees_of_freedom"]]
        line = next(rest)
        if not line.startswith(f"{each['level']}: "):
            yield f"terminal level: {line}"
        yield from misread("terminal level", line, right)
    for each, line in zip(data["parameters_alone"], rest, strict=False):
        yield from misread("terminal estimate", line, _estimate_numbers(each))


def _cut(window: Window) -> Window:
    """The first two thirds of a run: of three unlike ones the median is no mean and no end."""
    rows = slice(2 * len(window.time) // 3)
    parts = (window.time, window.error, window.numerical, window.inputs, window.data)
    return Window(*(part[rows] for part in parts))


def _estimate_numbers(each: Mapping[str, Any]) -> list[float]:
    """As a line of the terminal has them, the place first."""
    shown = ("estimate", "half_of_95_percent_interval", "in_the_file")
    own = [each[name] for name in shown]
    left = each["chi2_per_degree_of_freedom_left"]
    return [*_place(each["path"]), *own[:2], 95, own[2], left]


def _place(path: str) -> list[float]:
    """The number of a joint or link in a path, counted from 1, if there is one."""
    return [int(step) + 1 for step in path.split(".") if step.isdigit()]


def _wrong_answer(data: Mapping[str, Any]) -> Iterator[str]:
    """Of the sentences, where the record fits as it is or with one payload."""
    answer, share = data["answer"], data["own_chi2"] / data["own_degrees_of_freedom"]
    if data["explained_by_friction"]:
        fits = min(
            data["explained_by_friction"], key=lambda each: each["chi2_per_degree_of_freedom_left"]
        )
        right = []
        for each in fits["joints"]:
            right += [each["joint"], each["coulomb_N_m"], each["viscous_N_m_s_per_rad"]]
            right.append(each["viscous_in_the_file"])
        yield from misread("friction", answer[0], right)
        if f"({fits['level']}) with friction" not in answer[0]:
            yield answer[0]
    elif data["explained_by"]:
        (repair,) = data["explained_by"]
        said = f"({repair['level']}) if the {repair['name']} is "
        if said not in answer[0]:
            yield f"{answer[0]}, must have {said}"
        yield from misread("repair", answer[0], [repair["estimate"], repair["in_the_file"]])
        yield from misread("nearest", answer[1], [share])
        if f"nearest is {data['levels'][0]['level']} " not in answer[1]:
            yield answer[1]
    else:
        second_best = min(data["levels"][1:], key=lambda each: each["likelihood_ratio_of_the_best"])
        ratio = second_best["likelihood_ratio_of_the_best"]
        yield from misread("decided", answer[1], [share, min(ratio, 1e12)])
        if f"{second_best['level']}, the next best" not in answer[1]:
            yield answer[1]
    windows = data["windows"]
    stays = np.median([each["stays_s"] for each in windows])
    long = np.median([each["to_s"] - each["from_s"] for each in windows])
    inside = 100 * np.mean([each["within_2_u_val"] for each in windows])
    yield from misread("runs", answer[-1], [len(windows), 3, stays, long, inside, 2])


def wrong_page(found: RecordComparison) -> Iterator[str]:
    """Of the HTML page, by the JSON file."""
    data, page = data_of(found), output.comparison_page(found)
    items = re.findall(r'<p class="answer">(?:<strong>)?(.*?)(?:</strong>)?</p>', page)
    if [html.unescape(item) for item in items] != data["answer"]:
        yield "the page begins with other words than the JSON file"
    time = found.record.time
    lead = re.findall(r'<p class="lead">.*?: (.*?)</p>', page)[0]
    yield from misread("lead", lead, [len(time), time[-1] - time[0]])
    (noise,) = re.findall(r"estimated from the recording\s*\((.*?)\)", page)
    joints = zip(data["angle_noise_rad"], data["torque_noise_N_m"], strict=True)
    right = [number for joint, own in enumerate(joints, 1) for number in (*own, joint)]
    yield from misread("noise", noise, right)
    yield from misread(
        "knots", re.findall(r"knot every ([\d.]+) s", page)[0], [data["knot_spacing_s"]]
    )
    condition = re.findall(r"condition number ([\d.e+]+)", page)[0]
    yield from misread("condition", condition, [data["condition_number"]])
    tables = {
        "engines": [[each["measured"], each["tolerance"]] for each in data["engines"]],
        "levels": [
            [
                each["chi2"] / each["degrees_of_freedom"],
                min(each["likelihood_ratio_of_the_best"], 1e12),
                *each["residual_rms_N_m"],
                *each["of_noise_rms_N_m"],
            ]
            for each in data["levels"]
        ],
        "alone": [
            [*_row(each), each["chi2_per_degree_of_freedom_left"]]
            for each in data["parameters_alone"][:12]
        ],
        "together": [
            [
                *_row(each),
                *(
                    number
                    for path, share in each["holds"].items()
                    for number in (share, *_place(path))
                ),
            ]
            for each in data["parameters_together"]
        ],
        "runs": [
            [
                each["from_s"],
                each["to_s"],
                each["stays_s"],
                100 * each["within_2_u_val"],
                *each["last_E_rad"],
                *each["last_u_val_rad"],
            ]
            for each in data["windows"]
        ],
    }
    if data["explained_by_friction"]:
        tables["friction"] = [
            [
                *(joint[name] for name in FRICTION_COLUMNS),
                each["chi2_per_degree_of_freedom_left"],
            ]
            for each in data["explained_by_friction"]
            for joint in each["joints"]
        ]
    for name, rows in tables.items():
        (table,) = re.findall(rf'<table id="{name}">(.*?)</table>', page, flags=re.S)
        lines = re.findall(r"<tr>(<td.*?)</tr>", table)
        if heads_of(table) != [COLUMNS[name]]:
            yield f"page, {name}: under {heads_of(table)}"
        if len(lines) != len(rows):
            yield f"page, {name}: {len(lines)} rows, must be {len(rows)}"
        for line, row in zip(lines, rows, strict=False):
            cells = [re.sub(r"<.*?>", "", cell) for cell in re.findall(r"<td.*?</td>", line)]
            shown = " | ".join(re.sub(r"\[.*?\]", "", html.unescape(cell)) for cell in cells)
            yield from misread(f"page, {name}", shown, row)
    title = f"<h1>Recording compared with {found.arm.name}</h1>"
    lead = f'<p class="lead">{found.record.where}: {len(time):,} rows, '
    if title not in page or f"{lead}{time[-1] - time[0]:.4g} s; torques from " not in page:
        yield "page: another title or lead"
    said = html.unescape(page)
    for level in found.levels:
        if f"<td>{level.name}</td><td>{RIGID_WORDS[level.name]}</td>" not in said:
            yield f"page: {level.name} is called something else"


LEFT = "chi squared per degree of freedom"
FITTED = ["parameter", "in the file", "estimate", "\u00b1"]
COLUMNS = {
    "engines": ["model", "compared with", "verdict", "difference", "tolerance"],
    "levels": [
        *("level", "what it has", LEFT, "the best is more likely by"),
        *("residual by joint, rms [N m]", "noise in it [N m]"),
    ],
    "alone": [*FITTED, f"{LEFT} with it"],
    "together": [*FITTED, "contains"],
    "friction": [
        *("level", "joint", "Coulomb [N m]", "\u00b1", "viscous [N m s/rad]", "\u00b1"),
        *("viscous in the file", f"{LEFT} with it"),
    ],
    "runs": [
        *("from [s]", "to [s]", "stays within 3 u_val for [s]", "|E| at most 2 u_val at"),
        *("E at the end [rad]", "u_val there [rad]"),
    ],
}
FRICTION_COLUMNS = (
    *("joint", "coulomb_N_m", "coulomb_half_of_95_percent_interval", "viscous_N_m_s_per_rad"),
    *("viscous_half_of_95_percent_interval", "viscous_in_the_file"),
)


def _row(each: Mapping[str, Any]) -> list[float]:
    shown = each["in_the_file"], each["estimate"], each["half_of_95_percent_interval"]
    return [*_place(each["path"]), *shown]


def wrong_pictures(found: RecordComparison, right: second.Numbers) -> Iterator[str]:
    """Of what the figures draw, by the second program."""
    drawn = [(content(), np.zeros(2))]
    if found.repairs:
        (repair,) = found.repairs
        path = repair.estimate.parameter.path
        estimate = right.alone(repair.level, path)["estimate"]
        drawn.append((second.with_value(content(), path, estimate), np.zeros(2)))
    if found.frictions:
        fits = [right.friction(fit.level)[0] for fit in found.frictions]
        estimates = min(fits, key=lambda fit: fit["coulomb 0"]["chi2_per_degree_of_freedom_left"])
        own = content()
        for path in [each for each in estimates if each.startswith("arm.")]:
            own = second.with_value(own, path, estimates[path]["estimate"])
        drawn.append((own, np.array([estimates[f"coulomb {j}"]["estimate"] for j in range(2)])))
    if len(found.curves) != len(drawn):
        yield f"{len(found.curves)} curves, must be {len(drawn)}"
    for curve, (own, coulomb) in zip(found.curves, drawn, strict=False):
        residual, deviation = right.curve(own, curve.level, coulomb)
        for joint in range(2):
            axes = Figure().subplots()
            output.draw_residual(curve, joint, axes)
            yield from _drawn(axes, right.time, residual[:, joint], 2 * deviation[:, joint])


def wrong_possible_frictions() -> Iterator[str]:
    """Of which frictions an arm can have: none that is negative beyond its interval.

    Columns that nothing has in common, and chi squared of noise alone: what is added to the file's
    number is right over square, its interval 1.96 over the root of the square.
    """
    among = find_parameters(arm())
    count = len(among) + 2
    paths = [parameter.path for parameter in among]
    places = [paths.index(f"arm.joints.{j}.friction_N_m_s_per_rad") for j in range(2)]
    places += [len(among), len(among) + 1]
    in_file = [*(among[place].value for place in places[:2]), 0.0, 0.0]
    square = 50.0
    half = 1.959963984540054 / np.sqrt(square)
    for place, value in zip(places, in_file, strict=True):
        for part in (1.02, 0.98):
            right = np.zeros(count)
            right[place] = -(value + part * half) * square
            normal = NormalEquations(square * np.eye(count), right, 1e3, 10_000)
            fit = friction.fit_friction(normal, "coupled", arm(), among)
            if (fit.arm is None) != (part > 1):
                yield f"friction {place} of {part} intervals below 0"


def wrong_order() -> Iterator[str]:
    """Of explanations: frictions first, each kind by what it leaves, none that no arm can have."""
    parameter = find_parameters(arm())[0]
    lefts = [(3.0, arm()), (1.5, arm()), (1.0, None), (2.0, arm())]
    repairs = [
        Repair("coupled", Estimate(parameter, 1.0, 0.1, 9.0, left), own) for left, own in lefts
    ]
    frictions = [FrictionFit("coupled", (), 9.0, left + 4, own) for left, own in lefts]
    none = GravityEstimate(np.zeros(2), np.zeros(2), np.zeros(2))
    gravities = [GravityFit("coupled", none, 9.0, left + 2, own) for left, own in lefts]
    found = comparison._select_possible(repairs, frictions, gravities)
    said = [each.estimate.left if isinstance(each, Repair) else each.left for each in found]
    if said != [5.5, 6.0, 7.0, 3.5, 4.0, 5.0, 1.5, 2.0, 3.0]:
        yield f"explanations that leave {said}"


def wrong_choice() -> Iterator[str]:
    """Of which blocks are looked at where there are many: as far apart as may be, ends included."""
    for count, most in ((3, 10), (10, 10), (101, 11), (23, 4)):
        shown = min(count, most)
        right = [round(n * (count - 1) / (shown - 1)) for n in range(shown)]
        places = smoothing.select_evenly(range(count), most)  # whatever they are
        if places != right:
            yield f"blocks {places} of {count}, must be {right}"


def wrong_witness() -> Iterator[str]:
    """Of who disagrees with first principles, on an arm with weight and friction: Pinocchio asked.

    Each joint's torque is off by just more, and by just less, than a 1e-10 of its terms.
    """
    draw = np.random.default_rng(4)
    state = [size * draw.uniform(-1, 1, 2) for size in (3.0, 2.0, 5.0)]
    friction_of = np.array([joint.friction_N_m_s_per_rad for joint in arm().joints])
    for level in RIGID_LEVELS:
        model = engines.build_rigid_model(level, arm(), "pinocchio")
        still = 0 * state[0]

        def asked(v: np.ndarray, a: np.ndarray, model: Model = model) -> np.ndarray:
            rows = [np.repeat(each[None], 2, axis=0) for each in (state[0], v, a)]
            return np.asarray(model.inverse_dynamics(*rows))[0]

        weight, right = asked(still, still), asked(*state[1:])
        rubbed = friction_of * state[1]
        sizes = np.abs(weight) + np.abs(rubbed)
        sizes += np.abs(asked(state[1], still) - weight - rubbed)
        for joint in np.eye(2):
            sizes += np.abs(asked(still, joint * state[2]) - weight)
        for joint in range(2):
            for part in (1.02, 0.98):
                wrong = right.copy()
                wrong[joint] += part * 1e-10 * sizes[joint]
                given = {"right": right, "wrong": wrong}
                found = engines._find_disagreeing_models(given, arm(), level, state)
                if found != (("wrong",) if part > 1 else ()):
                    yield f"{level}, joint {joint + 1} by {part}: {found} disagree"


def wrong_drive_torques() -> Iterator[str]:
    """Of the torques of a record without any, by the law of a controller."""
    time = np.linspace(0.0, 2.0, 2001)
    waves = np.outer(time, [3.0, 5.0])
    record = Record("file", time, 0.3 * np.sin(waves), None, None)
    law = load_scenario("pd").drive.model_copy(
        update={
            "target_rad": (0.5, -0.2),
            "proportional_N_m_per_rad": (100.0, 70.0),
            "derivative_N_m_s_per_rad": (40.0, 9.0),
        }
    )
    scenario = load_scenario("pd").model_copy(update={"drive": law})
    found, source = comparison._torques(record, scenario, 16)
    rates = 0.3 * np.array([3.0, 5.0]) * np.cos(waves)
    right = np.array([100.0, 70.0]) * ([0.5, -0.2] - record.angles) - [40.0, 9.0] * rates
    if not np.allclose(found, right, atol=1e-3) or source != f"the drive of {scenario.name}":
        yield f"torques of {source}, off by {np.abs(found - right).max()}"


def wrong_run_pictures(
    found: RecordComparison, right: Sequence[Mapping[str, Any]]
) -> Iterator[str]:
    """Of what the figure of the runs draws, by the second program."""
    for joint in range(2):
        axes = Figure().subplots()
        output.draw_runs(found, joint, axes)
        for line, band, own in zip(axes.lines, axes.collections, right, strict=True):
            yield from apart("E in the picture", line.get_ydata()[1:], own["E"][1:, joint])
            bound = _bound(band, len(own["E"]))
            yield from apart("u_val in the picture", bound, 2 * own["u_val"][:, joint])


def _drawn(axes: Any, time: np.ndarray, values: np.ndarray, bound: np.ndarray) -> Iterator[str]:
    (line,), (band,) = axes.lines, axes.collections
    scale = float(np.abs(values).max())
    if not np.allclose(line.get_xdata(), time) or not np.allclose(
        line.get_ydata(), values, rtol=0.0, atol=1e-5 * scale
    ):
        yield "the residual in the picture"
    if not np.allclose(_bound(band, len(time)), bound, rtol=1e-5):
        yield "the band in the picture"


def _bound(band: Any, rows: int) -> np.ndarray:
    """Half the height of a band that was filled between two lines."""
    corners = band.get_paths()[0].vertices
    return np.asarray(np.abs(corners[1 : rows + 1, 1]))
