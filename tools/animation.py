"""The moving picture of README: a gear's teeth lose contact, and a trial finds the wrong term.

``python -m tools.animation``, or ``make docs``, writes docs/contact-and-cause.svg.
"""

from __future__ import annotations

import base64
import os
import runpy
import tempfile
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

import crosscheck
from crosscheck.models.experiment.scenario import switches
from crosscheck.output import write_files
from crosscheck.trial.result import Trial
from crosscheck.view.scene import describe_arm_scene
from crosscheck.view.trajectory_file import DRAWN_SIGNALS, Run

OUT = Path(__file__).parents[1] / "docs" / "contact-and-cause.svg"
ARM, MODEL, DURATION_S = "paper-labelled", "analytic:physical", 0.5
BEFORE_S, AFTER_S, FRAMES = 3e-3, 15e-3, 160  # of the instant at which contact is lost
EXAMPLE, RIGHT, WRONG = "plain_functions.py", "(2 * v[0] + v[1])", "(v[0] + v[1])"
ROOT = Path(__file__).parents[1]
LOOP_S, SIZE, STRIP, WIDTH, HEIGHT = 10, 220, (240, 70), 860, 330  # pixels, but the loop
SHOWN_MODULES = 11.0  # of the plane, across the close-up
STYLE = f"""
text {{ font: 14px system-ui, sans-serif; fill: #1c2733; }} .soft {{ fill: #56646f; }}
.label {{ paint-order: stroke; stroke: #f3f6f9; stroke-width: 5px; }}
.code {{ font: 13px ui-monospace, monospace; white-space: pre; }} .axis {{ stroke: #8a97a3; }}
.sun {{ fill: #3f76b5; }} .planet {{ fill: #c95b30; }} .bad {{ fill: #b3261e; font-weight: 600; }}
.good {{ fill: #1a6e3f; font-weight: 600; }} .force {{ fill: none; stroke: #1c2733; }}
.frame {{ fill: #f3f6f9; }} .now {{ stroke: #c2410c; stroke-width: 2; }}
.moves {{ animation: {LOOP_S}s linear infinite; }}
.steps {{ animation-timing-function: step-end; }} .del {{ text-decoration: line-through; }}
@media (prefers-color-scheme: dark) {{
  text {{ fill: #e4e9ee; }} .soft {{ fill: #a3b0bc; }} .bad {{ fill: #ff8f85; }}
  .label {{ stroke: #1f262d; }} .good {{ fill: #6fce96; }} .force {{ stroke: #e4e9ee; }}
  .frame {{ fill: #1f262d; }}
}}
@media (prefers-reduced-motion: reduce) {{ .moves {{ animation: none; }} .lost {{ opacity: 0; }} }}
"""


def simulate_contact_loss() -> tuple[np.ndarray, dict[str, Any]]:
    """Frames of a run about the first loss of contact, and the first joint's sun mesh.

    Returns:
        Numbers of the frames' records, (frames,), and the mesh as the page of a run has it, with
        gap [m] and force [N] of every record, (records,).
    """
    arm = crosscheck.load_arm(ARM)
    scenario = crosscheck.load_scenario("pd").model_copy(update={"duration_s": DURATION_S})
    made = crosscheck.simulate(crosscheck.build(MODEL, arm, scenario))
    signals = {name: made[name].values for name in DRAWN_SIGNALS if name in made}
    run = Run(MODEL, arm, made["time"].values, signals, switches())
    mesh = describe_arm_scene(run)["joints"][0]["meshes"]["sun"]
    for name in ("gap", "force"):
        mesh[name] = np.frombuffer(base64.b64decode(mesh[name]), dtype="<f4").astype(float)
    is_touching = mesh["force"] != 0.0
    lost = run.time[1:][is_touching[:-1] & ~is_touching[1:]][0]
    shown = np.linspace(lost - BEFORE_S, lost + AFTER_S, FRAMES)
    return np.searchsorted(run.time, shown), mesh


def try_example() -> Trial:
    """The trial of an example with a mistake, from a file of its own."""
    text = (ROOT / "examples" / EXAMPLE).read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        before = Path.cwd()
        os.chdir(folder)
        try:
            Path("my_model.py").write_text(text.replace(RIGHT, WRONG), encoding="utf-8")
            model = runpy.run_path("my_model.py")["model"]
            return crosscheck.try_equations(model, ARM, quick=True)
        finally:
            os.chdir(before)


def make_keyframes(name: str, property_name: str, values: Sequence[str]) -> str:
    """A CSS animation that goes through values at equal distances in time."""
    last = len(values) - 1
    steps = "".join(
        f"{100 * n / last:.4g}%{{{property_name}:{value}}}" for n, value in enumerate(values)
    )
    return f"@keyframes {name}{{{steps}}}"


def draw_outline(points: Sequence[Sequence[float]], origin: Sequence[float], scale: float) -> str:
    """The d of a closed path through points [m], in pixels from an origin [m], y downwards."""
    moved = scale * (np.array(points) - np.array(origin)) * [1, -1]
    return "M" + "L".join(f"{x:.1f},{y:.1f}" for x, y in moved) + "Z"


