"""Every number of a result has its place, whatever order batches come in, or fails as a line."""

import errno
import io
import resource
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.cli.environment import require_memory
from crosscheck.models.errors import InputError, Unfinished
from crosscheck.output import draft
from crosscheck.runner.outcomes import Failure
from crosscheck.studies.batches import batches
from crosscheck.studies.batches.result_file import PAGE, ResultFile, _Sparse
from crosscheck.studies.measures.columns import Column, list_columns
from tests.processes import command_line, in_child, limit_files, warm_command_line
from tests.studies.studies import RIGHT, study

AXES = [
    {"path": "arm.payload_mass_kg", "kind": "grid", "start": 5, "stop": 15, "count": 3},
    {"path": "switches.phase", "kind": "list", "values": ["angle", "omega_t"]},
]
QUANTITIES = [{"kind": "peak", "signal": "theta"}, {"kind": "trajectories", "signals": ["F_sp"]}]


@given(st.lists(st.tuples(st.integers(0, 3 * PAGE), st.binary(max_size=PAGE + 9)), max_size=6))
def test_a_file_in_memory_is_like_any_other(writes):
    sparse, plain = _Sparse(), io.BytesIO()
    for place, data in writes:
        for file in (sparse, plain):
            file.seek(place)
            if data:
                file.write(data)
    sparse.seek(0)
    assert sparse.readall() == plain.getvalue()
    sparse.seek(0, io.SEEK_END)
    assert sparse.tell() == len(plain.getvalue())


@pytest.mark.parametrize("starts", [None, {"count": 4}])
def test_numbers_are_where_they_belong_whatever_comes_first(tmp_path, starts):
    more = {} if starts is None else {"starts": starts}
    made = study(AXES, QUANTITIES, spot_checks=2, **more)
    wanted = list_columns(made)
    generator = np.random.default_rng(1)
    numbers = {c.name: generator.normal(size=(made.count, *c.shape)) for c in wanted}
    out = tmp_path / "out.nc"
    with draft(tmp_path) as new:
        result = ResultFile(new, made, wanted, [1, 4], "version")
        cuts = [0, *sorted(generator.choice(range(1, made.count), 3, replace=False)), made.count]
        parts = list(pairwise(cuts))
        for number in generator.permutation(len(parts)):
            begin, end = parts[number]
            result.write(begin, {name: values[begin:end] for name, values in numbers.items()})
        for column in wanted:
            assert np.array_equal(result.numbers(column.name, 4, 1)[0], numbers[column.name][4])
            spread = np.ptp(numbers[column.name], axis=0)
            assert np.array_equal(result.spread(column.name), spread)
        new.publish(out)
    with xr.open_dataset(out) as found:
        for column in wanted:
            expected = numbers[column.name].reshape(*made.shape, *column.shape)
            assert np.array_equal(found[column.name].values, expected)
            assert found[column.name].attrs["units"] == column.unit
        assert found.checked.values.tolist() == [1, 4]


@pytest.mark.parametrize("kilobytes", [1, 9])
def test_a_disk_that_is_full_is_one_line(tmp_path, kilobytes):
    arguments = ("sweep", RIGHT, "--out", tmp_path / "out.nc", "--jobs", 1)
    answer = warm_command_line(*arguments, largest=1000 * kilobytes)
    assert (answer.returncode, answer.stdout, answer.stderr.count("\n")) == (2, "", 1)
    assert "File too large" in answer.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("megabytes", [200, 500])
def test_a_limit_of_memory_is_one_line(tmp_path, megabytes):
    limit = partial(resource.setrlimit, resource.RLIMIT_AS, (megabytes * 10**6, megabytes * 10**6))
    answer = command_line("sweep", RIGHT, "--out", tmp_path / "out.nc", preexec_fn=limit)
    assert (answer.returncode, answer.stdout, answer.stderr.count("\n")) == (2, "", 1)
    assert "crosscheck: memory: " in answer.stderr


@pytest.mark.parametrize("error", [MemoryError("big"), OSError(errno.ENOMEM, "no memory")])
def test_memory_that_runs_out_is_one_line(error):
    with pytest.raises(InputError, match=r"is not enough: (big|no memory)"), require_memory():
        raise error


def test_room_is_taken_before_anything_is_written(tmp_path):
    def refused() -> None:
        limit_files(5000)
        with draft(tmp_path) as new, pytest.raises(OSError, match="too large"):
            new.reserve(5001)
        with draft(tmp_path) as new:
            new.reserve(5000)
            new.write_at(4000, bytes(1000))
            assert new.path.stat().st_size == 5000

    assert in_child(refused)


class Answers:
    """Workers whose answers are prepared: of each task in turn."""

    def __init__(self, **answers: list[Any]) -> None:
        self.answers, self.asked = answers, list[str]()

    def stream(self, tasks):
        """Each task's key with the next of its answers."""
        for task in tasks:
            self.asked.append(task.key)
            yield task.key, self.answers[task.key].pop(0)


DIED = Failure(batches.DIED, "SIGKILL")


def run_locally(workers: Answers) -> dict[str, Any]:
    tasks = [batches.BatchTask(key, len, ()) for key in list(workers.answers)]
    return {task.key: found for task, found in batches.perform_tasks(workers, tasks)}


def test_a_batch_whose_worker_dies_is_tried_three_times_before_what_follows():
    workers = Answers(a=[1], b=[DIED, DIED, 2], c=[3])
    assert run_locally(workers) == {"a": 1, "b": 2, "c": 3}
    assert workers.asked == ["a", "b", "b", "b", "c"]
    with pytest.raises(Unfinished, match="no end: Died: SIGKILL in 3 attempts; --resume goes on"):
        run_locally(Answers(a=[DIED, DIED, DIED]))
    slow = Failure("TooSlow", "stopped")
    with pytest.raises(Unfinished, match="no end: TooSlow: stopped; --resume goes on"):
        run_locally(Answers(a=[slow]))
    with pytest.raises(ZeroDivisionError):
        run_locally(Answers(a=[batches._TaskError(ZeroDivisionError())]))


def test_spot_checks_are_in_the_middle_of_equal_parts():
    values = {"path": "arm.payload_mass_kg", "kind": "list", "values": [float(n) for n in range(9)]}
    for count, places in ((1, [4]), (3, [1, 4, 7]), (9, list(range(9))), (20, list(range(9)))):
        tasks = batches.make_check_tasks(study([values], spot_checks=count), "version")
        assert [task.arguments[1] for task in tasks] == places
        assert len({task.key for task in tasks}) == len(places)


def test_numbers_of_a_batch_come_back_as_they_were_packed():
    columns = [Column(name, "m", "") for name in "ac"]
    columns.insert(1, Column("b", "rad", "", ("joint",), (2,)))
    numbers = {"a": np.array([1.0, np.nan, 3.0]), "b": np.arange(6.0).reshape(3, 2)}
    numbers["c"] = np.array([7.0, 8.0, 9.0])
    content = batches.pack_numbers(numbers, columns)
    found = batches.unpack_numbers(content, columns, 3)
    for name, values in numbers.items():
        assert np.array_equal(found[name], values, equal_nan=True)
    with pytest.raises(ValueError, match="holds 12 numbers, 16 are needed"):
        batches.unpack_numbers(content, columns, 4)
