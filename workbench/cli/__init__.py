"""The command line: ``workbench VERB ...``. Nothing heavy is imported before a verb runs."""

import os
import sys
from collections.abc import Sequence

from workbench.errors import InputError, WorkbenchError

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit: 0 done, 1 a gate or a cell failed, 2 bad input.

    Bad input is one line on the error stream, without a traceback. An interrupt (Ctrl-C) ends
    with 130.
    """
    sys.exit(run(sys.argv[1:] if arguments is None else arguments))


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return the exit status."""
    from workbench.cli.app import build
    from workbench.cli.output import InterruptedByUserError

    try:
        status = build()(list(arguments), prog_name="workbench", standalone_mode=False)
        sys.stdout.flush()
        if status == INTERRUPTED:  # what the argument parser makes of Ctrl-C
            raise InterruptedByUserError("interrupted")
        return status if isinstance(status, int) else DONE
    except InputError as error:
        return _say(str(error), BAD_INPUT)
    except WorkbenchError as error:
        return _say(str(error), FAILED)
    except (InterruptedByUserError, KeyboardInterrupt) as error:
        return _say(str(error) or "interrupted", INTERRUPTED)
    except BrokenPipeError:
        # the reader of our output has gone, as in `workbench models | head`: no fault of ours
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except Exception as error:
        # errors of the argument parser; its classes have no common public base in all versions
        if not hasattr(error, "format_message"):
            raise
        return _say(error.format_message(), BAD_INPUT)


def _say(text: str, status: int) -> int:
    print("workbench: " + " ".join(text.split()), file=sys.stderr)
    return status
