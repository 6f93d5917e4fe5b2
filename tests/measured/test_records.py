"""Files of recorded motions: four formats say the same, and what is wrong with one is one line."""

import os
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from syrupy.assertion import SnapshotAssertion

from crosscheck.models import inputs
from crosscheck.models.errors import InputError
from crosscheck.recordings.record import Record, describe_gaps, read_record, require_even_enough
from crosscheck.recordings.smoothing import check_rates
from tests.measured.records import level, name_columns, record_of, write_table
from tests.tool.test_bad_input import assert_one_line

JOINT_STATE, TIME = "sensor_msgs/msg/JointState", "builtin_interfaces/msg/Time"
HEADER = "t_s,theta_1_rad,theta_2_rad,torque_1_N_m,torque_2_N_m"


@pytest.fixture(scope="module")
def record(labelled) -> Record:
    return record_of(level(labelled, "coupled"), rows=600)


def written(record: Record, path: Path) -> Path:
    return write_table(path, name_columns(record))


def assert_same(found: Record, record: Record) -> None:
    assert np.array_equal(found.time, record.time)
    assert np.array_equal(found.position, record.position)
    assert np.array_equal(found.motor_torque, record.motor_torque)
    assert found.rates is None


def test_every_format_says_the_same(record, tmp_path):
    assert_same(read_record(written(record, tmp_path / "r.csv"), 2), record)
    named = {"t_s": record.time, "theta_rad": record.position, "torque_N_m": record.motor_torque}
    text = (tmp_path / "r.csv").read_text()
    (tmp_path / "r.csv").write_text(text.replace(",", ";").replace(".", ","))
    assert_same(read_record(tmp_path / "r.csv", 2), record)
    scipy.io.savemat(tmp_path / "r.mat", named)
    assert_same(read_record(tmp_path / "r.mat", 2), record)
    whole = np.round(1e3 * record.time).astype(np.uint16)  # as MATLAB keeps whole numbers
    other = {"t_ms": whole, "theta_deg": np.degrees(record.position)}
    scipy.io.savemat(tmp_path / "w.mat", other | {"torque_N_m": record.motor_torque})
    assert read_record(tmp_path / "w.mat", 2).time == pytest.approx(whole / 1e3)
    assert read_record(tmp_path / "w.mat", 2).position == pytest.approx(record.position)
    for block in (0, 512):  # MATLAB writes behind its own 512 bytes, and column by column
        with h5py.File(tmp_path / "r.h5", "w", userblock_size=block) as file:
            for name, values in named.items():
                file[name] = values.T if block else values
        if block:
            with (tmp_path / "r.h5").open("r+b") as written_file:
                written_file.write(b"MATLAB 7.3 MAT-file")
        assert_same(read_record(tmp_path / "r.h5", 2), record)


def test_a_joint_may_stand_as_long_as_another_moves(record, tmp_path):
    still = replace(record, position=record.position * [0.0, 1.0])
    assert_same(read_record(written(still, tmp_path / "r.csv"), 2), still)
    check_rates(replace(still, rates=np.gradient(still.position, still.time, axis=0)))


def test_gaps_of_a_record_are_said(record, tmp_path):
    time = record.time.copy()
    for row, later in ((100, 6e-3), (200, 3e-3), (300, 11e-3)):  # seven, four and twelve steps
        time[row:] += later
    found = read_record(written(replace(record, time=time), tmp_path / "r.csv"), 2)
    (note,) = found.notes
    assert note.startswith("the times have 2 gaps, the widest of 12 usual steps after 0.308 s")
    (one,) = describe_gaps(np.array([0.0, 1.0, 2.0, 8.0, 9.0]))
    assert one.startswith("the times have a gap of 6 usual steps after 2 s")


@pytest.mark.parametrize(("unit", "is_asked"), [("rad", True), ("deg", False)])
def test_radians_of_many_turns_are_asked_about(record, tmp_path, caplog, unit, is_asked):
    inputs.forget()
    columns = {**name_columns(record), "theta_2_rad": np.linspace(0, -90, len(record.time))}
    renamed = {name.replace("_rad", f"_{unit}"): values for name, values in columns.items()}
    read_record(write_table(tmp_path / "r.csv", renamed), 2)
    question = f"note: {tmp_path}/r.csv: theta_2_rad: -90 rad = 14.3 turns: is it in degrees?"
    question += " Then name it with _deg"
    slide = {"t_s": record.time, "theta_rad": columns["theta_2_rad"]}
    read_record(write_table(tmp_path / "slide.csv", slide), 1, slides=(1,))  # 90 m are no turns
    assert caplog.messages == [question] * is_asked


