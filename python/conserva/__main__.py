"""The command ``conserva``."""

import shutil
import sys


def main():
    """Runs the command of the arguments of this process."""
    from . import _core

    program = shutil.which("conserva") or sys.argv[0]
    sys.exit(_core.command(program, sys.argv[1:]))


if __name__ == "__main__":
    main()
