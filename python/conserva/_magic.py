"""Cells in the script language: ``%load_ext conserva`` and ``%%conserva``."""

from . import _core
from ._errors import ScriptError


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
    import re

    words = set(re.findall(r"[A-Za-z_]\w*", code))
    plain = {name: value for name, value in names.items() if name in words and not name.startswith("_")}
    return {name: value for name, value in plain.items() if not isinstance(value, type) and type(value).__name__ != "module"}


def load_ipython_extension(ipython):
    """Adds the magic to a notebook."""

    def conserva(line, cell):
        """Runs a cell in the script language. Variables of the notebook that it names go in, all of its variables come out."""
        if line.strip():
            raise ScriptError("`%%conserva` takes no words behind it", "C1020", [f"`{line.strip()}` follows"], ["write the script into the lines below"])
        found = text(cell, shared(ipython.user_ns, cell))
        value = found.pop("")
        ipython.user_ns.update(found)
        return value

    ipython.register_magic_function(conserva, magic_kind="cell")
