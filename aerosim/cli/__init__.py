"""The verbs of the command line: parse, call, print.  Nothing is known here that Python users lack."""

from __future__ import annotations

import sys
from collections.abc import Sequence


def main(args: Sequence[str] | None = None) -> None:
    """Entry point: runs one command and ends the process with its exit code."""
    from aerosim.cli.app import call

    sys.exit(call(args))