def cell(text: str, row: int, column: int, value: str) -> str:
    lines = [line.split(",") for line in text.splitlines()]
    lines[row][column] = value
    return "\n".join(",".join(line) for line in lines) + "\n"


def scaled(text: str, columns: list[int], factor: float) -> str:
    head, *lines = text.splitlines()
    rows = np.array([line.split(",") for line in lines], dtype=float)
    rows[:, columns] *= factor
    return "\n".join([head, *(",".join(map(repr, row)) for row in rows.tolist())]) + "\n"


def shifted(text: str, row: int, seconds: float, count: int = 1) -> str:
    """So many steps from a row on are longer by so much."""
    head, *lines = text.splitlines()
    rows = [line.split(",", 1) for line in lines]
    later = [seconds * min(max(n - row + 1, 0), count) for n in range(len(rows))]
    moved = (f"{float(t) + more!r},{rest}" for (t, rest), more in zip(rows, later, strict=True))
    return "\n".join([head, *moved]) + "\n"


def swap(old: str, new: str) -> Callable[[str], str]:
    return lambda text: text.replace(old, new)


def put(row: int, column: int, value: str) -> Callable[[str], str]:
    return lambda text: cell(text, row, column, value)


HEADERS = (
    *(("t_s", "clock"), ("t_s", "t"), ("theta_", "phi_"), ("theta_1_rad", "theta_1")),
    *(("theta_2_rad", "theta_1_deg"), ("theta_2_rad", "angle_rad"), ("theta_2_rad", "theta_3_rad")),
    *(("theta_2_rad", "theta_2_m"), ("theta_2_rad", "theta_1_rad")),
    *(("torque_2_N_m", "torque_3_N_m"), ("torque_2_N_m", "current_2_A"), ("theta_1", "theta_0")),
    *(("theta_1", "theta_" + "9" * 5000), ("torque", "effort"), (HEADER, "Time,q1,Q2,tau1,tau2")),
    *((HEADER, "t,joint_0,joint_1,effort_0,effort_1"), (HEADER, "clock,a,b,c,d")),
    (HEADER, "Zeit,phi1,phi2,Moment1,Moment2"),
)
BAD: dict[str, Callable[[str], str]] = {
    **{f"{old} is {new[:40]}": swap(old, new) for old, new in HEADERS},
    "a time that repeats": put(9, 0, "0.007"),
    "a time that goes back": put(9, 0, "-1"),
    "a gap": put(5, 2, "nan"),
    "a word": put(5, 1, "n/a"),
    "an empty cell": put(5, 1, ""),
    "a short line": lambda text: text + "0.7,1\n",
    "numbers for names": lambda text: cell(text, 0, 0, "0").partition("\n")[2],
    "a huge angle": put(5, 1, "1e300"),
    "a huge negative angle": put(5, 1, "-1e300"),
    "a huge torque": put(5, 3, "1e300"),
    "a huge time": put(600, 0, "1e300"),
    "nanoseconds apart": lambda text: scaled(text, [0], 1e-9),
    "nothing moves": lambda text: scaled(text, [1, 2], 0.0),
    "a gap of 30 years": lambda text: shifted(text, 300, 1e9),
    "a gap of a second": lambda text: shifted(text, 300, 1.0),
    "a stretch of long steps": lambda text: shifted(text, 300, 1e8, 6),
    "a decimal comma": put(5, 1, "0,5"),
    "a single row": lambda text: "\n".join(text.splitlines()[:2]) + "\n",
    "no rows": lambda text: HEADER + "\n",
    "nothing": lambda text: "",
}


