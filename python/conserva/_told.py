"""Output of a session while it computes: printed lines, warnings, checks, progress."""

import logging
import sys
import warnings

from ._errors import ConservaWarning, exception_of

LOG = logging.getLogger("conserva")

# True where a line on a terminal shows the progress of a computation; ``conserva.progress`` sets it.
shows_progress = False
_line = ""


def printed(line):
    """A line that Conserva prints."""
    ended()
    print(line)


def passed(line):
    """A check that holds."""
    LOG.info("%s", line)


def warned(parts):
    """A warning."""
    ended()
    # Stack levels up to the user's call: _told, _api, the generated method, the user.
    warnings.warn(str(exception_of({**parts, "kind": "script"})), ConservaWarning, stacklevel=5)


def advanced(model, time, until):
    """An accepted step, at most ten in a second."""
    if shows_progress:
        show(f"{model}: t = {time:.6g}" + (f" of {until:.6g}" if until is not None else ""))


def began(what):
    """A long computation without steps begins."""
    if shows_progress:
        show(what)


def ended():
    """A computation that reported progress has ended."""
    if _line:
        show("")


def show(text):
    """Replaces the line of progress."""
    global _line
    sys.stderr.write("\r" + text + " " * max(0, len(_line) - len(text)) + ("\r" if not text else ""))
    sys.stderr.flush()
    _line = text
