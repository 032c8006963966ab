"""Plots of the language on axes of Matplotlib."""

from ._errors import ScriptError
from ._meshes import CORNERS, CORNERS_OF_PLANE


def dressed(ax, title=None, x_label=None, y_label=None, x_range=None, y_range=None, log="none", **others):
    """Title, labels, ranges and scales, which have the names of the options of ``plot``."""
    for name in others:
        raise ScriptError(f"`{name}` has no effect on axes of Matplotlib", "C1020", ["`ax` has the size and style of its figure"], [f"leave `{name}` out"])
    if title:
        ax.set_title(title)
    ax.set_xlabel(x_label or ax.get_xlabel())
    ax.set_ylabel(y_label or ax.get_ylabel())
    if x_range is not None:
        ax.set_xlim(*x_range)
    if y_range is not None:
        ax.set_ylim(*y_range)
    if "x" in log:
        ax.set_xscale("log")
    if "y" in log:
        ax.set_yscale("log")
    return ax


def history(simulation, columns, *, ax, x="time", labels=None, x_label=None, **dress):
    """Columns of the history of a simulation over another column."""
    names = [columns] if isinstance(columns, str) else list(columns)
    table = simulation.history
    for name, label in zip(names, labels or names):
        ax.plot(table[x], table[name], label=label)
    ax.legend()
    return dressed(ax, x_label=x_label or x, **dress)


def curves(given, *, ax, **dress):
    """Curves of ``plot_curves``."""
    for curve in given:
        table = curve["of"].history if "of" in curve else {}
        x, y = curve.get("x", "time"), curve["y"]
        x, y = (table[values] if isinstance(values, str) else values for values in (x, y))
        style = {"dashed": "--", "dotted": ":", "points": "o"}.get(curve.get("style"), "-")
        ax.plot(x, y, style, label=curve.get("label"))
    if any(curve.get("label") for curve in given):
        ax.legend()
    return dressed(ax, **dress)


def polygons(positions, mesh, ax, **style):
    """Cells of a plane mesh at positions of their nodes."""
    from matplotlib.collections import PolyCollection

    blocks = mesh.blocks
    if blocks[0][0] not in CORNERS_OF_PLANE:
        hint = "`to_pyvista()` shows bodies in space"
        cause = f"the cells are {' and '.join(element for element, _ in blocks)}"
        raise ScriptError("axes of Matplotlib show plane meshes alone", "C1020", [cause], [hint])
    corners = [positions[cell][:, :2] for element, cells in blocks for cell in cells[:, : CORNERS[element]]]
    drawn = ax.add_collection(PolyCollection(corners, **style))
    ax.autoscale_view()
    ax.set_aspect("equal")
    return drawn


def mesh(given, *, ax=None, **style):
    """The cells of a plane mesh."""
    if ax is None:
        from matplotlib import pyplot

        _, ax = pyplot.subplots()
    polygons(given.positions, given, ax, **{"facecolor": "#dbe7f3", "edgecolor": "#33506d", "linewidth": 0.5, **style})
    return ax


def picture(simulation, *, ax, field="von_mises", range=None, bodies=None, mesh=True, title=None, **others):
    """The deformed bodies, colored by the mean of a field over the corners of each cell; vectors by their length."""
    import numpy as np

    drawn = []
    for body in bodies or simulation.bodies:
        values = np.asarray(simulation.field(field, body), dtype=float)
        values = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
        means = [values[cells[:, : CORNERS[element]]].mean(axis=1) for element, cells in body.mesh.blocks if element in CORNERS]
        style = {"edgecolor": "#00000040" if mesh else "none", "linewidth": 0.3}
        drawn.append(polygons(simulation.field("position", body), body.mesh, ax, array=np.concatenate(means or [values]), **style))
    least, greatest = range or (min(each.get_array().min() for each in drawn), max(each.get_array().max() for each in drawn))
    for each in drawn:
        each.set_clim(least, greatest)
    ax.figure.colorbar(drawn[0], ax=ax, label=field)
    return dressed(ax, title=title or f"{simulation.name}, t = {simulation.time:.4g}", **others)


# Functions that draw on `ax` instead of a file, by type and name.
DRAWN = {("Simulation", "plot"): history, ("Simulation", "picture"): picture, (None, "plot_curves"): curves}
