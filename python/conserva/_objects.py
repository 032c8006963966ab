"""Base of all objects of the language, and maps with their keys as attributes."""

import collections.abc
import difflib

from . import _core
from ._errors import ScriptError


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


# Numbers of objects have the number of their thread in the bits above.
LEAST_NUMBER = 1 << 40


class Object:
    """An object of the language, bound to the thread and session that made it."""

    __slots__ = ("__weakref__", "_number")

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

    def _repr_html_(self):
        import html

        return f"<pre>{html.escape(_core.shown(self._number))}</pre>"

    def __reduce__(self):
        name = type(self).__name__
        cause = f"a `{name}` is bound to the thread and session that made it"
        raise ScriptError(f"a `{name}` cannot be pickled", "C1020", [cause], ["pickle what makes it: numbers, arrays and texts"])

    def __copy__(self):
        return self

    def __deepcopy__(self, _):
        name = type(self).__name__
        hint = "`sim.branch()` copies a simulation, `sim.save()` keeps its state" if name == "Simulation" else "make a second one"
        raise ScriptError(f"a `{name}` cannot be copied deeply", "C1020", ["its parts are shared with other objects"], [hint])

    def __getattr__(self, name):
        raise AttributeError(missing(type(self), name))


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


collections.abc.Mapping.register(Columns)


class MeshMethods(Object):
    """Methods of meshes that exist in Python alone: arrays, and meshes of other programs."""

    __slots__ = ()

    @property
    def positions(self):
        """Positions of the nodes, of the shape (nodes, 3) [length]."""
        return _core.positions(self._number)

    @property
    def connectivity(self):
        """Node numbers of the cells, of the shape (cells, nodes of a cell)."""
        return _core.mesh(self._number)["connectivity"]

    @property
    def element(self):
        """Kind of the cells, such as ``quad4``."""
        return _core.mesh(self._number)["element"]

    def to_meshio(self):
        """The mesh as a ``meshio.Mesh``; parts become cell sets."""
        import meshio
        import numpy as np

        parts = _core.mesh(self._number)
        sets = {name: [np.asarray(cells, dtype=int)] for name, cells in parts["parts"].items()}
        return meshio.Mesh(parts["positions"], [(MESHIO[parts["element"]], parts["connectivity"])], cell_sets=sets)

    def to_pyvista(self):
        """The mesh as a ``pyvista.UnstructuredGrid``."""
        import pyvista

        return pyvista.from_meshio(self.to_meshio())

    def _repr_svg_(self):
        parts = _core.mesh(self._number)
        return drawn(parts) if parts["dimension"] == 2 and len(parts["connectivity"]) <= MOST_DRAWN else None


# Kinds of cells in meshio, which has the order of nodes of VTK, as Conserva has.
MESHIO = {
    "tri3": "triangle",
    "tri6": "triangle6",
    "quad4": "quad",
    "quad8": "quad8",
    "quad9": "quad9",
    "tet4": "tetra",
    "tet10": "tetra10",
    "hex8": "hexahedron",
    "hex20": "hexahedron20",
    "hex27": "hexahedron27",
}

# Cells of a mesh that is drawn in a notebook; more make a page slow.
MOST_DRAWN = 20_000
CORNERS = {"tri3": 3, "tri6": 3, "quad4": 4, "quad8": 4, "quad9": 4}


def drawn(parts):
    """The cells of a plane mesh as SVG."""
    x, y = parts["positions"][:, 0], parts["positions"][:, 1]
    left, width, top, height = x.min(), x.max() - x.min(), y.max(), y.max() - y.min()
    scale = 400 / max(width, height)
    px, py = (x - left) * scale + 2, (top - y) * scale + 2
    corners = parts["connectivity"][:, : CORNERS[parts["element"]]]
    paths = "".join("M" + "L".join(f"{px[node]:.1f},{py[node]:.1f}" for node in cell) + "Z" for cell in corners)
    size = f'width="{width * scale + 4:.0f}" height="{height * scale + 4:.0f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}><path d="{paths}" fill="#dbe7f3" stroke="#33506d" stroke-width="0.7"/></svg>'
