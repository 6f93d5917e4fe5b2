"""MuJoCo's gear tree is found where it is installed, and agrees with the program's own models."""

from __future__ import annotations

from itertools import product

import pytest

from crosscheck import build, load_arm, load_scenario
from crosscheck.checks.answers import random_states
from crosscheck.checks.states import Setting, compare_values
from crosscheck.findings import About, Key
from crosscheck.registry import MODELS
from models.interface import STATE_ABILITIES
from models.planets import usual_switches

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
