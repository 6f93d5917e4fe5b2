"""Exudyn's separate bodies with Python in place of compiled functions, for planting faults."""

from __future__ import annotations

import inspect

import pytest

from crosscheck.models.exudyn.bodies import bodies as exudyn_bodies
from crosscheck.models.exudyn.bodies import contact as exudyn_contact
from crosscheck.models.exudyn.bodies import stiffness as exudyn_contact_stiffness


def interpret(patch: pytest.MonkeyPatch) -> None:
    """Compiled functions of the contact become their Python originals, which can be changed."""
    compiled = exudyn_contact_stiffness, exudyn_contact
    homes = {module.__name__ for module in compiled}
    for module in (*compiled, exudyn_bodies):
        for name, value in list(vars(module).items()):
            if hasattr(value, "py_func") and value.__module__ in homes:
                patch.setattr(module, name, inspect.unwrap(value))
    for module in (exudyn_contact, exudyn_bodies):
        patch.setattr(module, "push_bodies", exudyn_contact.mesh_forces)
