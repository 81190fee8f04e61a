"""The command `sparsurf`, also `python -m sparsurf`."""

import signal
import sys


def main() -> int:
    """Run the command line, and return the exit code; an interrupt may come while its modules load."""
    try:
        from sparsurf.cli import command

        return command.main()
    except KeyboardInterrupt:
        print("sparsurf: interrupted", file=sys.stderr)
        return 128 + signal.SIGINT  # as shells count


if __name__ == "__main__":
    sys.exit(main())
