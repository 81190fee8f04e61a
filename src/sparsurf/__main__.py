"""`python -m sparsurf`."""

import sys

from sparsurf.cli.command import main

if __name__ == "__main__":
    sys.exit(main())