def draw_mesh(frames: np.ndarray, mesh: dict[str, Any]) -> Iterator[str]:
    """The close-up of the mesh, its force below, and whether the teeth touch."""
    scale, centre = SIZE / (SHOWN_MODULES * mesh["module_m"]), mesh["centre"]
    degrees = -np.degrees(mesh["turn_per_m"] * mesh["gap"][frames])
    force = mesh["force"][frames]
    wide, high = STRIP
    places = wide * np.arange(FRAMES) / (FRAMES - 1)
    heights = 6 + (high - 12) * (force.max() - force) / np.ptp(force)
    trace = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(places, heights, strict=True))
    moving = (
        make_keyframes("turn", "transform", [f"rotate({each:.3f}deg)" for each in degrees]),
        make_keyframes("go", "transform", [f"translateX({x:.1f}px)" for x in places]),
        make_keyframes("lose", "opacity", [str(int(each == 0)) for each in force]),
        make_keyframes("touch", "opacity", [str(int(each != 0)) for each in force]),
    )
    yield f"<style>{''.join(moving)}</style>"
    yield f'<clipPath id="close-up"><rect width="{wide}" height="{SIZE}" rx="4"/></clipPath>'
    yield f'<g clip-path="url(#close-up)"><rect class="frame" width="{wide}" height="{SIZE}"/>'
    yield f'<g transform="translate({wide / 2} {SIZE / 2})">'
    for points in mesh["wheel"]:
        yield f'<path class="sun" d="{draw_outline(points, (0, 0), scale)}"/>'
    place = f"translate({scale * centre[0]:.1f} {-scale * centre[1]:.1f})"
    yield f'<g transform="{place}"><g class="moves" style="animation-name:turn">'
    for points in mesh["planet"]:
        yield f'<path class="planet" d="{draw_outline(points, centre, scale)}"/>'
    yield "</g></g></g></g>"
    captions = (("touch", "", "teeth in contact"), ("lose", "lost bad", "contact lost"))
    for animation, tone, words in captions:
        shown = f'class="moves steps {tone}" style="animation-name:{animation}"'
        yield f'<text x="8" y="{SIZE + 20}" {shown}>{words}</text>'
    yield f'<g transform="translate(0 {SIZE + 30})"><rect class="frame" width="{wide}"'
    yield f' height="{high}" rx="4"/><polyline class="force" points="{trace}"/>'
    yield f'<line class="now moves" style="animation-name:go" y2="{high}"/>'
    largest, lasts = np.abs(force).max(), 1e3 * (BEFORE_S + AFTER_S)
    words = f"mesh force, up to {largest:.2g} N, {lasts:.0f} ms"
    yield f'<text class="soft label" x="8" y="{high - 8}">{words}</text></g>'


def draw_cause(trial: Trial) -> Iterator[str]:
    """The wrong line of code, then the verdict, then what must change."""
    if trial.change is None:
        raise ValueError(f"{EXAMPLE}: no change of the source explains the mistake")
    (edit,) = trial.change.edits

    left, steps = STRIP[0] + 30, 20
    lines = [
        ("soft", "Your code:", 0),
        ("code", edit.start.strip() + edit.removed + edit.end, 0),
        ("soft", f"$ crosscheck trial my_model.py:model {ARM} --quick", 3),
        ("bad", trial.verdict.text.partition(",")[0], 6),
        ("", next(iter(trial.change.sentences)).partition(";")[0], 9),
    ]
    names = dict.fromkeys(start for _, _, start in lines if start)
    appear = [
        make_keyframes(f"a{start}", "opacity", [str(int(n >= start)) for n in range(steps)])
        for start in (*names, 12)
    ]
    yield f"<style>{''.join(appear)}</style>"
    for number, (tone, words, start) in enumerate(lines):
        shown = (
            f'class="moves steps {tone}" style="animation-name:a{start}"'
            if start
            else f'class="{tone}"'
        )
        yield f'<text x="{left}" y="{46 + 44 * number}" {shown}>{escape(words)}</text>'
    mended = (("", edit.start.strip()), ("bad del", edit.removed), ("good", f" {edit.added}"))
    parts = "".join(f'<tspan class="{c}">{escape(t)}</tspan>' for c, t in (*mended, ("", edit.end)))
    at = f'x="{left}" y="{46 + 44 * len(lines)}"'
    yield f'<text {at} class="code moves steps" style="animation-name:a12">{parts}</text>'


def draw_animation() -> str:
    """Both as one SVG, which stands still, whole, for whom motion disturbs."""
    elements = [*draw_mesh(*simulate_contact_loss()), *draw_cause(try_example())]
    description = "Teeth of a planetary gear lose contact; beside it a trial names a wrong term"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}"'
        f' role="img" aria-label="{description}">\n<style>{STYLE}</style>\n'
        + "\n".join(elements)
        + "\n</svg>\n"
    )


def write_animation() -> None:
    """Write the picture beside the docs that show it."""
    write_files({OUT: draw_animation()})


if __name__ == "__main__":
    write_animation()
