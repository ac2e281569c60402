"""`python -m skylimb` is the command line."""

import sys

from skylimb.cli import main

if __name__ == "__main__":
    sys.exit(main())
