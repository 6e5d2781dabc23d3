"""The command's arguments, and what becomes of errors."""

import argparse
import logging
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from skancf.cli.demos import DEMOS, show_demo
from skancf.cli.looks import look_at_file
from skancf.cli.solves import solve_file
from skancf.errors import SkancfError
from skancf.version import __version__

FAULT, FAILED, INTERRUPTED = 2, 1, 130
"""Exit codes: something asked for cannot be; an analysis did not reach its end; Ctrl-C."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command with these words, by default those of the command line; the exit code.

    0: done. 1: an analysis did not reach what was asked for, what it has is written. 2: an error, told in one message.
    130: interrupted from the keyboard.
    """
    given = _parser().parse_args(arguments)
    with _reporting(given.verbose):
        try:
            return int(given.run(given) or 0)
        except SkancfError as wrong:
            print(f"skancf: {wrong}", file=sys.stderr)
            return FAULT
        except KeyboardInterrupt:
            print("skancf: interrupted", file=sys.stderr)
            return INTERRUPTED
        except BrokenPipeError:  # of a reader such as head, which has seen enough
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0


@contextmanager
def _reporting(verbose: int) -> Iterator[None]:
    """Warnings as one line each, and as much of the log as was asked for."""
    handler = logging.StreamHandler()
    handler.setFormatter(logging.Formatter("%(levelname)s %(name)s: %(message)s"))
    logger, before = logging.getLogger("skancf"), logging.getLogger("skancf").level
    if verbose:
        logger.addHandler(handler)
        logger.setLevel(logging.DEBUG if verbose > 1 else logging.INFO)
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    print(f"skancf: warning: {message}", file=sys.stderr)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="skancf", description="Plates and shells that move and bend a lot.", epilog=EXAMPLES, formatter_class=PLAIN
    )
    parser.add_argument("--version", action="version", version=f"skancf {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for add in (_add_info, _add_demo, _add_solve, _add_view, _add_compile):
        command = add(commands)
        command.add_argument("-v", "--verbose", action="count", default=0, help="log steps; given twice, iterations too")
    return parser


def _command(commands: Any, name: str, run: Callable[[argparse.Namespace], Any], does: str, example: str) -> Any:
    """A command that does something, as ``--help`` says, with an example."""
    says = f"{does[0].upper()}{does[1:]}."
    made = commands.add_parser(name, help=does, description=says, epilog=f"example:\n  {example}", formatter_class=PLAIN)
    made.set_defaults(run=run)
    return made


def _add_info(commands: Any) -> Any:
    does = "show versions, linear solvers, threads, kernels and whether pictures can be drawn"
    return _command(commands, "info", _info, does, "skancf info > report.txt")


def _add_demo(commands: Any) -> Any:
    made = _command(commands, "demo", lambda given: show_demo(given.name, given.out, listed=given.list),
                    "solve an example, and compare it with published numbers",
                    "skancf demo hemisphere --out hemisphere")  # fmt: skip
    made.add_argument("name", nargs="?", default=next(iter(DEMOS)), help=f"{' or '.join(DEMOS)} (default: %(default)s)")
    made.add_argument("--out", metavar="FOLDER", default="skancf_demo", help="for picture and files (default: %(default)s)")
    made.add_argument("--list", action="store_true", help="list the examples")
    return made


def _add_solve(commands: Any) -> Any:
    made = _command(commands, "solve", lambda given: solve_file(given.file, given.out),
                    "solve the problem in a TOML file, and write the results to a folder",
                    "skancf solve plate.toml --out results")  # fmt: skip
    made.add_argument("file", help="the problem, its mesh and the analysis (*.toml)")
    made.add_argument("--out", metavar="FOLDER", help="default: next to the file, FILE_results")
    return made


def _add_view(commands: Any) -> Any:
    made = _command(commands, "view", lambda given: look_at_file(given.file, given.field, given.out),
                    "look at results in a window, or write a picture where there is no screen",
                    "skancf view results/result.h5 --field mises")  # fmt: skip
    made.add_argument("file", help="results (*.h5, *.vtu or *.pvd)")
    made.add_argument("--field", help="what the colours show, for example displacement or mises")
    made.add_argument("--out", metavar="FILE", help="write a picture (*.png) or a page (*.html) and open no window")
    return made


def _add_compile(commands: Any) -> Any:
    return _command(commands, "compile", _compile, "compile the kernels now, for example while an image is made",
                    "skancf compile")  # fmt: skip


PLAIN = argparse.RawDescriptionHelpFormatter
EXAMPLES = """examples:
  skancf demo                      a shell, its numbers and its picture
  skancf solve plate.toml          results to the folder plate_results
  skancf view plate_results/result.h5
  skancf COMMAND --help            more on each"""


def _compile(given: argparse.Namespace) -> None:
    # Rubber is loaded with it.
    from skancf.cli.compiles import compile_all

    compile_all()


def _info(given: argparse.Namespace) -> None:
    from skancf.about import info

    print(info())
