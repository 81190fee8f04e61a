"""The command `sparsurf`, also `python -m sparsurf`."""

import signal
import sys
from typing import NoReturn


def main() -> int:
    """Run the command line, and return the exit code; an interrupt may come while its modules load."""
    try:
        from sparsurf.cli import command

        return command.main()
    except KeyboardInterrupt:
        print("sparsurf: interrupted", file=sys.stderr)
        return 128 + signal.SIGINT  # as shells count


def run() -> NoReturn:
    """Run the command line in a process of its own, which then ends at once."""
    code = main()
    from sparsurf.garbage_collection import end_process  # here: an interrupt may come while modules load

    end_process(code)


if __name__ == "__main__":
    sys.exit(main())  # not at once: `runpy` may run this module in the process of another program
