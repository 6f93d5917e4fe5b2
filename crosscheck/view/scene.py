"""Scene of the page of a run: outlines of an arm's bodies, a robot's rods; angles over time."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from typing import Any

import numpy as np

from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.analytic.paper.mesh_force import total_error
from crosscheck.analytic.paper.mesh_frequency import (
    ANGLE,
    OMEGA_T,
    mesh_phase,
    mesh_phases,
    ring_mesh_rate,
    sun_mesh_rate,
)
from crosscheck.mechanisms import supply
from crosscheck.models.arm.arm import Planetary
from crosscheck.models.robot.robot import BASE
from crosscheck.report.records import to_json_value
from crosscheck.view.gears import gear_angles, gear_assembly, make_close_up, outline
from crosscheck.view.mesh_geometry import SIDES, Side, mesh_geometry
from crosscheck.view.rods import find_rod_ends, find_upward
from crosscheck.view.trajectory_file import Run

MOST_FRAMES = 20_000  # frames of the longest run; of more records every second, third, ... is shown
MESHES = {"sun": ("x_sp", "F_sp"), "ring": ("x_pr", "F_pr")}


def build_scene(run: Run) -> dict[str, Any]:
    """Data for the page's script: lengths in m, angles in rad, numbers as base64 of float32."""
    every = -(-run.time.size // MOST_FRAMES)
    signals = {name: values[::every] for name, values in run.signals.items()}
    shown = run._replace(time=run.time[::every], signals=signals)
    return {
        "name": run.mechanism.name,
        "model": run.model,
        "frames": shown.time.size,
        "every": every,
        "start_s": float(shown.time[0]),
        "step_s": float(shown.time[1] - shown.time[0]) if shown.time.size > 1 else 0.0,
        **supply("describe_scene", run.mechanism.section)(shown),
    }


def describe_arm_scene(run: Run) -> dict[str, Any]:
    """The part of the page's data that only an arm has."""
    return {
        "drawn": "The arm with its links, carriers, suns, planets and rings in motion. ",
        "ground": None,
        "reach": sum(link.length_m for link in run.mechanism.links),
        "described": ". ".join(run.mechanism.described),
        "payload": run.mechanism.payload_mass_kg > 0,
        "teeth": "x_sp" in run.signals,
        "joints": [_build_joint(run, place) for place in range(len(run.mechanism.joints))],
    }


def describe_robot_scene(run: Run) -> dict[str, Any]:
    """The part of the page's data that only a robot has."""
    theta, robot = run.signals["theta"], run.mechanism
    ends = find_rod_ends(robot)
    lengths = [max(np.linalg.norm(end) for end in each) for each in ends.values() if each]
    slides = [joint.kind == "prismatic" for joint in robot.joints]
    slid = np.abs(theta[:, slides]).max(axis=0)
    return {
        "described": f"The whole robot: {len(robot.joints)} joints, {len(robot.rotors)} rotors",
        "drawn": "The robot, its links as rods and its joints in motion. ",
        "payload": False,
        "teeth": True,
        "reach": float(sum(lengths, 0.0) + slid.sum()) or 1.0,
        "ground": _round_places(ends[BASE]),
        "up": find_upward(robot).tolist(),
        "joints": [
            {
                "kind": joint.kind,
                "name": joint.name,
                "parent": joint.parent,
                "rotation": joint.placement.rotation.tolist(),
                "position": joint.placement.position.tolist(),
                "axis": joint.axis.tolist(),
                "ends": _round_places(ends[number]),
                "theta": encode_numbers(theta[:, number]),
            }
            for number, joint in enumerate(robot.joints)
        ],
    }


def _round_places(ends: list[np.ndarray]) -> list[list[float]]:
    return [end.round(9).tolist() for end in ends if np.linalg.norm(end) > 0]


def _build_joint(run: Run, place: int) -> dict[str, Any]:
    joint, angles = run.mechanism.joints[place], run.signals["theta"][:, place]
    body = {"length_m": run.mechanism.links[place].length_m, "theta": encode_numbers(angles)}
    if not isinstance(joint, Planetary):
        return body | {"kind": "direct"}
    # Of a run without teeth, gears that roll as if they were rigid.
    x = [_planet_signal(run, name, place, joint) for name in ("x_sp", "x_pr")]
    x_sp, x_pr = (np.zeros((angles.size, 1)) if each is None else each for each in x)
    sun, planets = gear_angles(joint, angles, x_sp, x_pr)
    wheels = {side: mesh_geometry(joint, side) for side in SIDES}
    return body | {
        "kind": "planetary",
        "face_m": 6 * joint.module_m,
        "carrier_m": joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2,
        "rim_m": joint.module_m * (joint.ring_teeth / 2 + 4),
        "outlines": {
            "sun": _points(outline(wheels["sun"].wheel)),
            "planet": _points(outline(wheels["sun"].planet)),
            "ring": _points(outline(wheels["ring"].wheel)),
        },
        "stand": to_json_value(gear_assembly(joint)),
        "sun": encode_numbers(sun),
        "planets": [encode_numbers(column) for column in planets.T],
        "meshes": dict(_meshes(run, place, joint)),
    }


def _planet_signal(run: Run, name: str, place: int, joint: Planetary) -> np.ndarray | None:
    """A signal (times, planets), or (times, 1) of planets counted as one; None if it is missing."""
    if name not in run.signals:
        return None
    values = run.signals[name][:, place, : joint.planet_count]
    return values[:, :1] if np.isnan(values).any() else values


def _meshes(run: Run, place: int, joint: Planetary) -> Iterator[tuple[str, dict[str, Any]]]:
    """Close-ups of the first planet's meshes, by side; none of a run without teeth."""
    for side in SIDES:
        x, force = (_planet_signal(run, name, place, joint) for name in MESHES[side])
        if x is None or force is None:
            continue
        gap = x[:, 0] - first_tooth_error(run, place, joint, side)
        near = make_close_up(joint, side, float(np.abs(gap).max()))
        mesh = joint.sun_mesh if side == "sun" else joint.ring_mesh
        close_up = {
            "factor": near.factor,
            "wheel": [_points(each) for each in near.wheel],
            "planet": [_points(each) for each in near.planet],
            "centre": [near.centre.real, near.centre.imag],
            "turn_per_m": near.turn_per_m,
            "half_clearance_m": mesh.planet_mesh(0).backlash_m,
            "module_m": joint.module_m,
            "gap": encode_numbers(gap),
            "force": encode_numbers(force[:, 0]),
        }
        yield side, close_up


def first_tooth_error(run: Run, place: int, joint: Planetary, side: Side) -> np.ndarray:
    """Tooth error e [m] of the first planet's mesh with sun or ring during a run, (times,)."""
    geometry, laws = stage_geometry(joint), run.laws
    offsets = dict(zip(SIDES, mesh_phases(joint, 0), strict=True))
    mesh = (joint.sun_mesh if side == "sun" else joint.ring_mesh).planet_mesh(0)
    rates_by_side = {"sun": sun_mesh_rate(joint, geometry)}
    rates_by_side["ring"] = ring_mesh_rate(joint, geometry, laws.ring_rate)
    theta = run.signals["theta"][:, place]
    rates = run.signals["theta_dot"][:, place] if laws.phase == "omega_t" else np.zeros_like(theta)
    law = OMEGA_T if laws.phase == "omega_t" else ANGLE
    phase = mesh_phase(law, rates_by_side[side], offsets[side], run.time, theta, rates)
    return total_error(phase, mesh.tooth_error_m, mesh.tooth_error_phase_rad, mesh.static_error_m)


def _points(outline: np.ndarray) -> list[list[float]]:
    """Points [m] as pairs, rounded to a micrometre."""
    return np.stack([outline.real, outline.imag], axis=1).round(6).tolist()


def encode_numbers(values: np.ndarray) -> str:
    """Numbers as base64 of little-endian float32, infinite where they are too large for it."""
    with np.errstate(over="ignore"):
        return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode()
