"""`python -m sparsurf`."""

import sys

from sparsurf.calls.command import main

if __name__ == "__main__":
    sys.exit(main())
