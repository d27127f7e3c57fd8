"""The application: its commands, and what becomes of errors.

Exit codes: 0 done and `expect` met, 1 done but not met, 2 wrong input, 3 the run failed, 130 interrupted.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Sequence
from typing import Annotated

import typer

from aerosim.cli import flights, look, plan, scenarios, sweep, terrain, tune
from aerosim.cli.console import settings
from aerosim.errors import InputError, RunFailure

OK, UNMET, WRONG_INPUT, FAILED, INTERRUPTED = 0, 1, 2, 3, 130
PIPE_CLOSED = 141  # as a shell reports SIGPIPE

# the base of all usage errors; typer brings its own copy of click along, so it is found from what typer exports
USAGE_PROBLEM: type[BaseException] = next(
    cls for cls in typer.BadParameter.__mro__ if cls.__name__ == "ClickException"
)

app = typer.Typer(
    name="aerosim",
    help="Simulator of airborne photo missions: flight, CCD rows, drift and v/h control, from one scenario file.",
    no_args_is_help=False,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(flights.run)
app.command()(plan.check)
app.command()(plan.plan)
app.command()(sweep.sweep)
app.command(epilog=tune.EPILOG)(tune.tune)
app.command("list")(scenarios.list_shipped)
app.command()(scenarios.new)
app.command()(scenarios.schema)
app.command()(look.view)
app.command()(look.report)
app.add_typer(terrain.app, name="terrain")


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"aerosim {version('aerosim-survey')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Simulator of airborne photo missions: flight, CCD rows, drift and v/h control, from one scenario file."""


def _say(line: str) -> None:
    print(" ".join(line.split()), file=sys.stderr)


def _failed(error: RunFailure) -> int:
    _say(f"run failed: {error}")
    if path := getattr(error, "path", None):
        _say("the record up to there is kept in")
        print(path)
    return FAILED


def _quiet_pipe() -> int:
    # the reader has gone: nothing more can be printed, not even at exit
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return PIPE_CLOSED


def _outcome(error: BaseException) -> int:
    """Print an error as one line; returns the exit code."""
    if isinstance(error, InputError):
        _say(str(error))
        return WRONG_INPUT
    if isinstance(error, USAGE_PROBLEM):
        command = getattr(getattr(error, "ctx", None), "command_path", "aerosim")
        _say(f"{error.format_message().rstrip('.')} (see {command} --help)")  # type: ignore[attr-defined]
        return WRONG_INPUT
    if isinstance(error, RunFailure):
        return _failed(error)
    if isinstance(error, BrokenPipeError):
        return _quiet_pipe()
    if isinstance(error, (KeyboardInterrupt, typer.Abort)):
        _say("interrupted")
        return INTERRUPTED
    _say(f"internal error: {type(error).__name__}: {error} (--debug shows where)")
    return FAILED


def _stop(*_: object) -> None:
    raise KeyboardInterrupt


def call(args: Sequence[str] | None = None) -> int:
    """Run one command.  args: without the program's name, by default the process's.  Returns the exit code."""
    settings.reset()
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, _stop)  # a job scheduler's word for Ctrl-C
    try:
        code = app(args if args is None else list(args), prog_name="aerosim", standalone_mode=False)
        sys.stdout.flush()
    except (Exception, KeyboardInterrupt) as error:
        if settings.debug and not isinstance(error, USAGE_PROBLEM):
            import traceback

            traceback.print_exc()
        return _outcome(error)
    if code == INTERRUPTED:
        _say("interrupted")
    return code if isinstance(code, int) else OK
