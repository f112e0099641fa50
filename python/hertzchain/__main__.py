"""The program: ``python -m hertzchain ARGS``."""

from __future__ import annotations

import sys

from . import _native


def main() -> None:
    """Run the program with the arguments of this process, and end with its exit code."""
    sys.exit(_native.program(["hertzchain", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
