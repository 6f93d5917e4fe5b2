"""The case study of measured robots: ``python -m tools.measured FOLDER``.

FOLDER holds the recordings of docs/case-study/measured.md in the folders tx40, double-pendulum and
kinova-gen3; it says where they are from. Writes that page and its picture. A robot whose folder is
not there is skipped, which the page says.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crosscheck.identification.compare import (
    RecordComparison,
    SideResult,
    compare,
)
from crosscheck.identification.description import (
    load_description,
    read_recordings,
    transmission_matrix,
)
from crosscheck.identification.mechanism import SpatialRobot
from crosscheck.identification.messages import (
    SIDE_PHRASES,
    UNDETERMINED,
    describe_answers,
    format_estimate,
)
from crosscheck.identification.terms import FRICTION_KINDS, TermEstimate, TermKind
from crosscheck.models.robot.file import RobotFile, build_robot, load_robot
from crosscheck.models.robot.robot import Robot
from tools.site import format_table

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "case-study" / "measured.md"
PICTURE = PAGE.with_name("measured.svg")
DESCRIPTIONS = ROOT / "examples" / "recordings" / "robots"
PENDULUM = {"A0": "model_design_A.0_model_2.0.yml", "C1": "model_design_C.1_model_1.0.yml"}
SUBJECT = re.compile(r"(.+?) (?:of the motor of|of|at|that) (.+?)(?: share)?")
IN_TABLES = (
    "They need a factor",
    "Too uncertain",
    "Estimates with these factors",
    "Coupled and armature",
)
LINKS = {"identified": ", links identified", "scaled": ", links of the file scaled", "none": ""}
HEAD = Path(__file__).with_name("measured_head.md")


@dataclass(frozen=True)
class Study:
    """A robot's comparison, and what was published of its terms by their names."""

    title: str
    comparison: RecordComparison
    published: Mapping[str, float]
    remark: str


def build_page(folder: Path) -> tuple[str, list[Study]]:
    """The page as Markdown, and the studies on it."""
    studies: list[Study] = []
    missing = []
    for name, study in (
        ("tx40", _study_tx40),
        ("double-pendulum", _study_pendulums),
        ("kinova-gen3", _study_kinova),
    ):
        if not (folder / name).is_dir():
            missing.append(f"Skipped: the folder `{name}` was not there.\n")
            continue
        studies += study(folder / name)
    recordings = format_table(
        ["robot", "recordings", "rows", "length [s]", "engines differ by"],
        map(_summarize_study, studies),
    )
    parts = [HEAD.read_text(encoding="utf-8") + recordings, *missing]
    return "\n".join([*parts, *("\n".join(_describe_study(each)) for each in studies)]), studies


def _study_tx40(folder: Path) -> Iterator[Study]:
    config = (folder / "TX40_config.yaml").read_text(encoding="utf-8")
    published = {
        f"{kind} of joint_{number}": value
        for field, kind in (("fv", "viscous"), ("fs", "coulomb"), ("Ia", "armature"))
        for number, value in enumerate(_read_numbers(config, field), 1)
    }
    pair = "joint_5 and joint_6"
    for field, name in (
        ("Iam6", f"armature that {pair} share"),
        ("fvm6", f"viscous that {pair} share"),
        ("fsm6", f"coulomb of the motor of {pair}"),
    ):
        (published[name],) = _read_numbers(config, field)
    robot = load_robot(str(folder / "tx40_mdh_modified.urdf"))
    comparison = _compare(robot, folder, "tx40")
    yield Study("Stäubli TX40", comparison, published, "Published: `TX40_config.yaml`.")


def _study_pendulums(folder: Path) -> Iterator[Study]:
    for design, file in PENDULUM.items():
        text = (folder / file).read_text(encoding="utf-8")
        numbers = {name: float(value) for name, value in re.findall(r"(?m)^(\w+): *(\S+)$", text)}
        published = {
            f"{kind} of {joint}": numbers[f"{field}{number}"]
            for number, joint in enumerate(("shoulder", "elbow"), 1)
            for field, kind in (("cf", "coulomb"), ("b", "viscous"))
        }
        for joint in ("shoulder", "elbow"):  # the source's law is cf arctan(100 q')
            published[f"coulomb of {joint}"] *= math.pi / 2
        ratio, rotor = numbers["gr"], numbers["Ir"]
        published["armature of elbow"] = ratio**2 * rotor
        title = f"Double pendulum, design {design[0]}.{design[1]}"
        comparison = _compare(_build_pendulum(numbers), folder, f"double-pendulum-{design}")
        remark = (
            f"Published: `{file}`; J = {rotor:.3g} kg m², N = {ratio:g}, N² J as the armature."
            f" N (N - 1) J = {ratio * (ratio - 1) * rotor:.5f} kg m² is a coupled rotor's,"
            f" N (N + 1) J = {ratio * (ratio + 1) * rotor:.5f} kg m² that with the source's sign."
        )
        yield Study(title, comparison, published, remark)


