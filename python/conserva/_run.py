"""Runs of script files, and sessions whose results are files."""

import os
from pathlib import Path

from . import _core
from ._errors import exception_of
from ._objects import Record


def text_of(value):
    """A parameter as on the command line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


class Run:
    """A run that has ended: what it reported, and its files.

    Attributes
    ----------
    folder : pathlib.Path or None
        Folder of its files.
    checks : int
        Number of checks that hold.
    findings, energy : list of str
        What it found out, and a line on the energy of each simulation that does not keep it.
    is_conserving, is_doubtful : bool
        Whether all simulations keep their energy but for loads and contact; whether a warning says not to trust the results.
    """

    def __init__(self, folder, report):
        self.folder = folder
        self.error = exception_of(report["error"]) if report["error"] else None
        self.checks, self.findings, self.energy = report["checks"], report["findings"], report["energy"]
        self.is_conserving, self.is_doubtful = report["is_conserving"], report["is_doubtful"]

    def __repr__(self):
        return f"<Run in {self.folder}: {self.checks} checks hold>"

    def history(self, name=None):
        """Columns of a history as arrays; the name of the simulation where there is more than one."""
        import numpy as np

        found = sorted(self.folder.rglob("history.csv"))
        if name is not None:
            found = [path for path in found if path.parent.name == name]
        if len(found) != 1:
            raise FileNotFoundError(f"{len(found)} files `history.csv` in {self.folder}: name the simulation")
        with open(found[0], encoding="utf-8") as file:
            names = file.readline().strip().split(",")
            table = np.loadtxt(file, delimiter=",", ndmin=2)
        return Record(zip(names, table.T))


def run(script, *, output=None, threads=1, **parameters):
    """Runs a script file to its end, as the command ``conserva run`` does.

    Parameters
    ----------
    script : path
        The script.
    output : path, optional
        Folder of the results, by default ``out/<script name>``; ``False`` writes none.
    threads : int, optional
        Threads of the element loop; results do not depend on it.
    **parameters
        Values for ``param``.

    Returns
    -------
    Run
        What it reported. A check that does not hold raises `CheckFailed` after the files are written.
    """
    script = Path(script)
    folder = None if output is False else Path(output) if output is not None else Path("out") / script.stem
    overrides = [(name, text_of(value)) for name, value in parameters.items()]
    report = _core.run(os.fspath(script), None if folder is None else os.fspath(folder), overrides, int(threads))
    ended = Run(folder, report)
    if ended.error:
        raise ended.error
    return ended


class session:  # noqa: N801 - it is used as a function is
    """A session for a ``with`` statement: its own threads, parameters and folder of results.

    Parameters
    ----------
    output : path, optional
        Folder of the results; files that simulations write by themselves (``history.csv``, ``summary.json``) are written at the end.
    threads : int, optional
        Threads of the element loop; results do not depend on it.
    home : path, optional
        Folder of files that are read, by default the working folder.
    allow_read : list of path, optional
        Folders that may be read besides `home`, by default all.
    parameters : dict, optional
        Values for ``param``.

    Attributes
    ----------
    result : Run
        What there was to report, after the end.
    """

    def __init__(self, output=None, *, threads=1, home=".", allow_read=None, parameters=None):
        overrides = [(name, text_of(value)) for name, value in (parameters or {}).items()]
        self.options = {
            "output": None if output is None else os.fspath(output),
            "threads": int(threads),
            "home": os.fspath(home),
            "allow_read": None if allow_read is None else [os.fspath(folder) for folder in allow_read],
            "parameters": overrides,
        }
        self.result = None

    def __enter__(self):
        self.number, self.before = _core.enter(self.options)
        return self

    def __exit__(self, kind, error, trace):
        report = _core.leave(self.number, self.before)
        folder = self.options["output"]
        self.result = Run(folder and Path(folder), report)
        if kind is None and self.result.error:
            raise self.result.error
