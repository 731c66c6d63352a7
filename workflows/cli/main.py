"""The command line.

Exit status: 0 done; 1 failed while running; 2 wrong input, nothing was run; 130 stopped by Ctrl-C;
141 the reader of the output, such as another command in a pipe, has closed it.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import io
import logging
import os
import signal
import sys
import threading
from collections.abc import Sequence

from granwave.lammps_inputs.case.schema import printable
from granwave.lammps_inputs.errors import GranwaveError, InputError, RunError
from granwave.lammps_inputs.extensions import missing_package
from granwave.lammps_inputs.files import DISK_IS_FULL
from granwave.lammps_inputs.interrupts import stop_signals
from granwave.workflows.cli.parser import WRONG_INPUT, make_parser
from granwave.workflows.cli.terminal import RED, YELLOW, coloured, in_shell, line_of
from granwave.workflows.run import mpi
from granwave.workflows.run.progress import each_warning_once, not_enough_memory

FAILED = 1
STOPPED = 130
READER_LEFT = 141

_ONCE_MORE = 0.05  # s until a Ctrl-C that was lost is repeated
_REPEATED: list[threading.Timer] = []
_LONGEST_SHOWN = 300  # characters of a path in a message
_NO_ROOM_FOR_LIBRARY = (
    "failed to map segment",
    "annot allocate memory",
)  # messages of the loader of libraries
_OF_NAMES = (errno.ENAMETOOLONG, errno.ELOOP)  # errors of a path itself, which is invalid input


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    if "_ARGCOMPLETE" in os.environ:  # the shell asks for completions
        from granwave.workflows.cli.completion import complete

        complete(make_parser())
    words = list(sys.argv[1:] if arguments is None else arguments)
    _set_up_output()
    try:
        parser = make_parser(words)
    except InputError as error:  # errors of extensions
        return _report([line_of(item) for item in error.items], WRONG_INPUT)
    options = parser.parse_args(words)
    _set_up_logging()
    if os.path.lexists("matplotlibrc"):  # a file of other programs, which could stop granwave
        with contextlib.chdir(os.sep):
            import matplotlib  # noqa: F401
    _handle_signals()
    try:
        return _run(options, words)
    finally:
        for repeated in _REPEATED:
            repeated.cancel()  # a later one would end the process by a signal


def _handle_signals() -> None:
    """Treat signals that stop a program as Ctrl-C, so that scratch files are removed."""
    sys.unraisablehook = _interrupt_again
    with contextlib.suppress(ValueError):  # only the main thread can handle signals
        for number in stop_signals():
            signal.signal(number, signal.default_int_handler)


def _run(options: argparse.Namespace, words: list[str]) -> int:
    """Run a command, and report its error; return the exit status."""
    try:
        options.given = words
        status: int = options.command.run(options)
        sys.stdout.flush()  # here, where an error can still be reported
        return status
    except InputError as error:
        return _report([line_of(item) for item in error.items], WRONG_INPUT)
    except GranwaveError as error:
        return _report([in_shell(str(error))], FAILED)
    except BrokenPipeError:
        os.dup2(
            os.open(os.devnull, os.O_WRONLY), 1
        )  # discards the rest of the output without an error
        return READER_LEFT
    except OSError as error:
        return _report_file(error, words)
    except MemoryError as error:
        return _report([not_enough_memory(str(error) or "none left")], FAILED)
    except ImportError as error:
        return _report_import(error)
    except KeyboardInterrupt:
        return _report(["stopped"], STOPPED)


def _report_import(error: ImportError) -> int:
    """Report a package that is not installed, or a library for which there is no memory; return
    the exit status.

    Raises
    ------
    ImportError
        Any other, which is a fault of the program.
    """
    if isinstance(error, ModuleNotFoundError) and (missing := missing_package(error)):
        return _report([missing], WRONG_INPUT)
    if any(words in str(error) for words in _NO_ROOM_FOR_LIBRARY):
        return _report([not_enough_memory(str(error))], FAILED)
    raise error


def _interrupt_again(lost: sys.UnraisableHookArgs) -> None:
    """Repeat a Ctrl-C that arrived during the clean-up of Python, which ignores all errors."""
    if lost.exc_type is KeyboardInterrupt:
        main_thread = threading.main_thread().ident
        assert main_thread is not None
        repeated = threading.Timer(_ONCE_MORE, signal.pthread_kill, (main_thread, signal.SIGINT))
        repeated.daemon = True
        _REPEATED.append(repeated)
        repeated.start()
    else:
        sys.__unraisablehook__(lost)


def _set_up_output() -> None:
    """Make printing and drawing work independently of terminal and settings."""
    for number in range(3):  # a closed one would be reused for the next file
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stderr is None or sys.stderr is sys.__stderr__:
        sys.stderr = _StandardError(io.FileIO(2, "wb", closefd=False), write_through=True)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    os.environ["MPLBACKEND"] = "agg"  # figures go to files


class _StandardError(io.TextIOWrapper):
    """Standard error that need not be read: a run continues without it."""

    def write(self, text: str) -> int:
        """Write, if anyone reads."""
        with contextlib.suppress(OSError):
            super().write(text)
        return len(text)

    def flush(self) -> None:
        """Flush, if anyone reads."""
        with contextlib.suppress(OSError):
            super().flush()


def _report_file(error: OSError, words: Sequence[str]) -> int:
    """Report the error of a file; it counts as wrong input if the command line names the file."""
    try:
        named = [os.path.abspath(word) for word in words if word]
        wrong = error.errno in _OF_NAMES or (
            error.filename is not None and os.path.abspath(os.fsdecode(error.filename)) in named
        )
    except OSError:
        return _report(["the working directory no longer exists; change to another"], WRONG_INPUT)
    # errors of writing name their file, see `granwave.lammps_inputs.files`
    name = error.filename or ("standard output" if error.errno in DISK_IS_FULL else "a file")
    shown = str(name) if len(str(name)) <= _LONGEST_SHOWN else f"{str(name)[:_LONGEST_SHOWN]}..."
    fault = f"{shown}: {error.strerror or error}"
    return _report([fault], WRONG_INPUT if wrong and error.errno not in DISK_IS_FULL else FAILED)


def _set_up_logging() -> None:
    """Show messages of granwave from INFO on, each warning once, and only errors of libraries. Only
    the first rank shows messages below ERROR.
    """
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(_Messages())
    handler.addFilter(each_warning_once())
    logging.basicConfig(level=logging.ERROR, handlers=[handler])
    logging.getLogger("granwave").setLevel(logging.INFO if mpi.is_first() else logging.ERROR)


class _Messages(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        text = in_shell(super().format(record))
        if record.levelno != logging.WARNING:
            return text
        return f"{coloured('granwave: warning:', YELLOW, sys.stderr)} {text}"


def _is_first() -> bool:
    """Return True on the first rank, also if MPI cannot be started."""
    try:
        return not mpi.launched() or mpi.world().rank == 0
    except RunError:
        return mpi.is_first()


def _report(lines: Sequence[str], status: int) -> int:
    if _is_first():
        for line in lines:
            print(f"{coloured('granwave:', RED, sys.stderr)} {printable(line)}", file=sys.stderr)
    return status
