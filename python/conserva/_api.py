"""Functions and classes of the package, made from the registry of the language.

Nothing is written here about a single function: names, parameters, documentation and examples come from the table that the script engine
itself is made from, so that both are the same by construction.
"""

import difflib
import inspect
import json
import keyword

from . import _axes, _core, _translate, _views
from ._errors import ScriptError
from ._meshes import MeshMethods
from ._objects import Columns, Object, Record, StateMethods

REGISTRY, TYPE_NAMES = _core.reference()
REGISTRY = json.loads(REGISTRY)
FUNCTIONS = REGISTRY["functions"]
_translate.KNOWN.__init__(FUNCTIONS)

# Base classes with functions in addition to those of the registry, by the name of the type in the language.
BASES = {
    "Mesh": MeshMethods,
    "History": Columns,
    "Path": Columns,
    "State": StateMethods,
    "Body": _views.BodyMethods,
    "Material": _views.MaterialMethods,
    "Simulation": _views.SimulationMethods,
}
RENAMED = {"Error": "Failure"}
# Types of immutable values, pickled as the call that made them.
VALUES = {"Material", "TimeFunction", "ContactMethod", "FrictionLaw", "Integrator", "StepControl", "Obstacle", "Curve"}


class Signature:
    """Rules by which positional and keyword arguments become the arguments of a call."""

    __slots__ = ("first", "function", "is_needed", "names", "options")

    def __init__(self, function):
        parameters = function["parameters"]
        self.function = function
        self.first = 1 if function["of"] else 0
        self.names = [parameter["name"] for parameter in parameters]
        places = [place for place, parameter in enumerate(parameters) if parameter["kind"] == "Map"]
        self.options = places[0] if places else None
        # Without options the engine would report an unknown function; with empty options it reports the missing key.
        self.is_needed = bool(places) and parameters[places[0]]["required"]

    def title(self):
        return f"`{self.function['name']}`"

    def bind(self, values, named):
        """Positional and keyword arguments of a call as values in the order of the parameters."""
        given = list(values[self.first :])
        options = {}
        slots = dict(enumerate(given))
        for name, value in named.items():
            name = name[:-1] if name.endswith("_") and keyword.iskeyword(name[:-1]) else name
            place = self.names.index(name) if name in self.names else None
            if place is not None and place not in slots:
                slots[place] = value
            elif place is not None and place != self.options:
                raise self.refused(f"{self.title()} has two values for `{name}`", "one is given by its place and one by its name", "give one")
            elif self.options is None:
                near = difflib.get_close_matches(name, self.names, 1)
                hint = f"did you mean `{near[0]}`?" if near else f"`help(conserva)` shows what {self.title()} takes"
                raise self.refused(f"{self.title()} has no parameter `{name}`", self.takes(), hint)
            else:
                options[name] = value
        if options or (self.is_needed and self.options not in slots):
            before = slots.get(self.options, {})
            if not isinstance(before, dict):
                raise self.refused(f"{self.title()} takes its options as keywords", f"{before!r} stands in their place", self.takes())
            slots[self.options] = {**before, **options}
        return (*values[: self.first], *self.filled(slots))

    def lacks_path(self, values, named):
        """True if all arguments but the path of a file are given."""
        needed = [parameter["name"] for parameter in self.function["parameters"] if parameter["required"]]
        return "path" not in named and len(values) - self.first + sum(name in named for name in needed) == len(needed) - 1

    def with_path(self, values, named, path):
        """Positional and keyword arguments of a call, completed by the path of the file to write."""
        place = self.first + self.names.index("path")
        if len(values) < place:
            return values, {**named, "path": path}
        return (*values[:place], path, *values[place:]), named

    def filled(self, slots):
        found = []
        for place in range(max(slots, default=-1) + 1):
            parameter = self.function["parameters"][place] if place < len(self.names) else None
            if place in slots:
                found.append(slots[place])
            elif parameter["required"]:
                raise self.refused(f"{self.title()} needs `{parameter['name']}`", self.takes(), f"`{parameter['name']}` is {parameter['summary']}")
            elif not isinstance(parameter["default"], dict):
                found.append(parameter["default"])
        return found

    def takes(self):
        return f"its parameters are {', '.join(f'`{name}`' for name in self.names)}" if self.names else "it takes no values"

    @staticmethod
    def refused(title, cause, hint):
        return ScriptError(title, "C1020", [cause], [hint])


def callable_of(place, function):
    """The function or method of a row of the registry."""
    signature = Signature(function)
    count = signature.options + signature.first if signature.is_needed else -1
    key = (function["of"], function["name"])

    def call(*values, **named):
        if named or len(values) == count:
            values = signature.bind(values, named)
        return _core.call(place, values)

    def value(*values, **named):
        made = call(*values, **named)
        made._recipe = (key, signature.bind(values, named) if named else values)
        return made

    def study(*values, **named):
        made = call(*values, **named)
        return _views.Rows(made) if isinstance(made, list) else made

    def shown(*values, **named):
        ax = named.pop("ax", None)
        if ax is not None and key in _axes.DRAWN:
            return _axes.DRAWN[key](*values, ax=ax, **named)
        if not signature.lacks_path(values, named):
            return call(*values, **named)
        values = signature.bind(*signature.with_path(values, named, f"shown{ending}"))
        return _views.Shown(_core.file(place, values), ending)

    ending = _views.ending_of(function)
    is_study = function["topic"] == "Studies" and function["returns"] == "Array"
    return shown if ending else study if is_study else value if function["returns"] in VALUES else call


