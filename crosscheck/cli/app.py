"""The command line: thin over crosscheck.api; heavy imports wait until a command needs them."""

from __future__ import annotations

import errno
import os
import sys
import traceback
import webbrowser
from contextlib import redirect_stdout
from functools import lru_cache, partial
from importlib.metadata import entry_points
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from typer import Argument, Option

from crosscheck import LARGEST_SEED, __version__
from crosscheck.cli.environment import closing_code, prepare, require_memory
from crosscheck.cli.help import arrange_help
from crosscheck.entry import entry_point_error, load_command
from crosscheck.models.errors import (
    PROGRAM,
    Diverged,
    InputError,
    Unfinished,
    describe_error,
    format_line,
    rephrase,
)
from crosscheck.models.refusals import refuse
from crosscheck.runner.interruption import exit_code, exit_message, was_stopped

make_group = partial(typer.Typer, no_args_is_help=True)
app = make_group(
    help="Check hand-derived equations of motion of any arm or robot against independent engines.",
    pretty_exceptions_enable=False,
)

baseline = make_group(help="Record a cross-check, and find out later what changed.")
app.add_typer(baseline, name="baseline")
cache = make_group(help="Show or clear the files kept between runs.")
app.add_typer(cache, name="cache")

File = Path | None  # type of optional file options
Text = str | None
Texts = list[str] | None
ArmName = Annotated[str, Argument(metavar="ARM", help="Built-in name or TOML file.")]
NAMES = "Name or TOML file of an arm or robot; or a URDF or MJCF."
MechanismName = Annotated[str, Argument(metavar="ARM", help=NAMES)]
Quick = Annotated[bool, Option("--quick", help="Fewer states, shorter runs.")]
Jobs = Annotated[int | None, Option(min=1, max=1000, help="Worker processes (default: all cores).")]
JUnit = Annotated[File, Option("--junit", help="JUnit XML file to write.")]
OpenPage = Annotated[bool, Option("--open", help="Show the page in the browser.")]
STANDARD_OUTPUT = Path("/dev/stdout")
REPORT = Path("report")  # folder of pages


def _resolve_json(context: typer.Context, path: Path | None) -> Path | None:
    """The file that --json names; with - the JSON has the output alone, all else goes to stderr."""
    if path != Path("-"):
        return path
    context.with_resource(redirect_stdout(sys.stderr))
    return STANDARD_OUTPUT


JsonFile = Annotated[
    File, Option("--json", help="JSON file to write, - for the output.", callback=_resolve_json)
]
Scenarios = Annotated[
    Texts,
    Option("--scenario", help="Run this experiment, not the usual ones; name or file, repeatable."),
]
Settings = Annotated[
    Texts,
    Option("--set", metavar="PATH=VALUE", help="Change a value of a file: arm.payload_mass_kg=12."),
]
Seed = Annotated[int, Option(min=0, max=LARGEST_SEED, help="Seed of the random states.")]
TrialModel = Annotated[
    Text, Option("--model", help="Equations to try instead, file.py:name; their code is run.")
]
Baselines = Annotated[Path, Option("--dir", help="Folder of the records.")]


def _print_version(show_version: bool) -> None:
    if show_version:
        print(f"crosscheck {__version__}")
        raise typer.Exit


def _choose_folder(out: Path | None, open_page: bool) -> Path | None:
    """The folder of a page: as it is stated, else the usual one for a page to be shown."""
    return REPORT if out is None and open_page else out


def _show_page(page: Path, open_page: bool) -> None:
    """Show a page in the browser, if that is asked for and it was written."""
    if open_page and page.exists():
        webbrowser.open(page.resolve().as_uri())


