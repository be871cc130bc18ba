"""The command line: which commands there are, and how what goes wrong is told."""

import errno
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from io import TextIOWrapper
from itertools import pairwise
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from followspot import __version__
from followspot.commands import drawing, measuring
from followspot.errors import FollowspotError, UnwritableError, UsageError, printable
from followspot.present.interrupt import Terminated, interruptible

# NumPy's matrix products here are small: threads that spin for them cost more than they bring.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


class _Commands(TyperGroup):
    def invoke(self, ctx: Any) -> Any:
        """Run the command that was typed; typer would end without a word on Ctrl-C."""
        try:
            with interruptible():
                return super().invoke(ctx)
        except Terminated as terminated:
            _fail("terminated", 128 + terminated.number)
        except KeyboardInterrupt:
            _fail("interrupted", 128 + signal.SIGINT)


_OF_OUTPUT = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EPIPE)
"""What goes wrong with standard output; of files, those who write them tell."""

app = typer.Typer(
    cls=_Commands,
    help="Open a Quake 3 level, light it, and see every stage of how the picture is made.\n\n"
    "Try: followspot render courtyard -o courtyard.png",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for _command in (
    drawing.render,
    drawing.figures,
    measuring.inspect,
    measuring.bench,
    measuring.doctor,
    measuring.validate,
    drawing.film,
    drawing.report,
    drawing.view,
):
    app.command()(_command)


def _tell_version(wanted: bool) -> None:
    if wanted:
        print(f"followspot {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", help="Tell it.", is_eager=True, callback=_tell_version),
    ] = False,
) -> None:
    """Options of the program itself."""


def main() -> NoReturn:
    """Run the command line; what a user caused is one line on stderr and exit code 2."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # names may hold what its encoding does not
            stream.reconfigure(errors="backslashreplace")
    try:
        code = app(sys.argv[1:] or ["--help"], standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
        sys.exit(code or 0)
    except UsageError as error:
        _fail(str(error))
    except FollowspotError as error:
        _fail(f"error: {error}")
    except typer.BadParameter as error:
        _fail(_told(error) + _typed_for(error.param.opts if error.param else ()))
    except typer.TyperException as error:
        _fail(_told(error))
    except OSError as error:
        if error.filename is not None or error.errno not in _OF_OUTPUT:
            raise
        with suppress(OSError):
            sys.stdout.close()  # lest Python tries once more
        if error.errno == errno.EPIPE:  # nobody reads any more
            sys.exit(1)
        _fail(str(UnwritableError("standard output", os.strerror(error.errno))))


def _told(error: typer.TyperException) -> str:
    """What typer complains of, on one line."""
    return printable(" ".join(error.format_message().split()).rstrip("."))


def _typed_for(option: Sequence[str]) -> str:
    """What was typed last for an option with these names, which typer does not tell."""
    found = ""
    for typed, following in pairwise([*sys.argv, ""]):
        name, has_value, value = typed.partition("=")
        if name in option:
            found = f", found {value if has_value else following!r}"
    return found


def _fail(text: str, code: int = 2) -> NoReturn:
    with suppress(OSError):  # there is nobody else to tell
        print(f"followspot: {text}", file=sys.stderr, flush=True)
    sys.exit(code)
