"""Cells in the script language: ``%load_ext conserva`` and ``%%conserva``."""

import atexit
import re
import tempfile

from . import _core
from ._errors import ScriptError
from ._run import session


def text(code, variables=None):
    """Runs a text in the script language; its variables afterwards, with the value of its last expression under an empty name.

    Parameters
    ----------
    code : str
        The text.
    variables : dict, optional
        Variables that it begins with: numbers, texts, lists, arrays, dictionaries, callables, objects of Conserva.
    """
    return _core.text(code, dict(variables or {}))


def shared(names, code):
    """Variables of a notebook that a cell names and that the language can take."""
    words = set(re.findall(r"[A-Za-z_]\w*", code))
    plain = {name: value for name, value in names.items() if name in words and not name.startswith("_")}
    return {name: value for name, value in plain.items() if not isinstance(value, type) and type(value).__name__ != "module"}


class Notebook:
    """The session of a notebook."""

    def __init__(self):
        self.session = self.temporary = None

    def open(self, folder=None):
        """Opens a session whose files are in a folder, by default a temporary one, so that runs are recorded for movies and pages."""
        self.close()
        if not folder:
            self.temporary = tempfile.TemporaryDirectory(prefix="conserva-")
            folder = self.temporary.name
        self.session = session(output=folder)
        self.session.__enter__()
        print(f"files of this notebook: {folder}")

    def close(self):
        """Completes the files of the session."""
        if self.session:
            self.session.__exit__(None, None, None)
        self.session = None


NOTEBOOK = Notebook()
atexit.register(NOTEBOOK.close)


def unload_ipython_extension(_):
    """Closes the session of the notebook and completes its files; later calls belong to the session that was open before."""
    NOTEBOOK.close()


def load_ipython_extension(ipython):
    """Adds ``%%conserva``, which runs a cell in the script language, and ``%conserva FOLDER``, which puts files of what follows there."""

    def conserva(line, cell=None):
        """Runs a cell in the script language. Variables of the notebook that it names go in, all of its variables come out."""
        if cell is None:
            NOTEBOOK.open(line.strip())
            return None
        if line.strip():
            hint = "write the script into the lines below"
            raise ScriptError("`%%conserva` takes no words behind it", "C1020", [f"`{line.strip()}` follows"], [hint])
        found = text(cell, shared(ipython.user_ns, cell))
        value = found.pop("")
        ipython.user_ns.update(found)
        return value

    NOTEBOOK.open()
    ipython.register_magic_function(conserva, magic_kind="line_cell")