@app.callback()
def _options(
    version: Annotated[
        bool, Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


@app.command()
def run(
    arm: MechanismName = "paper-labelled",
    out: Annotated[Path, Option(help="Folder of the report.")] = REPORT,
    open_page: OpenPage = False,
    scenario: Scenarios = None,
    settings: Settings = None,
    quick: Quick = False,
    jobs: Jobs = None,
    seed: Seed = 0,
) -> None:
    """Cross-check all models of an arm or robot; write index.html and agreement.json."""
    from crosscheck.runner.progress import show_starting_status

    with show_starting_status():
        from crosscheck.cli.commands import make_request, run_command

        chosen = make_request(arm, scenario, settings, quick, seed)
    code = run_command(chosen, out, jobs or os.cpu_count() or 1)
    _show_page(out / "index.html", open_page)
    raise typer.Exit(code)


@app.command()
def validate(
    arm: MechanismName = "paper-labelled",
    scenario: Scenarios = None,
    settings: Settings = None,
    quick: Quick = False,
    jobs: Jobs = None,
    seed: Seed = 0,
    json_file: JsonFile = None,
    junit: JUnit = None,
) -> None:
    """Cross-check all models of an arm or robot, without the report page."""
    from crosscheck.runner.progress import show_starting_status

    with show_starting_status():
        from crosscheck.cli.commands import make_request, validate_command

        chosen = make_request(arm, scenario, settings, quick, seed)
    raise typer.Exit(validate_command(chosen, jobs or os.cpu_count() or 1, json_file, junit))


@baseline.command()
def accept(
    arm: MechanismName = "paper-labelled",
    folder: Baselines = Path("baselines"),
    scenario: Scenarios = None,
    settings: Settings = None,
    quick: Quick = False,
    jobs: Jobs = None,
    junit: JUnit = None,
    model: TrialModel = None,
    with_differences: Annotated[
        bool, Option("--with-differences", help="Record failed checks as known differences.")
    ] = False,
) -> None:
    """Cross-check an arm or robot and record the result, unless a check fails."""
    from crosscheck.cli.commands import accept_command, prepare_recording

    chosen, made = prepare_recording(arm, scenario or [], settings or [], quick, model or "")
    processes = jobs or os.cpu_count() or 1
    raise typer.Exit(accept_command(chosen, folder, processes, junit, with_differences, made))


@baseline.command()
def check(
    arm: MechanismName = "paper-labelled",
    folder: Baselines = Path("baselines"),
    scenario: Scenarios = None,
    settings: Settings = None,
    quick: Quick = False,
    jobs: Jobs = None,
    junit: JUnit = None,
    model: TrialModel = None,
) -> None:
    """Repeat a recorded cross-check and show what changed; exit code 1 if anything did."""
    from crosscheck.cli.commands import check_command, prepare_recording, renewal

    chosen, made = prepare_recording(arm, scenario or [], settings or [], quick, model or "")
    renew = renewal(arm, folder, scenario or [], settings or [], quick, model or "")
    processes = jobs or os.cpu_count() or 1
    raise typer.Exit(check_command(chosen, folder, processes, junit, renew, made))


@app.command()
def simulate(
    arm: MechanismName,
    model: Annotated[
        str, Option(help="See `crosscheck list`; for a robot ENGINE:LEVEL, as analytic:coupled.")
    ],
    scenario: Annotated[str, Option(help="Built-in name or TOML file.")],
    out: Annotated[Path, Option(help="NetCDF file to write.")],
    t_end: Annotated[Text, Option(help="Duration in seconds.")] = None,
    step: Annotated[Text, Option(help="Integration step in seconds.")] = None,
    settings: Settings = None,
    force: Annotated[
        bool, Option("--force", help="Run although the step exceeds the stability limit.")
    ] = False,
    rtol: Annotated[
        float | None, Option(help="Relative tolerance: adaptive steps that end at contact changes.")
    ] = None,
) -> None:
    """Simulate one model and write its trajectory."""
    from crosscheck.cli.simulation import simulate_command

    overrides = list(settings or [])
    overrides += [f"scenario.duration_s={t_end}"] if t_end is not None else []
    overrides += [f"scenario.step_s={step}"] if step is not None else []
    simulate_command(arm, model, scenario, overrides, out, force, rtol)


@app.command()
def trial(
    model: Annotated[
        Text,
        Argument(
            metavar="MODEL",
            help="file.py, file.py:name, package.module:name or .fmu; its code is run."
            " Not with --answers.",
        ),
    ] = None,
    arm: Annotated[
        Text,
        Argument(
            metavar="ARM",
            help="Name or TOML file, URDF or MJCF of an arm or robot (default: paper-labelled).",
        ),
    ] = None,
    scenario: Annotated[
        Texts, Option("--scenario", help="Also simulate this experiment; name or file, repeatable.")
    ] = None,
    settings: Settings = None,
    quick: Quick = False,
    jobs: Jobs = None,
    seed: Seed = 0,
    json_file: JsonFile = None,
    junit: JUnit = None,
    out: Annotated[
        File, Option(help="Folder of the page, trial.html, or of the files of --ask.")
    ] = None,
    open_page: OpenPage = False,
    ask: Annotated[
        bool, Option("--ask", help="Write the states at which any tool can answer.")
    ] = False,
    answers: Annotated[
        list[Path] | None,
        Option(help="Judge this CSV or MAT file in place of MODEL; no code is run."),
    ] = None,
    after: Annotated[
        list[Path] | None, Option(help="With --ask: first answers, to add states of other arms.")
    ] = None,
    coordinates: Annotated[
        File,
        Option(help="TOML file of a linear map, with --ask or --answers, or of an FMU's names."),
    ] = None,
    run_code: Annotated[
        bool, Option("--run-code", help="Allow an FMU to run: its binary is code.")
    ] = False,
) -> None:
    """Check your own equations of an arm or a robot: which entry is wrong, and why."""
    from crosscheck.cli.trial import TrialOptions, trial_command

    open_page = open_page and not ask  # which writes no page
    options = TrialOptions(
        names=tuple(name for name in (model, arm) if name is not None),
        scenarios=scenario or [],
        settings=settings or [],
        quick=quick,
        seed=seed,
        jobs=jobs or os.cpu_count() or 1,
        json_file=json_file,
        junit=junit,
        out=_choose_folder(out, open_page),
        ask=ask,
        answers=tuple(answers or ()),
        after=tuple(after or ()),
        coordinates=coordinates,
        run_code=run_code,
    )
    code = trial_command(options)
    _show_page((options.out or REPORT) / "trial.html", open_page)
    raise typer.Exit(code)


@app.command()
def compare(
    record: Annotated[
        Path,
        Argument(
            metavar="RECORD",
            help="CSV, MAT, HDF5 or NetCDF file, ROS bag, or a TOML that describes its columns.",
        ),
    ],
    arm: Annotated[str, Argument(metavar="ARM_OR_ROBOT", help=NAMES)] = "paper-labelled",
    scenario: Annotated[
        Text, Option(help="Take the torques from this scenario's drive, name or file.")
    ] = None,
    settings: Settings = None,
    tolerance: Annotated[
        Texts,
        Option(
            metavar="PATH=SHARE",
            help="Standard uncertainty of a file's number, arm.payload_mass_kg=0.01 for 1 %.",
        ),
    ] = None,
    topic: Annotated[str, Option(help="Topic of JointState messages in a ROS bag.")] = "",
    joint: Annotated[
        Texts, Option(help="Name of a joint in a ROS bag; repeat from the base on.")
    ] = None,
    json_file: JsonFile = None,
    out: Annotated[File, Option(help="Folder of the page, compare.html.")] = None,
    open_page: OpenPage = False,
) -> None:
    """Compare a recorded motion with the rigid models of an arm or a robot."""
    from crosscheck.cli.compare import compare_command

    given = scenario, settings or [], tolerance or [], topic, joint or []
    folder = _choose_folder(out, open_page)
    code = compare_command(record, arm, *given, json_file, folder)
    _show_page((folder or REPORT) / "compare.html", open_page)
    raise typer.Exit(code)


@app.command()
def cost(
    robot: Annotated[str, Argument(metavar="ROBOT", help=NAMES)],
    motion: Annotated[
        File, Option(help="CSV, MAT, HDF5 or NetCDF file of a motion; sines by default.")
    ] = None,
    ratio: Annotated[
        float | None,
        Option(help="Gear ratio of each joint whose files state none; in rad/m where it slides."),
    ] = None,
    rotor_inertia: Annotated[
        float | None, Option(help="Rotor inertia of each joint whose files state none, in kg m^2.")
    ] = None,
    seed: Annotated[
        int, Option(min=0, max=LARGEST_SEED, help="Seed of the motion and the states.")
    ] = 0,
    quick: Annotated[bool, Option("--quick", help="Fewer states, instants and runs.")] = False,
    json_file: JsonFile = None,
    out: Annotated[File, Option(help="Folder of the page, cost.html.")] = None,
    open_page: OpenPage = False,
) -> None:
    """Show the errors in torque and at the tip if rotors or their coupling are left out."""
    from crosscheck.cli.cost import cost_command

    rotors = ratio, rotor_inertia
    folder = _choose_folder(out, open_page)
    code = cost_command(robot, motion, rotors, seed, quick, json_file, folder)
    _show_page((folder or REPORT) / "cost.html", open_page)
    raise typer.Exit(code)


@app.command()
def export(
    arm: MechanismName,
    out: Annotated[Path, Option(help="File to write: C, FMU (.fmu) or URDF (.urdf).")],
    model: Annotated[
        Text, Option(help="Analytic model of a C file or FMU, see `crosscheck list`.")
    ] = None,
    settings: Settings = None,
) -> None:
    """Write a model as C or FMU, or an arm or robot as a URDF with a robot's TOML file."""
    from crosscheck.cli.files.export import export_command

    export_command(arm, model, settings or [], out)


@app.command()
def sweep(
    study: Annotated[Path, Argument(metavar="STUDY.toml", help="File of the study.")],
    out: Annotated[Path, Option(help="NetCDF file to write.")],
    jobs: Jobs = None,
    resume: Annotated[bool, Option("--resume", help="Continue a run that was stopped.")] = False,
    run_code: Annotated[
        bool, Option("--run-code", help="Allow the study to run the functions that it names.")
    ] = False,
) -> None:
    """Run a study: one arm or robot and experiment, many values; write a NetCDF file."""
    with require_memory():
        from crosscheck.cli.studies import sweep_command

        sweep_command(study, out, jobs or os.cpu_count() or 1, resume, run_code)


@app.command()
def plot(
    file: Annotated[Path, Argument(metavar="FILE", help="Result of `crosscheck sweep`.")],
    quantity: Annotated[Texts, Option(help="Variable to draw; repeatable (default: all).")] = None,
    out: Annotated[File, Option(help="PNG file to write (default: beside FILE).")] = None,
) -> None:
    """Draw the result of a study: maps, curves and distributions."""
    with require_memory():
        from crosscheck.cli.studies import plot_command

        plot_command(file, quantity or [], out)


@app.command()
def view(
    file: Annotated[Path, Argument(metavar="RUN.nc", help="Trajectory of `crosscheck simulate`.")],
    out: Annotated[File, Option(help="HTML file to write (default: beside RUN.nc).")] = None,
    open_page: OpenPage = False,
) -> None:
    """Write a page that plays a run in three dimensions, with one mesh close up."""
    from crosscheck.cli.view import view_command

    page = view_command(file, out)
    _show_page(page, open_page)


@app.command("list")
def list_() -> None:
    """Show the arms, models and scenarios that come with the project."""
    from crosscheck.cli.listing import list_command

    list_command()


@app.command()
def init(
    file: Annotated[Path, Argument(metavar="FILE", help="TOML file to write.")],
    joints: Annotated[
        int | None, Option(min=1, max=7, help="Joints of an arm (default: 2).")
    ] = None,
    direct: Annotated[
        bool, Option("--direct", help="A plain arm: no gears, no friction, gravity.")
    ] = False,
    urdf: Annotated[
        File, Option(help="Write a robot's file for this URDF or MJCF instead.")
    ] = None,
) -> None:
    """Write a commented file of an arm or a robot to start from; it never overwrites a file."""
    from crosscheck.cli.files.template import init_command, init_robot_command

    if urdf is None:
        init_command(file, joints or 2, direct)
        return
    refuse("robot", "init", joints=joints, direct=direct)
    init_robot_command(file, urdf)


@app.command()
def show(arm: MechanismName) -> None:
    """Show an arm's values and derived quantities, or a robot and its doubtful inertias."""
    from crosscheck.cli.show import show_command

    show_command(arm)


@cache.command()
def clear() -> None:
    """Remove the files kept between runs: simulations and compiled code."""
    from crosscheck.runner.cache import clear_command

    clear_command()


COMMANDS = "geararm_crosscheck.commands"  # entry points of other packages
COMPLETION = "_CROSSCHECK_COMPLETE"  # set by a shell that asks for completions
TOO_MANY_FILES = (errno.EMFILE, errno.ENFILE)
DISK_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
USAGE_ERRORS = (typer.Exit, typer.Abort, typer.BadParameter)
PARSERS_INTERRUPTED = 130  # code by which Typer reports a KeyboardInterrupt


@lru_cache
def build_own_commands() -> Any:
    """The program's own commands, built for Typer's parser in a twentieth of a second."""
    return typer.main.get_command(app)


@lru_cache
def build_commands() -> Any:
    """The program's own commands and those of installed packages.

    Each of the latter is a function as Typer takes it, which imports nothing heavy before it is
    called. Raises InputError for one that cannot be used.
    """
    group, installed = build_own_commands(), {}
    for offer in sorted(entry_points(group=COMMANDS), key=lambda each: each.name):
        if offer.name in group.commands or offer.name in installed:
            raise entry_point_error(offer, "a command of this name exists already")
        alone = typer.Typer(add_completion=False)
        alone.command(offer.name)(load_command(offer, USAGE_ERRORS))
        try:
            installed[offer.name] = typer.main.get_command(alone)
        except Exception as error:  # whatever Typer makes of its arguments
            reason = f"is not a function that Typer takes: {describe_error(error)}"
            raise entry_point_error(offer, reason) from None
    group.commands.update(installed)
    arrange_help(group)
    return group


def is_completion() -> bool:
    """Whether a shell asks for completions, or a user for the script of completions."""
    options = ["--install-completion"], ["--show-completion"]
    return COMPLETION in os.environ or sys.argv[1:2] in options


def main() -> NoReturn:
    """Run the command line; exit codes 0, 1 (differs), 2 (bad input), 3 (no verdict), 130, 143."""
    try:
        prepare()
        code: Any = build_commands()(standalone_mode=False)
    except (typer.Abort, KeyboardInterrupt):
        code = PARSERS_INTERRUPTED
    except Exception as error:
        if not was_stopped():
            _explain(error)
        code = PARSERS_INTERRUPTED
    except BaseException as error:  # not ours: code that a command ran wants to exit
        if is_completion():
            raise
        _fail(f"came to no verdict: code that was run raised {describe_error(error)}", 3)
    if code == PARSERS_INTERRUPTED:
        _fail(exit_message(), exit_code())
    sys.exit(closing_code(code if isinstance(code, int) else 0))


def _explain(error: Exception) -> NoReturn:
    if isinstance(error, InputError | Diverged):
        _fail(str(error), 2)
    if hasattr(error, "format_message"):  # a usage error of typer's own command-line parser
        if not (message := error.format_message()):  # no command: the help was printed
            sys.exit(2)
        context = getattr(error, "ctx", None)
        command = "crosscheck" if context is None else context.command_path
        _fail(f"{rephrase(message).removesuffix('.')} (see {command} --help)", 2)
    if isinstance(error, OSError) and error.errno in DISK_FULL:
        _fail(f"a file cannot be written: {error.strerror}", 2)
    if isinstance(error, OSError) and error.errno in TOO_MANY_FILES:
        _fail(f"open files: {error.strerror}; raise the limit, or lower --jobs", 2)
    if isinstance(error, Unfinished):
        _fail(str(error), 3)
    traceback.print_exception(error)
    _fail("internal error, please report the lines above", 3)


def _fail(line: str, code: int) -> NoReturn:
    print(format_line(f"{PROGRAM}{line}"), file=sys.stderr)
    sys.exit(code)
