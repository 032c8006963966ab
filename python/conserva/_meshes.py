"""Meshes as arrays, drawings, pickles, and meshes of other programs."""

from . import _core
from ._errors import ScriptError
from ._objects import Object

# Mesh types in meshio, which has the order of nodes of VTK, as Conserva has.
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
ELEMENTS = {name: element for element, name in MESHIO.items()}
CORNERS = {"tri3": 3, "tri6": 3, "quad4": 4, "quad8": 4, "quad9": 4, "tet4": 4, "tet10": 4, "hex8": 8, "hex20": 8, "hex27": 8}
# Mesh types of facets in meshio by the number of their nodes, in the plane and in space.
FACETS = {2: {2: "line", 3: "line3"}, 3: {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}}
FACET_CORNERS = {"line": 2, "line3": 2, "triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}

# Cells of a mesh that is drawn in a notebook; more make a page slow.
MOST_DRAWN = 20_000


class MeshMethods(Object):
    """Methods of meshes that exist in Python alone: arrays, and meshes of other programs."""

    __slots__ = ()

    @property
    def positions(self):
        """Positions of the nodes, of the shape (nodes, 3) [length]; a read-only view of the memory of the mesh."""
        return _core.positions(self._number)

    @property
    def connectivity(self):
        """Node numbers of the cells, of the shape (cells, nodes of a cell); a read-only view of the memory of the mesh."""
        return _core.mesh(self._number)["connectivity"]

    @property
    def element(self):
        """Mesh type, such as ``quad4``."""
        return _core.mesh(self._number)["element"]

    def to_meshio(self):
        """The mesh as a ``meshio.Mesh``: parts and boundaries become cell sets, single nodes of boundaries point sets."""
        import meshio
        import numpy as np

        parts = _core.mesh(self._number)
        blocks = [(MESHIO[parts["element"]], parts["connectivity"])]
        named, points = [(name, 0, cells) for name, cells in parts["parts"].items()], {}
        for name, boundary in parts["boundaries"].items():
            if len(boundary["facets"]):
                named.append((name, len(blocks), np.arange(len(boundary["facets"]))))
                blocks.append((FACETS[parts["dimension"]][boundary["facets"].shape[1]], boundary["facets"]))
            if len(boundary["nodes"]):
                points[name] = boundary["nodes"]
        empty = np.zeros(0, dtype=int)
        sets = {name: [np.asarray(cells, dtype=int) if place == block else empty for place in range(len(blocks))] for name, block, cells in named}
        return meshio.Mesh(np.array(self.positions), blocks, cell_sets=sets, point_sets=points)

    def to_pyvista(self):
        """The cells as a ``pyvista.UnstructuredGrid``."""
        import meshio
        import numpy as np
        import pyvista

        return pyvista.from_meshio(meshio.Mesh(np.array(self.positions), [(MESHIO[self.element], self.connectivity)]))

    def plot(self, *, ax=None, **style):
        """Draws the cells of a plane mesh onto axes of Matplotlib; returns the axes."""
        from . import _axes

        return _axes.mesh(self, ax=ax, **style)

    def _repr_svg_(self):
        parts = _core.mesh(self._number)
        return drawn(self.positions, parts) if parts["dimension"] == 2 and len(parts["connectivity"]) <= MOST_DRAWN else None

    def __reduce__(self):
        parts = _core.mesh(self._number)
        boundaries = [(name, entry["sides"].tobytes(), entry["nodes"].tobytes()) for name, entry in parts["boundaries"].items()]
        named = [(name, cells.tobytes()) for name, cells in parts["parts"].items()]
        return made, (parts["element"], self.positions.tobytes(), parts["connectivity"].tobytes(), named, boundaries)


def made(element, positions, connectivity, parts, boundaries=(), facet_sets=(), node_sets=()):
    """A mesh of arrays as bytes."""
    return _core.make_mesh(element, positions, connectivity, list(parts), list(boundaries), list(facet_sets), list(node_sets))


def drawn(positions, parts):
    """The cells of a plane mesh as SVG."""
    x, y = positions[:, 0], positions[:, 1]
    left, width, top, height = x.min(), x.max() - x.min(), y.max(), y.max() - y.min()
    scale = 400 / max(width, height)
    px, py = (x - left) * scale + 2, (top - y) * scale + 2
    corners = parts["connectivity"][:, : CORNERS[parts["element"]]]
    paths = "".join("M" + "L".join(f"{px[node]:.1f},{py[node]:.1f}" for node in cell) + "Z" for cell in corners)
    size = f'width="{width * scale + 4:.0f}" height="{height * scale + 4:.0f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}><path d="{paths}" fill="#dbe7f3" stroke="#33506d" stroke-width="0.7"/></svg>'


def from_meshio(mesh):
    """A mesh of a ``meshio.Mesh``.

    All cells must have one mesh type. Cell sets (and the tags ``gmsh:physical``) of cells become parts, those of their sides boundaries; a
    point set becomes the boundary of the sides all of whose corners it has, and of its other nodes. Plane cells whose nodes run clockwise
    are turned, nodes without cells are left out.

    Parameters
    ----------
    mesh : meshio.Mesh
        The mesh, such as ``meshio.read("part.vtu")``.

    Returns
    -------
    Mesh

    Examples
    --------
    >>> import meshio
    >>> cells = [("quad", [[0, 1, 2, 3]])]
    >>> plate = cs.from_meshio(meshio.Mesh([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], cells, point_sets={"left": [0, 3]}))
    """
    import numpy as np

    kind, points, numbers = cells_of(mesh)
    used, cells = np.unique(numbers, return_inverse=True)
    cells = turned(points[used], cells.reshape(numbers.shape), kind)
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    sides_of = set(FACETS[2 if ELEMENTS[kind] in CORNERS_OF_PLANE else 3].values())
    blocks = [block for block in mesh.cells if block.type == kind]
    starts = dict(zip(map(id, blocks), np.cumsum([0, *(len(block.data) for block in blocks)])))
    parts, sides, nodes = [], [], []
    for name, members in sets_of(mesh).items():
        members = [(block, entries) for block, entries in members if len(entries)]
        own = [entries + starts[id(block)] for block, entries in members if block.type == kind]
        facets = [np.asarray(block.data)[entries, : FACET_CORNERS[block.type]] for block, entries in members if block.type in sides_of]
        if own:
            parts.append((name, as_bytes(np.concatenate(own))))
        if facets:
            sides.append((name, as_bytes(place[np.concatenate(facets)])))
    for name, members in mesh.point_sets.items():
        known = place[np.asarray(members, dtype=int)]
        nodes.append((name, as_bytes(known[known >= 0])))
    positions = np.ascontiguousarray(points[used], dtype=float)
    return made(ELEMENTS[kind], positions.tobytes(), as_bytes(cells), parts, (), sides, nodes)


CORNERS_OF_PLANE = {"tri3", "tri6", "quad4", "quad8", "quad9"}


def cells_of(mesh):
    """Mesh type in meshio, points in space, and node numbers of the cells of highest dimension."""
    import numpy as np

    known = [block for block in mesh.cells if block.type in ELEMENTS and len(block.data)]
    solid = [block for block in known if ELEMENTS[block.type] not in CORNERS_OF_PLANE]
    kinds = sorted({block.type for block in solid or known})
    if len(kinds) != 1:
        title = f"the mesh has cells of the types {', '.join(kinds)}" if kinds else "the mesh has no cells that are known here"
        cause = f"a mesh has one type of {', '.join(ELEMENTS)}"
        raise ScriptError(title, "C1020", [cause], ["make a body of each type and `tie` them" if kinds else "convert the cells first"])
    points = np.zeros((len(mesh.points), 3))
    points[:, : np.shape(mesh.points)[1]] = mesh.points
    return kinds[0], points, np.concatenate([np.asarray(block.data) for block in known if block.type == kinds[0]])


def sets_of(mesh):
    """Pairs of a block of cells and the places of its members, by the names of the cell sets and physical groups."""
    import numpy as np

    found = {}
    for name, members in mesh.cell_sets.items():
        pairs = [(block, np.asarray(entries, dtype=int)) for block, entries in zip(mesh.cells, members) if entries is not None]
        if not name.startswith("gmsh:"):
            found[name] = pairs
    names = {(int(tag), int(dimension)): name for name, (tag, dimension) in mesh.field_data.items()}
    for block, tags in zip(mesh.cells, mesh.cell_data.get("gmsh:physical", [])):
        for tag in np.unique(tags):
            name = names.get((int(tag), block.dim), str(tag))
            if tag and name not in mesh.cell_sets:
                found.setdefault(name, []).append((block, np.flatnonzero(tags == tag)))
    return found


def turned(points, cells, kind):
    """Cells in which the nodes of plane cells run counter-clockwise."""
    import numpy as np

    element = ELEMENTS[kind]
    if element not in CORNERS_OF_PLANE:
        return cells
    count = CORNERS[element]
    x, y = (points[cells[:, :count], k] for k in (0, 1))
    clockwise = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1) < 0
    order = np.r_[0, np.arange(count - 1, 0, -1)]
    if cells.shape[1] > count:
        # The middle nodes of the sides, met in the opposite order, and the node in the middle.
        order = np.r_[order, np.arange(2 * count - 1, count - 1, -1), np.arange(2 * count, cells.shape[1])]
    cells = cells.copy()
    cells[clockwise] = cells[clockwise][:, order]
    return cells


def as_bytes(numbers):
    """Numbers of nodes or cells for the extension."""
    import numpy as np

    return np.ascontiguousarray(numbers, dtype=np.uint32).tobytes()