@pytest.mark.parametrize(
    ("rows", "gap", "motion", "latest"),
    [(63, 1.0, 1.0, 1.0), (64, 1.0, 0.98e-6, 1.0), (64, 1.0, 1.0, 1.02e10), (200, 20.4, 1.0, 1.0)],
)
def test_a_record_just_beyond_its_limits_is_refused_and_just_within_taken(
    rows, gap, motion, latest
):
    """Rows at least, longest step over the mean one, movement, and latest time."""

    def make(rows, gap, motion, latest):
        steps = np.ones(rows - 1)
        steps[5] = gap * (rows - 2) / (rows - 1 - gap)
        time = latest * np.append(0.0, np.cumsum(steps)) / steps.sum()
        return Record("made", time, np.linspace(0.0, motion, rows)[:, None])

    with pytest.raises(InputError):
        make(rows, gap, motion, latest)
    make(64 if rows < 64 else rows, min(gap, 19.6), max(motion, 1.02e-6), min(latest, 0.98e10))


WRITTEN = {  # another way to write the same table
    "a column of words": lambda rows: [",".join([*row[:2], "base_link", *row[2:]]) for row in rows],
    "an empty column": lambda rows: [",".join([*row[:2], "", *row[2:]]) for row in rows],
    "gaps in an unused column": lambda rows: [
        ",".join([*row, "3" if n % 2 else ""]) for n, row in enumerate(rows)
    ],
    "quoted words": lambda rows: [
        ",".join([*row, ' "a, b"' if n else "note"]) for n, row in enumerate(rows)
    ],
    "an unused column twice": lambda rows: [",".join([*row, "note", "note"]) for row in rows],
    "a hash before the names": lambda rows: ["# " + ",".join(rows[0]), *map(",".join, rows[1:])],
    "a byte order mark": lambda rows: ["\ufeff" + ",".join(rows[0]), *map(",".join, rows[1:])],
    "blanks": lambda rows: map(" ".join, rows),
    "several blanks": lambda rows: ["  " + "   ".join(row) + " " for row in rows],
    "blanks and a hash": lambda rows: ["# " + " ".join(rows[0]), *map(" ".join, rows[1:])],
    "blank lines": lambda rows: [line for row in rows for line in (",".join(row), "  ")],
    "decimal commas": lambda rows: [" ".join(row).replace(".", ",") for row in rows],
}


@pytest.mark.parametrize("case", WRITTEN)
def test_what_is_not_used_may_be_anything(record, tmp_path, case):
    path = written(record, tmp_path / "r.csv")
    rows = [line.split(",") for line in path.read_text().splitlines()]
    path.write_text("\n".join(WRITTEN[case](rows)) + "\n", encoding="utf-8")
    assert_same(read_record(path, 2), record)


def test_joints_that_slide_have_their_own_units(record, tmp_path):
    path = written(record, tmp_path / "r.csv")
    named = (
        path.read_text().replace("theta_2_rad", "theta_2_mm").replace("torque_2_N_m", "torque_2_N")
    )
    path.write_text(named)
    found = read_record(path, 2, slides=(2,))
    np.testing.assert_allclose(found.position, record.position * [1, 1e-3], rtol=1e-15)
    np.testing.assert_array_equal(found.motor_torque, record.motor_torque)
    path.write_text(named.replace("theta_2_mm", "theta_2_deg"))
    with pytest.raises(InputError, match="joint 2 slides; must be theta_2_m or theta_2_mm"):
        read_record(path, 2, slides=(2,))


@pytest.mark.parametrize("case", BAD)
def test_bad_table_is_one_line(refuse, record, tmp_path, case, snapshot: SnapshotAssertion):
    text = BAD[case](written(record, tmp_path / "r.csv").read_text())
    said = refuse("compare r.csv --json c.json --out page", {"r.csv": text})
    assert re.sub(r"\d+\.\d{7,}", "#", said) == snapshot


UNEVEN = {
    "r.csv: time, data row 3: must be a number up to 1e+10 s": [0.0, 0.01, np.nan, 0.03],
    "r.csv: time, data row 4 = 0.01: is before row 3 (0.02); must rise": [
        *(0.0, 0.01, 0.02, 0.01, 0.03)
    ],
    "r.csv: time, data row 3 = 0.01: is that of row 2; must rise": [0.0, 0.01, 0.01, 0.02],
    "r.csv: time, data row 3 = 1732000000.623: is that of row 2; must rise": [
        *(1732000000.613, 1732000000.623, 1732000000.623)
    ],
    "r.csv: time, data row 3 = 1732000000.622: is before row 2 (1732000000.623); must rise": [
        *(1732000000.613, 1732000000.623, 1732000000.622)
    ],
    "r.csv: time, data row 5 = 3.03: is 3 s after the row before; cut the record"
    " where it has gaps": [*(0.0, 0.01, 0.02, 0.03, 3.03), *(3.03 + 0.01 * np.arange(1, 40))],
}


