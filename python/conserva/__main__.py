"""The command ``conserva``."""

import os
import shutil
import sys
from pathlib import Path


def program():
    """The executable that studies start for their points: the command of this environment."""
    beside = Path(sys.executable).parent / "conserva"
    return os.fspath(beside) if beside.exists() else shutil.which("conserva") or sys.argv[0]


def main():
    """Runs the command of the arguments of this process."""
    from . import _core

    sys.exit(_core.command(program(), sys.argv[1:]))


if __name__ == "__main__":
    main()
