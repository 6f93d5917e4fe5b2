"""A user's functions: arguments by name, motors, answers checked, tracebacks."""

from __future__ import annotations

import functools
import inspect
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from traceback import StackSummary, TracebackException
from types import CellType, CodeType, FunctionType, SimpleNamespace
from typing import Any

import numpy as np

from crosscheck.checks.answers import BadAnswer
from crosscheck.models.errors import InputError, describe_type, format_line
from crosscheck.runner.outcomes import Failure, failure_from_error
from crosscheck.trial.input.arrays import NotNumbers, convert_to_numbers, format_vector
from crosscheck.trial.input.equations import Equations

Arguments = Mapping[str, Any]
# What parameters of a user's functions may be called, and what they get.
SYNONYMS = {
    "t": ("t", "time"),
    "x": ("x", "q"),
    "v": ("v", "qd", "dq", "q_dot", "qdot", "xd", "dx", "x_dot", "xdot"),
    "a": ("a", "qdd", "ddq", "q_ddot", "qddot", "xdd", "ddx", "x_ddot", "xddot"),
    "torque": ("torque", "torques", "tau", "T"),
}
MEANT = {word: argument for argument, words in SYNONYMS.items() for word in words}
# What each function may ask for, in the order in which one without names gets it.
TAKES: dict[str, tuple[str, ...]] = {
    "mass_matrix": ("x",),
    "bias": ("x", "v"),
    "coriolis": ("x", "v"),
    "force": ("t", "x", "v", "torque"),
    "acceleration": ("t", "x", "v", "torque"),
    "inverse_dynamics": ("x", "v", "a"),
    "gravity": ("x",),
}
LOADS = ("force", "acceleration")  # parts that a torque belongs to
MATRICES = ("mass_matrix", "coriolis")
LAMBDIFIED = "<lambdifygenerated"  # file name that SymPy gives to a function that it writes
# These packages' frames count where we call them; a user's own frame comes before those of a
# user's call. FMPy calls a unit, of which Python has no frame.
CALLING_PACKAGES = ("crosscheck", "numpy", "fmpy")


def select_parts(names: Mapping[str, Any]) -> SimpleNamespace:
    """The parts of equations among the names of a file, with its coordinates, motors and friction.

    These two names of friction mean nothing else; level and torque may be anything in a file.
    """
    kept = (*TAKES, "coordinates", "drive", "viscous_friction", "coulomb_friction")
    return SimpleNamespace(**{name: names[name] for name in kept if name in names})


def call_part(
    call: Callable[[Arguments], Any],
    part: str,
    size: int,
    arguments: Arguments,
    coordinates: str = "x",
) -> np.ndarray:
    """The answer of a part to copies of its arguments, (size,) or (size, size).

    coordinates: what errors call them. Raises BadAnswer for an answer of another shape or kind, and
    whatever the function raises.
    """
    copies: dict[str, Any] = {name: np.array(value) for name, value in arguments.items()}
    if "t" in arguments:
        copies["t"] = float(arguments["t"])
    try:
        raw = call(copies)
    except BaseException as error:  # also SystemExit
        error.add_note(f"{part}{_describe_state(arguments, coordinates)}")
        raise
    try:
        return convert_to_numbers(raw, (size, size) if part in MATRICES else (size,))
    except NotNumbers as error:
        raise BadAnswer(
            format_line(f"{part} {error}{_describe_state(arguments, coordinates)}")
        ) from None


def _describe_state(arguments: Arguments, coordinates: str) -> str:
    """The state at which a function was asked, as words for an error line."""
    words = {"x": coordinates}
    vectors = {name: format_vector(np.atleast_1d(value)) for name, value in arguments.items()}
    return f" at {', '.join(f'{words.get(n, n)} = {text}' for n, text in vectors.items())}"


def find_motors(
    equations: Equations, calls: Mapping[str, NamedCall], names: Sequence[str]
) -> tuple[int, ...]:
    """The joints that have a motor, from 0, by what equations state or their functions take.

    Without a statement all have one, but none where no force or acceleration takes a torque. Of
    equations that are made for a scenario the drive may be a part. names: of the joints. Raises
    InputError for a joint that is none.
    """
    if equations.drive is not None:
        return parse_motors(equations.drive, names)
    loads = [calls[part] for part in LOADS if part in calls]
    takes_torque = any("torque" in call.arguments for call in loads)
    if loads and not takes_torque and not equations.any_scenario:
        return ()
    return tuple(range(len(names)))


def parse_motors(drive: Any, names: Sequence[str]) -> tuple[int, ...]:
    """Numbers of joints, from 0, of those that a drive names. Raises InputError."""
    listed = list(drive) if isinstance(drive, list | tuple) else [drive]
    numbers: dict[object, int] = {name: number for number, name in enumerate(names)}
    numbers |= {number + 1: number for number in range(len(names))}
    known = [each for each in listed if type(each) in (int, str) and each in numbers]
    motors = tuple(numbers[each] for each in known)
    if known != listed or len(set(motors)) < len(motors) or not isinstance(drive, list | tuple):
        reason = f"must be a list of joints, each once, of 1 to {len(names)} or {', '.join(names)}"
        raise InputError("equations", "drive", drive, reason)
    return motors