def alternatives(rows):
    """One function for rows of one name, such as `atan` of one value and of two: the number of values decides."""
    calls = {len(function["parameters"]): callable_of(place, function) for place, function in rows}

    def call(*values, **named):
        chosen = calls.get(len(values) + len(named)) or next(iter(calls.values()))
        return chosen(*values, **named)

    return call


def kind_word(parameter):
    """The type of a parameter in a docstring."""
    if parameter["choices"]:
        return "{" + ", ".join(repr(choice) for choice in parameter["choices"]) + "}"
    words = {"number": "float", "String": "str", "Array": "array_like", "Fn": "callable", "Map": "dict", "Amplitude": "float or TimeFunction or callable"}
    return words.get(parameter["kind"], parameter["kind"])


def parameter_lines(parameter):
    notes = [] if parameter["required"] else ["optional"]
    default = parameter["default"]
    if default is not None:
        notes.append(f"default: {_translate.translated(default['means']) if isinstance(default, dict) else repr(default)}")
    lines = [f"{_translate.keyword_name(parameter['name'])} : {', '.join([kind_word(parameter), *notes])}"]
    text = _translate.translated(parameter["summary"])
    limits = [parameter["range"]] if parameter["range"] else []
    dimension = f" [{parameter['dimension']}]" if parameter["dimension"] not in ("", "1", "any") else ""
    return lines + [f"    {text[:1].upper()}{text[1:]}{dimension}{'; ' + limits[0] if limits else ''}."]


def example_of(function):
    """The example of a function in Python, and as a script where it has no counterpart."""
    try:
        return _translate.program(function["example"])
    except _translate.NotTranslated:
        return None


def documentation(function):
    """The docstring of a function in the style of NumPy."""
    summary = _translate.translated(function["summary"])
    lines = [f"{summary[:1].upper()}{summary[1:]}.", ""]
    plain = [parameter for parameter in function["parameters"] if not parameter["keys"]]
    keys = [key for parameter in function["parameters"] for key in parameter["keys"]]
    for title, rows in (("Parameters", plain), ("Other Parameters", keys)):
        if rows:
            lines += [title, "-" * len(title), *(line for row in rows for line in parameter_lines(row)), ""]
    if function["returns"]:
        returned = {"number": "float", "String": "str", "Array": "numpy.ndarray or list", "Map": "Record"}.get(function["returns"], function["returns"])
        lines += ["Returns", "-------", returned, ""]
    if function["see_also"]:
        lines += ["See Also", "--------", ", ".join(function["see_also"]), ""]
    example = example_of(function)
    if example:
        lines += ["Examples", "--------", *(f">>> {line}" for line in example.splitlines())]
    return "\n".join(lines).rstrip() + "\n"


class Left:
    """Stands for a value that is left out, whose meaning the docstring has."""

    def __repr__(self):
        return "…"


LEFT = Left()


def signature_of(function, owner):
    """The parameters of a function by place and the keys of its options by name, for completion."""
    plain = [parameter for parameter in function["parameters"] if not parameter["keys"]]
    keys = [key for parameter in function["parameters"] for key in parameter["keys"]]
    required = inspect.Parameter.empty

    def shown(rows, kind):
        rows = sorted(rows, key=lambda row: not row["required"])
        return [inspect.Parameter(_translate.keyword_name(row["name"]), kind, default=required if row["required"] else LEFT) for row in rows]

    first = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)] if owner else []
    return inspect.Signature(first + shown(plain, inspect.Parameter.POSITIONAL_OR_KEYWORD) + shown(keys, inspect.Parameter.KEYWORD_ONLY))


def named(call, function, owner=None):
    call.__signature__ = signature_of(function, owner)
    call.__name__ = call.__qualname__ = function["name"]
    if owner:
        call.__qualname__ = f"{owner}.{function['name']}"
    call.__module__ = "conserva"
    call.__doc__ = documentation(function)
    return call


def column_methods(place):
    def by_index(self, name):
        try:
            return _core.call(place, (self, name))
        except ScriptError as error:
            # A mapping raises KeyError for a missing key; the message is that of the language.
            raise KeyError(str(error)) from error

    def by_attribute(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return _core.call(place, (self, name))
        except ScriptError as error:
            raise AttributeError(str(error)) from error

    return {"__getitem__": by_index, "__getattr__": by_attribute}


def class_of(name):
    """The class of a type of the language."""
    shown_name = RENAMED.get(name, name)
    body = {"__slots__": (), "__module__": "conserva", "__doc__": f"{name} of the language."}
    for place, function in enumerate(FUNCTIONS):
        if function["of"] != name:
            continue
        if function["form"] == "property":
            body[function["name"]] = property(lambda self, place=place: _core.call(place, (self,)), doc=documentation(function))
        elif function["form"] == "column":
            body.update(column_methods(place))
        else:
            body[function["name"]] = named(callable_of(place, function), function, shown_name)
    return type(shown_name, (BASES.get(name, Object),), body)


CLASSES = {name: class_of(name) for name in TYPE_NAMES}


def global_functions():
    """The functions of the language by their names."""
    rows = {}
    for place, function in enumerate(FUNCTIONS):
        if function["of"] is None:
            rows.setdefault(function["name"], []).append((place, function))
    made = {}
    for name, of_name in rows.items():
        call = callable_of(*of_name[0]) if len(of_name) == 1 else alternatives(of_name)
        made[name] = named(call, of_name[0][1])
    return made


GLOBALS = global_functions()


def call_by_name(key, values):
    """Calls a function or method by its owner and name."""
    owner, name = key
    return (getattr(CLASSES[owner], name) if owner else GLOBALS[name])(*values)


_core.register(Object, {**CLASSES, "Map": Record})