def _study_kinova(folder: Path) -> Iterator[Study]:
    robot = load_robot(str(folder / "gen3.urdf"))
    remark = "Its rotors are not published. The robot had a gripper, which the URDF lacks."
    yield Study("Kinova Gen3", _compare(robot, folder, "kinova-gen3"), {}, remark)


def _compare(robot: Robot, folder: Path, name: str) -> RecordComparison:
    """The comparison by the description of this name, its files in the folder."""
    description = load_description(DESCRIPTIONS / f"{name}.toml")
    records = read_recordings(description, robot, folder / f"{name}.toml")
    turns = transmission_matrix(description, len(robot.coordinates))
    return compare(SpatialRobot(robot), records, turns, lambda *progress: None)


def _build_pendulum(numbers: Mapping[str, float]) -> Robot:
    """The robot of the published numbers, whose inertias are about the joints."""

    def link(name: str, number: int) -> str:
        mass, com = numbers[f"m{number}"], numbers[f"r{number}"]
        about_com = max(numbers[f"I{number}"] - mass * com**2, 1e-6)
        return (
            f'<link name="{name}"><inertial><origin xyz="0 0 {-com!r}"/><mass value="{mass!r}"/>'
            f'<inertia ixx="{about_com!r}" iyy="{about_com!r}" izz="1e-6" ixy="0" ixz="0" iyz="0"/>'
            "</inertial></link>"
        )

    def joint(name: str, parent: str, child: str, height: float) -> str:
        return (
            f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="0 0 {height!r}"/><axis xyz="0 1 0"/></joint>'
        )

    text = "".join(
        (
            '<robot name="double-pendulum"><link name="base"/>',
            link("upper", 1),
            link("lower", 2),
            joint("shoulder", "base", "upper", 0.0),
            joint("elbow", "upper", "lower", -numbers["l1"]),
            "</robot>",
        )
    )
    file = RobotFile(schema_version=1, name="double-pendulum", urdf="double-pendulum.urdf")
    return build_robot(file, text, "double-pendulum", "double-pendulum.urdf")


def _read_numbers(text: str, field: str) -> list[float]:
    """The numbers of a line `field : [...]` of YAML."""
    (values,) = re.findall(rf"(?m)^[\s-]*{field} *: *\[?([^\]\n]*)", text)
    return [float(value) for value in values.split(",")]


def _summarize_study(study: Study) -> list[str]:
    """Cells: how much was recorded, and how far the engines' inverse dynamics differ along it."""
    records = study.comparison.records
    seconds = sum(float(each.time[-1] - each.time[0]) for each in records)
    worst = max(engine.measured or 0.0 for engine in study.comparison.engines)
    rows = sum(len(each.time) for each in records)
    return [study.title, str(len(records)), f"{rows:,}", f"{seconds:.3g}", f"{worst:.0e}"]


def _describe_study(study: Study) -> Iterator[str]:
    comparison = study.comparison
    yield f"## {study.title}\n\n{study.remark}\n"
    answers = (_shorten_answer(answer) for answer in describe_answers(comparison))
    yield from (f"- {answer}" for answer in answers if answer)
    yield ""
    yield _format_steps(comparison.sides)
    excited = {each.side for each in comparison.sides if each.is_excited and each.links != "scaled"}
    for number, side in enumerate(comparison.sides, 1):
        omitted = FRICTION_KINDS if side.links == "scaled" and side.side in excited else ()
        yield f"### Fit {number}: {SIDE_PHRASES[side.side]}{LINKS[side.links]}\n"
        yield from _describe_side(side, study.published, omitted)


def _shorten_answer(answer: str) -> str:
    """The sentence without the estimates that the tables hold, or that all robots share."""
    if answer.startswith(IN_TABLES):
        return ""
    head, _, estimates = answer.partition(": ")
    return f"{head}." if estimates and head.startswith("Links and friction") else answer


def _format_steps(sides: Sequence[SideResult]) -> str:
    """A table of the terms that are added one after the other, and the residual with each."""
    names = dict.fromkeys(step.name for side in sides for step in side.steps)
    rows = []
    for number, side in enumerate(sides, 1):
        cells = {
            step.name: f"{step.parameters}: {step.weighted:.3f}, {step.predicted:.3f}"
            for step in side.steps
        }
        sizes = [f"{side.bandwidth:.3g}", f"{side.fit.condition:.3g}", str(side.fit.blocks)]
        rows.append([str(number), *sizes, *(cells.get(name, "") for name in names)])
    return format_table(["fit", "band [Hz]", "condition", "blocks", *names], rows)