@pytest.mark.parametrize("said", UNEVEN)
def test_times_that_no_filter_follows_are_refused(said):
    with pytest.raises(InputError) as error:
        require_even_enough("r.csv", np.array(UNEVEN[said]))
    assert str(error.value) == said


@pytest.mark.parametrize(
    ("name", "values", "said"),
    [
        ("theta_rad", np.zeros((3, 2, 4)), "theta_rad: has shape (3, 2, 4)"),
        ("theta_rad", np.zeros((10, 3)), "theta_rad: has shape (10, 3); must be (times, 2)"),
        ("theta_1_rad", np.zeros((2, 3, 2)), "theta_1_rad: has shape"),
        ("t_s", np.zeros((10, 2)), "t_s: has shape (10, 2); must be a column"),
        ("theta_2_rad", np.zeros((9, 1)), "theta_2: has 9 rows, theta_1 has 10"),
        ("theta_1_rad", np.zeros((10, 1)) + 1j, "theta_1: is missing"),
    ],
)
def test_bad_arrays_are_one_line(crosscheck, tmp_path, name, values, said):
    column = np.linspace(0.0, 1.0, 10)[:, None]
    usual = {"t_s": column, "theta_1_rad": column, "theta_2_rad": column}
    scipy.io.savemat(tmp_path / "r.mat", usual | {name: values})
    assert_one_line(crosscheck("compare", tmp_path / "r.mat"), said)


@pytest.mark.parametrize("option", ["--topic", "--joint"])
def test_names_of_a_bag_are_refused_of_another_file(crosscheck, tmp_path, option):
    (tmp_path / "r.csv").write_text("t_s\n")
    answer = crosscheck("compare", tmp_path / "r.csv", option, "x")
    assert_one_line(answer, f"{option}: x: is for ROS bags")


@pytest.mark.parametrize("content", [b"", b"\x89HDF\r\n\x1a\nand then nothing", b"MATLAB 5.0 MAT"])
def test_damaged_binary_is_one_line(crosscheck, tmp_path, content):
    path = tmp_path / "r.mat"
    path.write_bytes(content)
    assert_one_line(crosscheck("compare", path), "r.mat: ")


def test_outputs_never_replace_inputs(crosscheck, record, tmp_path):
    path = written(record, tmp_path / "r.csv")
    before = path.read_bytes()
    assert_one_line(crosscheck("compare", path, "--json", path), "r.csv")
    assert path.read_bytes() == before


def test_external_data_are_not_followed(tmp_path):
    with h5py.File(tmp_path / "r.h5", "w") as file:
        file.create_dataset(
            "t_s", (10,), "f8", external=[(str(tmp_path / "secret"), 0, h5py.h5f.UNLIMITED)]
        )
    with pytest.raises(InputError, match="has no times"):
        read_record(tmp_path / "r.h5", 2)
    elsewhere = h5py.VirtualLayout((10,), "f8")
    elsewhere[:] = h5py.VirtualSource(tmp_path / "secret.h5", "x", (10,))
    with h5py.File(tmp_path / "r.h5", "w") as file:
        file["t_s"] = 0.5  # a single number is a column of one row
        file.create_virtual_dataset("theta_1_rad", elsewhere)
    with pytest.raises(InputError, match="has no angles"):
        read_record(tmp_path / "r.h5", 2)


