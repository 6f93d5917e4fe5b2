"""Views of what shortcuts cost a robot."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
import pytest

from crosscheck.cost import output
from crosscheck.cost.motion import SineMotion
from crosscheck.cost.shortcuts import ShortcutCosts
from crosscheck.report.plots import figures
from tests.robots.cost_guard import found_cost
from tests.views.walker import Fact, View, vary

CUES = {"links": "Leaving the rotors out", "armature": "Counting them as armature only"}


@lru_cache
def worked_out() -> ShortcutCosts:
    """The costs whose numbers are varied, worked out by code without a fault."""
    return found_cost("oblique", engines=True)


def list_facts(costs: ShortcutCosts) -> Iterator[Fact]:
    """Facts of joints, levels, pairs, rotors, meshes, engines, and counts."""
    units = dict(zip(costs.names, costs.units, strict=True))
    joints = zip(costs.names, np.abs(costs.torques).max(axis=0), costs.by_rates, strict=True)
    for number, (name, largest, by_rates) in zip(costs.robot.coordinates, joints, strict=True):
        yield Fact(largest, "largest torque", (name,), units[name])
        yield Fact(by_rates, "by rates", (name,))
        limits = costs.robot.joints[number].limits
        yield from (
            Fact(getattr(limits, key), key, (name,))
            for key in ("lower", "upper", "velocity", "effort")
        )
    for each in costs.by_joint:
        names = each.joint, each.level
        yield Fact(each.largest, "largest", names, units[each.joint])
        yield Fact(each.rms, "rms", names, units[each.joint])
        yield Fact(each.share, "share", names)
    for tip in costs.tips:
        for number, distance in enumerate(tip.distances, 1):
            yield Fact(distance, f"run {number}", (tip.level,), "m")
            yield Fact(distance, "distances_m", (tip.level,))
        if tip.level in CUES:
            yield from _list_distances(tip.distances, CUES[tip.level])
            shares = [each.share for each in costs.by_joint if each.level == tip.level]
            yield Fact(max(shares), "worst share", (CUES[tip.level],))
            if tip.level == "armature":
                yield Fact(max(shares), "peak of coupling")
    for pair in costs.pairs:
        yield Fact(pair.rms, "rms", (pair.at, pair.by), units[pair.at])
        yield Fact(pair.share, "share", (pair.at, pair.by))
        yield Fact(pair.share, "share of a pair")
    for each in costs.ratios:
        yield Fact(each.ratio, "ratio", (each.joint,), digits=0)
        yield Fact(each.share, "share of a rotor", (each.joint,))
        yield Fact(each.share, "share", ("ratios", each.joint, each.at))
        yield Fact(each.enough, "enough", (each.joint,))
    for rotor in costs.robot.rotors:
        yield Fact(rotor.ratio, "rotor's ratio", digits=0)
        yield Fact(rotor.inertia, "rotor's inertia", (), "kg")
    assert costs.geared is not None
    assert costs.geared.distances is not None
    for mesh in costs.geared.meshes:
        for name in ("backlash", "windup", "slowest", "fastest"):
            unit = "Hz" if name.endswith("st") else mesh.unit
            yield Fact(getattr(mesh, name), name, (mesh.name,), unit)
    yield from _list_distances(costs.geared.distances, "With teeth that give way")
    for distance in costs.geared.distances:
        yield Fact(distance, "distances_m", ("geared",))
        yield Fact(distance, "geared distance", (), "m")
    sizes: dict[str, list[tuple[str, float, float]]] = {}
    for f in costs.agreement:
        (engine, level), quantity = f.left.split(":"), f.quantity.replace("_", " ")
        names = (quantity, level, engine, f.right.split(":")[0])
        assert f.measured is not None
        assert f.tolerance is not None
        yield Fact(f.measured, "measured", names)
        yield Fact(f.tolerance, "tolerance", names)
        sizes.setdefault(quantity, []).append((level, f.measured, f.tolerance))
    for quantity, rows in sizes.items():
        for level in costs.robot.levels:
            yield Fact(max(size for own, size, _ in rows if own == level), level, (quantity,))
        yield Fact(max(tolerance for *_, tolerance in rows), "tolerance", (quantity,))
    counts = {"digits": int(-np.log10(max(f.measured or 0.0 for f in costs.agreement)))}
    counts |= {"quantities": len(sizes), "levels": len(costs.robot.levels)}
    counts |= {name: getattr(costs.extent, name) for name in ("states", "runs", "instants")}
    counts |= {"seed": costs.seed, "steps": costs.geared.steps}
    yield from (Fact(count, name) for name, count in counts.items())
    yield Fact(costs.factor, "factor")
    yield Fact(0.01, "negligible_share")
    assert isinstance(costs.motion, SineMotion)
    yield Fact(costs.motion.period, "period", (), "s")
    yield from (Fact(note, "note") for note in costs.robot.notes)


def _list_distances(distances: np.ndarray, cue: str) -> Iterator[Fact]:
    yield Fact(float(np.median(distances)), "off", (cue,), "m")
    yield Fact(len(distances), "runs", (cue,))
    yield Fact(float(distances.max()), "at most", (cue,), "m")


PHRASES = {
    "wrong by up to {} of (?:its|their) largest": "worst share",
    "\\w+ {} off": "off",
    "median of {} runs, {} at most": "runs, at most",
    "to {} digits": "digits",
    "on {} quantities, {} levels and {} states": "quantities, levels, states",
    "peak of this coupling [(]{}[)]": "peak of coupling",
    "by \\w+ [(]{}[)]": "share of a pair",
    "all ratios were {} times": "factor",
    "backlash of {}": "backlash",
    "wind-up of {}": "windup",
    "swings at {}": "slowest",
    ": {} at most, {} rms, {} of its": "largest, rms, share",
    "acceleration of \\w+: {} rms, {}": "rms, share",
    ", ratio {}:": "ratio",
    "ratio {}, {} m.2 at": "rotor's ratio, rotor's inertia",
    "coupling alone is {} in": "share of a rotor",
    "from a ratio of {} on": "enough",
    "sums of sines of seed {}, period {}": "seed, period",
    "(?<=planned path:) {}": "geared distance",
    "(?<=[kmµn]m,) {}": "geared distance",
    "in {} steps": "steps",
    "from {} instants": "runs",
    "at {} random states": "states",
}
HEADS = {"share of the largest torque": "share"}
HEADS |= {"largest error": "largest", "largest share": "share of a rotor"}
HEADS |= {"below 1 % from a ratio of": "enough", "largest wind-up": "windup"}
HEADS |= {"slowest swing": "slowest", "fastest swing": "fastest", "negligible_from": "enough"}
HEADS |= {"largest_torque": "largest torque", "coupling_by_rates_rms": "by rates"}
HEADS |= {"largest_error": "largest", "rms_error": "rms", "share_of_largest_torque": "share"}
HEADS |= {"slowest_Hz": "slowest", "fastest_Hz": "fastest"}
HEADS |= {"negligible_with_ratios_times": "factor"}
WORDING = {
    r"after 1 s of feed-forward": "how long a run is",
    r"below 1 %": "what is negligible",
    r"^Robot tested\. 3 joints.*": "the robot in words, below its drawing",
    r"counted from 1\b": "joints",
}


def render_page(costs: ShortcutCosts) -> str:
    """The page without what is drawn, which has another guard."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "to_svg", lambda figure: "<svg></svg>")
        return output.cost_page(costs)


RENDER = {
    "terminal": lambda costs: "\n".join(output.describe_result(costs)),
    "JSON": output.cost_json,
    "page": render_page,
}
PARTS = ("largest", "rms", "backlash", "windup", "enough")
SHOWN = {"terminal": ("backlash", "windup", "note"), "JSON": (*PARTS, "note"), "page": PARTS}
VIEWS = {
    f"{name} of cost": View(
        make=lambda seed: vary(worked_out(), seed),
        render=render,
        facts=list_facts,
        heads=HEADS,
        phrases=PHRASES,
        wording=WORDING,
        shown=SHOWN[name],
    )
    for name, render in RENDER.items()
}