def _describe_side(
    side: SideResult, published: Mapping[str, float], omitted: Sequence[TermKind]
) -> Iterator[str]:
    """A table of the estimates but for those of the omitted kinds."""
    bands = {f"to {band.bandwidth:.3g} Hz": band.estimates for band in side.bands}
    columns = {"estimate": side.estimates, **bands}
    cells = {
        (each.term.name, column): _format_interval(each)
        for column, estimates in columns.items()
        for each in estimates
        if each.term.kind not in omitted
    }
    for each in side.seen if side.links == "identified" else ():
        cells[each.term.name, "estimate"] = f"**{cells[each.term.name, 'estimate']}**"
    names = {
        each.term.name: each.term.unit
        for each in side.estimates
        if each.term.kind != "offset" and (each.term.name, "estimate") in cells
    }
    cells |= {(name, "published"): f"{published[name]:.4g}" for name in names if name in published}
    for joint, value in zip(side.measured, side.steps[-1].rms, strict=True):
        names[f"residual of {joint}"] = "N m"
        cells[f"residual of {joint}", "estimate"] = f"{value:.3g}"
    yield from format_estimates(names, cells, ["estimate", "published", *bands])


def format_estimates(
    units: Mapping[str, str], cells: Mapping[tuple[str, str], str], columns: Sequence[str]
) -> Iterator[str]:
    """A table with a row for each joint, or motor that joints share; then the delay.

    units: by a term's name; cells: by it and a column, of which the first is the estimate.
    """
    kinds: dict[str, dict[str, str]] = {}  # a kind's heading: its terms by their joints
    for name, unit in units.items():
        kind, place = SUBJECT.fullmatch(name).groups()  # type: ignore[union-attr]
        kinds.setdefault(f"{kind} [{unit}]" if unit else kind, {})[place] = name
    delays = kinds.pop("delay [s]", {}).values()
    heads = [
        (kind, column)
        for kind, terms in kinds.items()
        for column in columns
        if any((name, column) in cells for name in terms.values())
    ]
    rows = [
        [place, *(cells.get((kinds[kind].get(place, ""), column), "") for kind, column in heads)]
        for place in dict.fromkeys(place for terms in kinds.values() for place in terms)
    ]
    yield format_table(["", *(k if column == columns[0] else column for k, column in heads)], rows)
    for name in delays:
        others = [f"{each}: {cells[name, each]}" for each in columns[1:] if (name, each) in cells]
        yield f"{name.capitalize()}: {'; '.join([cells[name, columns[0]], *others])} s.\n"


def _format_interval(each: TermEstimate) -> str:
    text = format_estimate(each).removeprefix(f"{each.term.words} ")
    text = text.removesuffix(f" ({UNDETERMINED})")
    if each.doubled is not None:
        return f"{text.split()[0]}†"
    return text.removesuffix(each.term.unit).strip()


def draw_picture(studies: Sequence[Study]) -> str:
    """SVG text: estimated armatures with intervals, and what was published of them."""
    from matplotlib.figure import Figure

    from crosscheck.report.plots.figures import to_svg

    figure = Figure(figsize=(9, 3), layout="constrained")
    table = figure.subplots(1, len(studies), squeeze=False)[0]
    for axes, study in zip(table, studies, strict=True):
        side = study.comparison.sides[0]
        names = [each.term.name.replace("armature of ", "") for each in side.rotors]
        places = np.arange(len(names))
        values = [each.value for each in side.rotors]
        axes.errorbar(
            places,
            values,
            yerr=[np.nan if each.doubled else each.half_width for each in side.rotors],
            fmt="o",
            ms=4,
            capsize=3,
            label="estimate, 95 %",
        )
        known = [(n, study.published.get(e.term.name)) for n, e in enumerate(side.rotors)]
        marks = [(n, value) for n, value in known if value is not None]
        if marks:
            axes.plot(*zip(*marks, strict=True), "x", color="C3", label="published")
        axes.axhline(0.0, color="0.7", lw=0.6)
        short = [re.sub(r"armature that (\w+) and (\w+) share", r"\1, \2", name) for name in names]
        axes.set_xticks(places, [name.replace("joint_", "") for name in short], fontsize="small")
        axes.set_xlim(-0.6, len(names) - 0.4)
        axes.set_title(study.title, fontsize="small")
    table[0].set_ylabel("armature [kg m²]")
    table[0].legend(fontsize="x-small")
    return to_svg(figure)


def main() -> None:
    """Write the page and its picture."""
    page, studies = build_page(Path(sys.argv[1]))
    PAGE.write_text(page, encoding="utf-8")
    if studies:
        PICTURE.write_text(draw_picture(studies), encoding="utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
