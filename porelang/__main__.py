"""`python -m porelang` is `pore`."""

import sys

from porelang.cli import main

if __name__ == "__main__":
    sys.exit(main())
