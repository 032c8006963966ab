"""Base of all objects of the language, and maps with their keys as attributes."""

import collections.abc
import difflib

from . import _core
from ._errors import NotPickled, ScriptError


class Record(dict):
    """A map of results; its keys are attributes, too."""

    __slots__ = ()

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"there is no key `{name}`; the keys are {', '.join(map(str, self))}") from None

    def __add__(self, other):
        return Record({**self, **other}) if isinstance(other, dict) else NotImplemented


# Least number of an object: the bits from the 40th on hold the number of its thread.
LEAST_NUMBER = 1 << 40


class Object:
    """An object of the language, bound to the thread and session that made it."""

    __slots__ = ("__weakref__", "_number", "_recipe")

    def __init__(self, number=None):
        if type(number) is not int or number < LEAST_NUMBER:
            name = type(self).__name__
            hint = f"functions and methods return a `{name}`: `help(conserva)` lists them"
            raise ScriptError(f"a `{name}` cannot be made by its class", "C1020", ["objects of Conserva are values of its session"], [hint])
        self._number = number

    def __del__(self, release=_core.release):
        number = getattr(self, "_number", None)
        if number is not None:
            release(number)

    def __repr__(self):
        return f"<{type(self).__name__}: {_core.printed(self._number)}>"

    def __str__(self):
        return _core.printed(self._number)

    def _repr_svg_(self):
        return None

    def _repr_html_(self):
        import html

        return f"{self._repr_svg_() or ''}<pre>{html.escape(_core.shown(self._number))}</pre>"

    def __reduce__(self):
        recipe = getattr(self, "_recipe", None)
        if recipe is None:
            name = type(self).__name__
            cause = f"a `{name}` is bound to the thread and session that made it"
            raise NotPickled(f"a `{name}` cannot be pickled or copied deeply", "C1020", [cause], [INSTEAD.get(name, "make it anew where it is used")])
        return made_again, recipe

    def __copy__(self):
        return self

    def __getattr__(self, name):
        raise AttributeError(missing(type(self), name))


# Hints for types that cannot be pickled.
INSTEAD = {
    "Simulation": "`sim.branch()` copies a simulation; pickle its state `sim.save()`, and `restore` it in a simulation of an equal model",
    "Model": "pickle the function that makes the model, and call it where the model is used",
    "Material": "make it by its function, such as `neo_hookean`",
}


def made_again(place, values):
    """Restores a pickled object by the call that made it: the function by its owner and name, and its arguments."""
    from . import _api

    return _api.call_by_name(place, values)


def missing(kind, name):
    """Message about an attribute that a class does not have."""
    near = difflib.get_close_matches(name, [known for known in dir(kind) if not known.startswith("_")], 3)
    hint = f"; did you mean {' or '.join(f'`{known}`' for known in near)}?" if near else ""
    return f"`{kind.__name__}` has no attribute `{name}`{hint}"


class Columns(Object):
    """A mapping of columns, which are arrays: ``dict(history)`` is a table for pandas or polars."""

    __slots__ = ()

    def keys(self):
        """Names of the columns."""
        return list(self.columns)

    def __iter__(self):
        return iter(self.keys())

    def __len__(self):
        return len(self.keys())

    def __contains__(self, name):
        return name in self.keys()

    def values(self):
        """The columns."""
        return [self[name] for name in self]

    def items(self):
        """Names and columns."""
        return [(name, self[name]) for name in self]

    def get(self, name, default=None):
        """A column, or a default where there is none of that name."""
        return self[name] if name in self else default


    def __reduce__(self):
        return Record, (dict(self),)


collections.abc.Mapping.register(Columns)


class StateMethods(Object):
    """States are pickled by their bytes."""

    __slots__ = ()

    def __reduce__(self):
        return state_again, _core.state_bytes(self._number)


def state_again(state, rows):
    """A state from its bytes; a simulation of an equal model can restore it."""
    return _core.state_object(state, rows)
