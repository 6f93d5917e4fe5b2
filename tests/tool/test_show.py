"""`show` of an arm: the numbers beside their symbols; all that it prints stands in a snapshot."""

import math

import pytest

from crosscheck.cli.show import derived_arm, derived_joint
from crosscheck.models.arm.meshes import replace_damping
from crosscheck.models.loading import load_arm
from crosscheck.provenance import ROOT
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.input.arm_symbols import ARM_SYMBOLS, OF_ARM, find_meant_symbols
from tests.loops import require_items


def list_symbols(text: str) -> dict[str, str]:
    """Values by the symbols that stand beside them, of all tables."""
    head, found = "", {}
    for line in text.splitlines():
        if line.split()[:3] == ["quantity", "value", "unit"]:
            head = line
        elif line.startswith(" ") and "symbol" in head:
            symbol = line[head.index("symbol") :].strip()
            found[symbol] = line[head.index("value") : head.index("unit")].strip()
    found.pop("", None)
    return found


def test_a_poles_frequency_and_ratio_are_its_size_and_its_angle(monkeypatch):
    damped = replace_damping(load_arm("probe"), 2.0)  # by more than what would vibrate
    assert "mesh mode" not in {row.name for row in derived_arm(damped)}
    bare = damped.joints[0].model_copy(update={"sun_mass_kg": 0.0})
    assert "sun: radius of gyration over base radius" not in {
        row.name for row in derived_joint(bare)
    }
    monkeypatch.setattr("crosscheck.cli.show._mesh_poles", lambda model: [-30 + 40j])
    shown = {row.name: row.value for row in derived_arm(load_arm("probe"))}
    assert shown["mesh mode"] == pytest.approx(50 / (2 * math.pi))
    assert shown["its damping ratio"] == pytest.approx(0.6)


def test_every_symbol_of_an_arm_stands_beside_its_number(crosscheck, monkeypatch):
    """The symbols that SymPy equations may have, each once, with the number that they stand for."""
    monkeypatch.setenv("COLUMNS", "200")
    for name in ("probe", "direct-between"):
        values = collect_arm_values(load_arm(name))
        shown = list_symbols(crosscheck("show", name).out)
        x_and_y = shown.pop("g_x, g_y").split(", ")
        shown |= dict(zip(("g_x", "g_y"), x_and_y, strict=True))
        derived = {each for each in values if each.startswith("r_r")}  # of the ring, by its teeth
        assert set(values) - derived == set(shown)
        for symbol, value in shown.items():
            assert float(value) == pytest.approx(values[symbol], rel=1e-9)


def test_the_reference_has_the_symbols_of_an_arm():
    text = (ROOT / "docs" / "reference" / "arm-file.md").read_text(encoding="utf-8")
    rows = [row for row in text.splitlines() if row.startswith("| `")]
    for symbol in require_items(ARM_SYMBOLS):
        number = "" if symbol.stem in OF_ARM else "1"
        (row,) = (row for row in rows if f"`{symbol.stem}{number}`" in row)
        assert (f"`{symbol.field}`" if symbol.field else "follow") in row
    assert find_meant_symbols("i_2", {"I_l1", "I_l2"}) == ["I_l2"]  # no ratio n2 is there
