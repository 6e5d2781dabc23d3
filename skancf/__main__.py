"""``python -m skancf``: the same as the command ``skancf``."""

import sys

from skancf.cli import main

if __name__ == "__main__":
    sys.exit(main())
