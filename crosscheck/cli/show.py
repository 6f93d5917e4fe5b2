"""`crosscheck show`: an arm's values and what follows from them."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Console
from rich.table import Table

from crosscheck import derived
from crosscheck.derived import DerivedQuantity
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.mesh import Mesh, PlanetMesh
from crosscheck.models.arm.quantities import Data
from crosscheck.models.errors import InputError
from crosscheck.models.loading import load_arm
from crosscheck.planning.plan import is_the_papers
from crosscheck.planning.sizing import sizes_of
from crosscheck.registry import usable_numbers
from crosscheck.schema import described

MOST_LISTED = 6  # of a list of numbers
OF_THE_FILE = ("schema_version", "name", "title")


def show_command(name: str) -> None:
    """Print an arm, once all of it is worked out. Raises InputError."""
    arm = load_arm(name)
    with usable_numbers("show", arm):
        tables = list(_tables(arm))
    print(f"{arm.name}: {arm.title}")
    Console().print(*tables, sep="\n")


def _tables(arm: Arm) -> Iterator[Table]:
    """Of each joint, its meshes and the link behind it; of the arm; of its experiments."""
    for place, joint in enumerate(arm.joints):
        title = f"joint {place + 1}"
        yield _table(title, _given(joint))
        if isinstance(joint, Planetary):
            for named in derived.named_meshes(joint):
                given = (*_given(named.mesh.stiffness), *_given(named.mesh))
                rows = [*given, *derived.derived_mesh(joint, named)]
                yield _table(f"{title}, {named.title}", rows)
        yield _table(f"{title}, derived", derived.derived_joint(joint))
        rows = [*_given(arm.links[place]), *derived.derived_link(arm, place)]
        yield _table(f"link {place + 1}", rows)
    yield _table("arm", [*_given(arm), *derived.derived_arm(arm)])
    if is_the_papers(arm):
        return
    try:
        rows = list(derived.derived_experiments(sizes_of(arm)))
    except InputError as error:
        rows = [DerivedQuantity("none", error.allowed)]
    yield _table("experiments of its size", rows)


def _given(record: Data | PlanetMesh) -> Iterator[DerivedQuantity]:
    """The values of a record itself, not of what it holds, nor of the file around it."""
    for field in described(Mesh if isinstance(record, PlanetMesh) else type(record)):
        value = getattr(record, field.name)
        if value is not None and not field.records and field.name not in OF_THE_FILE:
            yield DerivedQuantity(field.name, value, field.unit)


def _table(title: str, rows: Iterator[DerivedQuantity] | list[DerivedQuantity]) -> Table:
    table = Table("quantity", "value", "unit", title=title, title_justify="left", box=None)
    for quantity in rows:
        table.add_row(quantity.name, _shown(quantity.value), quantity.unit)
    return table


def _shown(value: float | str | tuple[float, ...]) -> str:
    """Of a long list its first values and their number."""
    if isinstance(value, str):
        return value
    if isinstance(value, tuple):
        listed = ", ".join(f"{entry:.10g}" for entry in value[:MOST_LISTED])
        more = f", ... ({len(value)} values)" if len(value) > MOST_LISTED else ""
        return listed + more
    return f"{value:.10g}"
