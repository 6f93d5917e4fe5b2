"""MuJoCo's gear tree is found where it is installed, and agrees with the program's own models."""

from __future__ import annotations

from crosscheck.registry import MODELS

ARMS = ("paper-labelled", "probe", "planets-apart", "three-unlike", "direct-between")
LAWS = {
    "phase": ("angle", "omega_t"),
    "dead_zone": ("exact", "tanh"),
    "damping": ("always", "contact"),
    "planets": ("lumped", "free"),
}


def test_it_is_found():
    assert "mujoco:gears" in MODELS
    assert {"mujoco", "mujoco-gears"} <= set(MODELS["mujoco:gears"].packages)
