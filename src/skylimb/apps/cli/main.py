"""Reads the arguments, runs the verb, and turns what happened into an exit code.

0: done. 1: a flight was lost, a check failed, or something that comes after a flight. 2: nothing was done,
because the command cannot be carried out. 130: interrupted with Ctrl-C; 143: ended by the system. A flight
that came to its end without doing what was commanded is no error: its verdict says so.
"""

from __future__ import annotations

import errno
import logging
import signal
import sys
import traceback
import warnings
from collections.abc import Sequence
from types import FrameType

from skylimb.apps.cli.arguments import parse, verb_help
from skylimb.apps.cli.verbs import VERBS
from skylimb.base.aside import give_up
from skylimb.base.errors import ConfigError, SkylimbError, of_an_extra, unknown_name
from skylimb.base.interrupts import HANG_UP, answering

DEBUG = "--debug"
"""Option of every verb: the whole traceback of an error, before its one line."""

EXAMPLES = """\
  skylimb compare                     the paper's experiment, four controllers, one report
  skylimb run --controller pid        one flight, with its log, figures and a report that moves
  skylimb run --set surface.friction=0.2 trajectory.direction=-1 --seed 3 --out out/slippery
  skylimb list                        what ships
  skylimb show paper                  everything that --set can change
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; on the arguments of the process when none are given.

    Returns:
        The exit code, see the module.
    """
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    debug = DEBUG in arguments
    arguments = [argument for argument in arguments if argument != DEBUG]
    # What a warning says is printed with the results, not in between.
    logging.getLogger("skylimb").addHandler(logging.NullHandler())
    terminated: list[int] = []

    def end_as_ctrl_c_does(number: int, frame: FrameType | None) -> None:
        """So that what was flown is kept."""
        del frame
        terminated.append(number)
        raise KeyboardInterrupt(signal.Signals(number).name)

    try:
        with warnings.catch_warnings(), answering([signal.SIGTERM, *HANG_UP], end_as_ctrl_c_does):
            warnings.showwarning = _warn
            return _dispatch(arguments)
    except SkylimbError as error:
        return _complain("; ".join((str(error), *_notes(error))), 2, debug and error)
    except ImportError as error:
        extra = of_an_extra(error)
        if extra is None:
            raise
        return _complain(str(extra), 2, debug and error)
    except KeyboardInterrupt as stop:
        kept = _notes(stop) or ["what was not finished is not kept"]
        return _complain("; ".join(("interrupted", *kept)), 128 + (terminated or [signal.SIGINT])[0])
    except BrokenPipeError:
        give_up(sys.stdout)  # the reader (`skylimb list | head`) has seen enough
        return 0
    except (RecursionError, MemoryError, OSError) as error:
        # What reads files has ceilings of its own; this is for what they do not know of.
        if (lack := _lacked(error)) is None:
            raise
        asked = f"'{' '.join(arguments)[:200]}'"
        return _complain(f"{asked} needs {lack} than there may be", 2, debug and error)


def _dispatch(arguments: list[str]) -> int:
    for argument in arguments:
        # Bytes that are no UTF-8 come from the system as halves of characters, which no record can hold.
        if not argument.isascii() and argument != argument.encode(errors="replace").decode():
            raise ConfigError(f"the argument {argument[:100]!a} is not UTF-8 text")
    verb, *rest = arguments or ["--help"]
    if verb in ("-h", "--help", "help"):
        print(_overview())
        return 0
    if verb == "--version":
        from skylimb import __version__

        print(f"skylimb {__version__}")
        return 0
    if rest and f"{verb} {rest[0]}" in VERBS:
        verb, rest = f"{verb} {rest[0]}", rest[1:]
    if verb not in VERBS:
        kind = "option" if verb.startswith("-") else "verb"
        raise unknown_name(kind, verb, [*VERBS, "--help", "--version"])
    if {"-h", "--help"} & set(rest):
        print(verb_help(verb, VERBS[verb]))
        return 0
    return parse(verb, VERBS[verb], rest)() or 0


def _notes(error: BaseException) -> list[str]:
    """What was added to an error on its way: where a flight is kept."""
    return list(getattr(error, "__notes__", ()))


def _overview() -> str:
    told = {name: (verb.__doc__ or "").partition("\n")[0] for name, verb in VERBS.items()}
    verbs = "\n".join(f"  {name:<16}{words}" for name, words in told.items())
    return (
        "Simulate, control, measure and fly multi-link aerial robots in contact.\n\n"
        "usage: skylimb VERB [OPTIONS]\n\n"
        f"Verbs\n{verbs}\n\n"
        f"Examples\n{EXAMPLES}\n"
        "`skylimb VERB --help` says more of each; `skylimb --version` which one this is; --debug shows where "
        "an error comes from."
    )


def _warn(message: Warning | str, *_: object) -> None:
    """Show a warning as a line for who reads it, without the place in the code."""
    print(f"skylimb: warning: {' '.join(str(message).split())}", file=sys.stderr)


def _lacked(error: Exception) -> str | None:
    """What an input asked too much of; None where it is something else that went wrong."""
    if isinstance(error, OSError):
        return "a longer name of a file" if error.errno == errno.ENAMETOOLONG else None
    return f"more {'memory' if isinstance(error, MemoryError) else 'levels inside of each other'}"


def _complain(message: str, code: int, shown: BaseException | bool = False) -> int:
    """Say what went wrong in a line, below the traceback of the error that is to be shown."""
    if isinstance(shown, BaseException):
        traceback.print_exception(shown)
    print(f"skylimb: error: {' '.join(message.split())}", file=sys.stderr)
    return code
