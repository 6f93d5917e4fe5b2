"""The arm and the experiment as data, and each engine's model of them."""

from pathlib import Path

from crosscheck.models.compiled import settle

settle(Path(__file__).parent.parent)