def bag_of(
    record: Record,
    folder: Path,
    storage: StoragePlugin = StoragePlugin.MCAP,
    *,
    rate: float | None = None,
    effort: float | None = None,
    apart: bool = False,
) -> Path:
    """A ROS 2 bag of the record, its joints in the other order and a gripper beside them.

    rate: of every joint in every message; effort: in place of the record's; apart: the gripper has
    messages of its own, and headers have no times.
    """
    types = get_typestore(Stores.ROS2_JAZZY)
    message, stamp = (types.types[name] for name in (JOINT_STATE, TIME))
    header = types.types["std_msgs/msg/Header"]
    with Writer(folder, version=9, storage_plugin=storage) as bag:
        topic = bag.add_connection("/joint_states", message.__msgtype__, typestore=types)
        signals = record.time, record.position, record.motor_torque
        bag.add_connection("/chatter", "std_msgs/msg/String", typestore=types)
        for time, angles, torques in zip(*signals, strict=True):
            nanoseconds = 1_700_000_000 * 10**9 + round(1e9 * time)
            own = header(stamp(*divmod(nanoseconds * (not apart), 10**9)), "base")
            names, places = ["elbow", "gripper", "shoulder"], [angles[1], 0.5, angles[0]]
            efforts = [torques[1], 0.0, torques[0]] if effort is None else [effort] * 3
            rates = [] if rate is None else [rate] * 3
            states = [(nanoseconds, ["gripper"], ([0.5], [], []))] * apart
            states.append((nanoseconds + 1000, names, (places, rates, efforts)))
            for when, who, numbers in states:
                state = message(own, who, *map(np.array, numbers))
                bag.write(topic, when, types.serialize_cdr(state, state.__msgtype__))
    return folder


JOINTS = ("shoulder", "elbow")
FILLED = {
    "zero rates": ({"rate": 0.0}, "the rates are 0 or no number in every row"),
    "no rates": ({"rate": np.nan}, "the rates are 0 or no number in every row"),
    "no efforts": ({"effort": np.nan}, "the torques are no number in every row"),
    "a gripper": ({"apart": True}, "600 messages without any of the joints are left out"),
}


@pytest.mark.parametrize("case", FILLED)
def test_what_publishers_fill_in_counts_as_not_stated(record, tmp_path, case):
    given, said = FILLED[case]
    found = read_record(bag_of(record, tmp_path / "bag", **given), 2, named=JOINTS)
    assert len(found.notes) == 1
    assert found.notes[0].startswith(said)
    assert np.array_equal(found.position, record.position)
    assert found.rates is None
    assert (found.motor_torque is None) == (case == "no efforts")


@pytest.mark.parametrize("storage", StoragePlugin)
def test_a_bag_is_read_by_the_names_of_its_joints(record, tmp_path, storage):
    folder = bag_of(record, tmp_path / "bag", storage)
    (folder / "notes.yaml").mkdir()
    for path in (folder, next(each for each in folder.iterdir() if each.suffix != ".yaml")):
        found = read_record(path, 2, named=("shoulder", "elbow"))
        assert found.time == pytest.approx(record.time, abs=1e-9)
        assert_same(replace(found, time=record.time), record)
    for topic, named, said in (
        ("", (), "needs --joint .* message 1 has elbow, gripper, shoulder"),
        ("", ("shoulder", "wrist"), "has no joint wrist; message 1 has elbow, gripper, shoulder"),
        ("", ("shoulder",), "must be given 2 times"),
        ("/chatter", ("shoulder", "elbow"), "has no topic /chatter of .*: /joint_states"),
    ):
        with pytest.raises(InputError, match=said):
            read_record(folder, 2, topic, named)


def test_a_bag_that_cannot_be_opened_is_one_line(tmp_path):
    os.mkfifo(tmp_path / "pipe.mcap")
    for name, said in {"gone": "No such file or directory", "pipe": "not a regular file"}.items():
        with pytest.raises(InputError, match=f"/{name}.mcap: cannot be read: {said}$"):
            read_record(tmp_path / f"{name}.mcap", 2, named=("a", "b"))


@pytest.mark.parametrize("name", ["bag", "bag.mcap", "bag.db3", "bag.bag"])
def test_no_bag_is_one_line(crosscheck, tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b"\x89MCAP0\r\nand then nothing") if path.suffix else path.mkdir()
    said = (
        "is not a r" if path.suffix else "is a folder without the metadata.yaml of a ROS bag; name"
    )
    answer = crosscheck("compare", path, "--joint", "a", "--joint", "b")
    assert_one_line(answer, f"{name}: {said}")
