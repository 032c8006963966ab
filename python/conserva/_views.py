"""Views in a notebook: pictures, movies and pages that are shown where no path is given, and objects that draw themselves."""

import base64
import html
import re
from pathlib import Path

from . import _core
from ._errors import ScriptError
from ._objects import Object

# Kinds of files that a notebook shows.
SHOWN = (".svg", ".png", ".html")
HEIGHT_OF_PAGE = 640


class Shown:
    """A picture, a movie or a page that shows itself in a notebook.

    Attributes
    ----------
    content : bytes
        Bytes of its file.
    ending : str
        Ending of its file, such as ``.svg``.
    """

    def __init__(self, content, ending):
        if not content:
            hint = "make the simulation in `with cs.session(output=folder):`, in a notebook after `%load_ext conserva`"
            raise ScriptError("there is no recording of the run", "C1020", ["a session without a folder of results records nothing"], [hint])
        self.content, self.ending = content, ending

    def save(self, path):
        """Writes the file."""
        Path(path).write_bytes(self.content)

    def __repr__(self):
        return f"<{self.ending} of {len(self.content)} bytes; `.save(path)` writes it>"

    def _repr_html_(self):
        if self.ending == ".svg":
            return self.content.decode()
        if self.ending == ".html":
            page = html.escape(self.content.decode(), quote=True)
            return f'<iframe srcdoc="{page}" width="100%" height="{HEIGHT_OF_PAGE}" frameborder="0"></iframe>'
        return f'<img src="data:image/png;base64,{base64.b64encode(self.content).decode()}">'


class Rows(list):
    """Rows of a study, a list of records that shows itself as a table; ``pandas.DataFrame(rows)`` takes it."""

    def _repr_html_(self):
        names = list(dict.fromkeys(name for row in self for name in row))
        head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
        lines = ("".join(f"<td>{html.escape(format_of(row.get(name, '')))}</td>" for name in names) for row in self)
        return f"<table><tr>{head}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def format_of(value):
    """A value in a table."""
    return f"{value:.6g}" if isinstance(value, float) else "" if value is None else str(value)


def ending_of(function):
    """Ending of the file that a function shows without a path; None for functions that show none."""
    for parameter in function["parameters"]:
        if parameter["name"] == "path" and parameter["summary"].endswith("below the output folder"):
            ending = re.search(r"`(\.\w+)`", parameter["summary"])[1]
            return ending if ending in SHOWN else None
    return None


class BodyMethods(Object):
    """Bodies show their mesh."""

    __slots__ = ()

    def _repr_svg_(self):
        return self.mesh._repr_svg_()


class MaterialMethods(Object):
    """Materials show their curves."""

    __slots__ = ()

    def _repr_svg_(self):
        return self.plot()._repr_html_()


class SimulationMethods(Object):
    """Methods of simulations that exist in Python alone."""

    __slots__ = ()

    def report(self):
        """The page about the run so far, which a notebook opens inside."""
        from . import _api

        return _api.GLOBALS["report"](self)

    def to_pyvista(self, fields=("displacement", "velocity", "von_mises")):
        """The deformed bodies as a ``pyvista.MultiBlock`` with fields at their nodes.

        Parameters
        ----------
        fields : list of str, optional
            Names as in ``field``.
        """
        import pyvista

        blocks = pyvista.MultiBlock()
        for body in self.bodies:
            grid = body.mesh.to_pyvista()
            position = self.field("position", body)
            grid.points[:, : position.shape[1]] = position
            for name in fields:
                grid.point_data[name] = self.field(name, body)
            blocks.append(grid, body.name)
        return blocks

    def _repr_svg_(self):
        return self.picture()._repr_html_()