def add_motors(
    calls: Mapping[str, NamedCall], equations: Equations, motors: Sequence[int]
) -> dict[str, NamedCall | MotorCall]:
    """The functions, those of torques with their motors where equations state these."""
    if equations.drive is None:
        return dict(calls)
    return {
        part: MotorCall(call, motors) if "torque" in call.arguments else call
        for part, call in calls.items()
    }


@dataclass(frozen=True)
class NamedCall:
    """A user's function as one of all its arguments by name.

    arguments: those that it takes, in the order of those by position; keywords: the names by which
    it takes some of them.
    """

    function: Callable[..., Any]
    positional: tuple[str, ...] = ()
    keywords: Mapping[str, str] = field(default_factory=dict)

    @property
    def arguments(self) -> frozenset[str]:
        """The arguments that the function takes."""
        return frozenset((*self.positional, *self.keywords.values()))

    def __call__(self, arguments: Arguments) -> Any:
        """The function's answer, whatever it is."""
        by_keyword = {name: arguments[meant] for name, meant in self.keywords.items()}
        return self.function(*(arguments[meant] for meant in self.positional), **by_keyword)


class MotorCall:
    """A function of the motors' torques, in the form in which its author takes them.

    Which form that is shows the first call: the first one that the function takes and that it
    depends on.
    """

    def __init__(self, call: NamedCall, motors: Sequence[int]) -> None:
        self.call, self.motors = call, list(motors)
        self._form: Callable[[np.ndarray], Any] | None = None

    @property
    def arguments(self) -> frozenset[str]:
        """The arguments that the function takes."""
        return self.call.arguments

    def __call__(self, arguments: Arguments) -> Any:
        """The function's answer, whatever it is; torque (joints,) among its arguments."""
        if self._form is None:
            self._form = self._choose_form(arguments)
        return self.call({**arguments, "torque": self._form(arguments["torque"])})

    def _choose_form(self, arguments: Arguments) -> Callable[[np.ndarray], Any]:
        motors, shape = self.motors, np.shape(arguments["x"])
        forms: list[Callable[[np.ndarray], Any]] = [np.copy, lambda torque: torque[motors]]
        if len(motors) == 1:
            forms.append(lambda torque: float(torque[motors[0]]))
        other_torque = np.array(arguments["torque"])
        other_torque[motors] += 1.0 + np.abs(other_torque[motors])
        for form in forms:
            copies = [
                {name: np.copy(value) for name, value in arguments.items()} | {"torque": form(each)}
                for each in (arguments["torque"], other_torque)
            ]
            try:
                values = [convert_to_numbers(self.call(each), shape) for each in copies]
            except Exception:  # of the user's code, which may take another form
                continue
            if (values[0] != values[1]).any():
                return form
        return forms[0]


def make_named_calls(equations: Equations) -> dict[str, NamedCall]:
    """A user's functions by part, each as one of all its arguments by name.

    A function whose parameters all have names of the user's own gets the part's arguments in their
    order, if they are as many; what its names mean, they mean in the other functions too. Raises
    InputError.
    """
    given = {part: getattr(equations, part) for part in TAKES}
    functions = {part: function for part, function in given.items() if function is not None}
    parameters = {part: list_parameters(function) for part, function in functions.items()}
    user_names = dict[str, str]()
    for part, listed in parameters.items():
        required = [p for p in listed or [] if p.default is p.empty]
        if _is_renamed(required, part):
            user_names |= zip([p.name for p in required], TAKES[part], strict=True)
    return {
        part: _make_named_call(function, parameters[part], part, user_names)
        for part, function in functions.items()
    }


def _make_named_call(
    function: Any,
    parameters: Sequence[inspect.Parameter] | None,
    part: str,
    user_names: Mapping[str, str],
) -> NamedCall:
    if not callable(function):
        reason = f"is {describe_type(function)}; must be a function of {', '.join(TAKES[part])}"
        raise InputError("equations", part, None, reason)
    if inspect.ismethod(function) and not isinstance(function.__self__, type):
        first = next(iter(list_parameters(function.__func__) or ()), None)
        if first and first.name in MEANT:
            reason = f"is a method whose first parameter is {first.name}; must be self"
            raise InputError("equations", part, None, reason)
    if callable(getattr(function, "name_in", None)):  # a casadi Function
        return NamedCall(function, _casadi_arguments(function, part))
    if parameters is None:
        return NamedCall(function, TAKES[part])
    required = [p for p in parameters if p.default is p.empty]
    if _is_nameless(function, required) or _is_renamed(required, part):
        return NamedCall(function, _first_arguments(part, len(required)))
    meant = {**user_names, **_list_meanings((p.name for p in parameters), part)}
    used_parameters = [
        p for p in parameters if p.default is p.empty or meant.get(p.name) in TAKES[part]
    ]
    for parameter in used_parameters:
        _require_meaning(parameter.name, part, meant)
    before = tuple(meant[p.name] for p in used_parameters if p.kind == p.POSITIONAL_ONLY)
    return NamedCall(
        function,
        before,
        {p.name: meant[p.name] for p in used_parameters if p.kind != p.POSITIONAL_ONLY},
    )


