"""The command ``contact-patch``."""

from __future__ import annotations

import signal
import sys

from . import _core


def main() -> int:
    """Run the command line; its exit code."""
    # Ctrl-C and a closed pipe end the command as they end any other; Python would only note them.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _core.command(["contact-patch", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
