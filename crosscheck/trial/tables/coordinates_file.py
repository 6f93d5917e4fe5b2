"""The coordinates of a table of answers: a small TOML file with a linear map, and no code."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from crosscheck.models.files import read_toml
from crosscheck.models.loading import validated
from crosscheck.trial.input.equations import Coordinates, Gearing, Level

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=40)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
MOST = 100  # coordinates of an arm, and more


class CoordinatesFile(BaseModel):
    """Coordinates but for functions; level: the rigid level that a model is meant to be."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    gearing: Gearing = "rigid"
    links: Literal["relative", "absolute"] = "relative"
    gears: Literal["displacements", "angles"] = "displacements"
    order: tuple[Name, ...] = Field(default=(), max_length=MOST)
    matrix: tuple[tuple[Finite, ...], ...] | None = Field(default=None, max_length=MOST)
    names: tuple[Name, ...] = Field(default=(), max_length=MOST)
    level: Level = ""


def coordinates_of(path: Path | None) -> tuple[Coordinates, Level]:
    """Those of a file, or joint angles relative to the previous link. Raises InputError."""
    if path is None:
        return Coordinates(), ""
    said = validated(CoordinatesFile, read_toml(path), str(path))
    return Coordinates(**said.model_dump(exclude={"level"})), said.level