def list_parameters(function: Any) -> list[inspect.Parameter] | None:
    """The parameters that are still free; None where nobody knows, or there may be any number."""
    try:
        parameters = list(read_signature(function).parameters.values())
    except (TypeError, ValueError):  # a builtin, an extension's function, or no function at all
        return None
    if any(p.kind == p.VAR_POSITIONAL for p in parameters):
        return None
    fixed = function.keywords if isinstance(function, functools.partial) else {}
    return [p for p in parameters if p.name not in fixed and p.kind != p.VAR_KEYWORD]


def read_signature(function: Any) -> inspect.Signature:
    """The signature of a function, read once of all that were made by the same code.

    Raises TypeError and ValueError as inspect does.
    """
    is_plain = type(function) is FunctionType and not function.__dict__
    if not is_plain or function.__defaults__ or function.__kwdefaults__:
        return inspect.signature(function)
    return _read_code_signature(function.__code__)


@functools.lru_cache(maxsize=256)
def _read_code_signature(code: CodeType) -> inspect.Signature:
    """The signature of functions of this code that have no defaults."""
    cells = tuple(CellType() for _ in code.co_freevars)
    return inspect.signature(FunctionType(code, {}, closure=cells))


def _list_meanings(names: Iterable[str], part: str) -> dict[str, str]:
    """Meaning of parameters of a part's function, with that of u, which has two.

    Beside a rate it is the motors' torque, as in control engineering; else a rate, as Kane's
    generalized speeds, if the part takes no torque or takes it by another name.
    """
    there = {MEANT.get(name) for name in names}
    if "v" in there:
        return {**MEANT, "u": "torque"}
    return MEANT if part in LOADS and "torque" not in there else {**MEANT, "u": "v"}


def _is_nameless(function: Any, required: Sequence[inspect.Parameter]) -> bool:
    """Whether the names of parameters mean nothing: sympy's lambdify and C functions make them."""
    name_matches = [parameter.name in MEANT for parameter in required]
    code = getattr(function, "__code__", None)
    if code is not None and code.co_filename.startswith(LAMBDIFIED):
        return not all(name_matches)
    by_place = all(parameter.kind == parameter.POSITIONAL_ONLY for parameter in required)
    return bool(required) and by_place and not any(name_matches)


def _is_renamed(required: Sequence[inspect.Parameter], part: str) -> bool:
    """Whether all names of parameters are a user's own, and as many as the part has arguments."""
    are_unknown = all(p.name not in MEANT and p.kind != p.KEYWORD_ONLY for p in required)
    return are_unknown and len(required) == len(TAKES[part])


def _require_meaning(name: str, part: str, meant: Mapping[str, str]) -> None:
    if meant.get(name) in TAKES[part]:
        return
    allowed = "; ".join(", ".join(SYNONYMS[argument]) for argument in TAKES[part])
    raise InputError("equations", part, None, f"takes {name}, which is none of {allowed}")


def _first_arguments(part: str, count: int) -> tuple[str, ...]:
    """The first `count` arguments of a part; torque, the last, may be left out."""
    order = TAKES[part]
    if count != len(order) and order[:count] != tuple(name for name in order if name != "torque"):
        reason = f"takes {count} arguments without names, must take {', '.join(order)}"
        raise InputError("equations", part, None, reason)
    return order[:count]


def _casadi_arguments(function: Any, part: str) -> tuple[str, ...]:
    """The arguments that a casadi Function's inputs mean, in their order.

    They go by their names, or by their order where they were given none (i0, i1).
    """
    names = list(function.name_in())
    if function.n_out() != 1:
        reason = f"gives {function.n_out()} outputs, must be one"
        raise InputError("equations", part, None, reason)
    if names == [f"i{k}" for k in range(len(names))]:
        return _first_arguments(part, len(names))
    meant = _list_meanings(names, part)
    for name in names:
        _require_meaning(name, part, meant)
    return tuple(meant[name] for name in names)


def describe_failure(error: BaseException) -> Failure:
    """An exception with the state at which it was raised and, if it is the user's, its traceback.

    The message is one line of at most 400 characters. The traceback is without the frames by which
    the user's code was reached; of chained exceptions all are shown, without notes.
    """
    package_folders = {
        Path(str(sys.modules[package].__file__)).parent
        for package in CALLING_PACKAGES
        if package in sys.modules
    }
    failure = failure_from_error(error)
    place = format_line("; ".join(getattr(error, "__notes__", ())))
    whole = TracebackException.from_exception(error, compact=True)
    trace: TracebackException | None = whole
    users = False
    while trace is not None:
        frames = list(trace.stack)
        while frames and not package_folders.isdisjoint(Path(frames[0].filename).parents):
            frames.pop(0)
        trace.stack, trace.__notes__ = StackSummary.from_list(frames), []
        users = users or bool(frames)
        trace = trace.__cause__ or trace.__context__
    text = "".join(whole.format()) if users else ""
    return replace(failure, message=format_line(failure.message), trace=text, place=place)
