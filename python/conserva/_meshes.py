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
    "wedge6": "wedge",
    "wedge15": "wedge15",
    "pyr5": "pyramid",
    "pyr13": "pyramid13",
}
ELEMENTS = {name: element for element, name in MESHIO.items()}
CORNERS = {"tri3": 3, "tri6": 3, "quad4": 4, "quad8": 4, "quad9": 4}
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
    def blocks(self):
        """Pairs of a mesh type, such as ``quad4``, and node numbers of its cells, of the shape (cells, nodes of a cell); read-only views of
        the memory of the mesh. Cells are numbered through, block after block."""
        return _core.mesh(self._number)["blocks"]

    def _only_block(self):
        blocks = self.blocks
        if len(blocks) == 1:
            return blocks[0]
        counts = " and ".join(f"{len(cells)} {element}" for element, cells in blocks)
        hint = "use `blocks`, a pair of mesh type and node numbers for each kind of cells"
        raise ScriptError("the mesh has cells of several types", "C1020", [f"it has {counts} cells"], [hint])

    @property
    def connectivity(self):
        """Node numbers of the cells of a mesh of one type, of the shape (cells, nodes of a cell); a read-only view of the memory of the
        mesh."""
        return self._only_block()[1]

    @property
    def element(self):
        """Mesh type of a mesh of one type, such as ``quad4``."""
        return self._only_block()[0]

    def to_meshio(self):
        """The mesh as a ``meshio.Mesh``: parts and boundaries become cell sets, single nodes of boundaries point sets."""
        import meshio
        import numpy as np

        parts = _core.mesh(self._number)
        for element, cells in parts["blocks"]:
            try:
                meshio.CellBlock(MESHIO[element], cells)
            except KeyError:
                hint = 'write the mesh to a file, `mesh.write("mesh.msh")`, or take cells of first order'
                raise ScriptError(f"meshio has no cells of the type `{element}`", "C1020", [], [hint]) from None
        blocks = [(MESHIO[element], cells) for element, cells in parts["blocks"]]
        starts = np.cumsum([0, *(len(cells) for _, cells in blocks)])
        named, points = {}, {}
        for name, cells in parts["parts"].items():
            for place, (start, end) in enumerate(zip(starts, starts[1:])):
                named.setdefault(name, {})[place] = cells[(cells >= start) & (cells < end)] - start
        for name, boundary in parts["boundaries"].items():
            for facets, _ in boundary["facets"]:
                named.setdefault(name, {})[len(blocks)] = np.arange(len(facets))
                blocks.append((FACETS[parts["dimension"]][facets.shape[1]], facets))
            if len(boundary["nodes"]):
                points[name] = boundary["nodes"]
        empty = np.zeros(0, dtype=int)
        sets = {name: [np.asarray(own.get(place, empty), dtype=int) for place in range(len(blocks))] for name, own in named.items()}
        return meshio.Mesh(np.array(self.positions), blocks, cell_sets=sets, point_sets=points)

    def to_pyvista(self):
        """The cells as a ``pyvista.UnstructuredGrid``."""
        import meshio
        import numpy as np
        import pyvista

        return pyvista.from_meshio(meshio.Mesh(np.array(self.positions), [(MESHIO[element], cells) for element, cells in self.blocks]))

    def plot(self, *, ax=None, **style):
        """Draws the cells of a plane mesh onto axes of Matplotlib; returns the axes."""
        from . import _axes

        return _axes.mesh(self, ax=ax, **style)

    def _repr_svg_(self):
        parts = _core.mesh(self._number)
        count = sum(len(cells) for _, cells in parts["blocks"])
        return drawn(self.positions, parts["blocks"]) if parts["dimension"] == 2 and count <= MOST_DRAWN else None

    def __reduce__(self):
        parts = _core.mesh(self._number)
        boundaries = [(name, entry["sides"].tobytes(), entry["nodes"].tobytes()) for name, entry in parts["boundaries"].items()]
        named = [(name, cells.tobytes()) for name, cells in parts["parts"].items()]
        blocks = [(element, cells.tobytes()) for element, cells in parts["blocks"]]
        return made, (self.positions.tobytes(), blocks, named, boundaries)


def made(positions, blocks, parts, boundaries=(), facet_sets=(), node_sets=()):
    """A mesh of arrays as bytes."""
    return _core.make_mesh(positions, list(blocks), list(parts), list(boundaries), list(facet_sets), list(node_sets))


def drawn(positions, blocks):
    """The cells of a plane mesh as SVG."""
    x, y = positions[:, 0], positions[:, 1]
    left, width, top, height = x.min(), x.max() - x.min(), y.max(), y.max() - y.min()
    scale = 400 / max(width, height)
    px, py = (x - left) * scale + 2, (top - y) * scale + 2
    corners = [cell for element, cells in blocks for cell in cells[:, : CORNERS[element]]]
    paths = "".join("M" + "L".join(f"{px[node]:.1f},{py[node]:.1f}" for node in cell) + "Z" for cell in corners)
    size = f'width="{width * scale + 4:.0f}" height="{height * scale + 4:.0f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}><path d="{paths}" fill="#dbe7f3" stroke="#33506d" stroke-width="0.7"/></svg>'


def from_meshio(mesh):
    """A mesh of a ``meshio.Mesh``.

    Cells of one dimension may have several mesh types. Cell sets (and the tags ``gmsh:physical``) of cells become parts, those of their sides boundaries; a
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

    points, blocks = cells_of(mesh)
    used = np.unique(np.concatenate([cells.ravel() for _, _, cells in blocks]))
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    # Blocks of the mesh are ordered by cell type, blocks of one type in the order of the file.
    first = np.cumsum([0, *(len(cells) for _, _, cells in blocks)])
    starts = {id(block): start for (_, block, _), start in zip(blocks, first)}
    cells_of_type = {}
    for kind, _, cells in blocks:
        cells_of_type.setdefault(ELEMENTS[kind], []).append(turned(points[used], place[cells], kind))
    sides_of = set(FACETS[2 if ELEMENTS[blocks[0][0]] in CORNERS_OF_PLANE else 3].values())
    parts, sides, nodes = [], [], []
    for name, members in sets_of(mesh).items():
        members = [(block, entries) for block, entries in members if len(entries)]
        own = [entries + starts[id(block)] for block, entries in members if id(block) in starts]
        if own:
            parts.append((name, as_bytes(np.concatenate(own))))
        for block, entries in members:
            if block.type in sides_of:
                corners = FACET_CORNERS[block.type]
                sides.append((name, corners, as_bytes(place[np.asarray(block.data)[entries, :corners]])))
    for name, members in mesh.point_sets.items():
        known = place[np.asarray(members, dtype=int)]
        nodes.append((name, as_bytes(known[known >= 0])))
    positions = np.ascontiguousarray(points[used], dtype=float)
    made_of = [(element, as_bytes(np.concatenate(cells))) for element, cells in cells_of_type.items()]
    return made(positions.tobytes(), made_of, parts, (), sides, nodes)


CORNERS_OF_PLANE = {"tri3", "tri6", "quad4", "quad8", "quad9"}


def cells_of(mesh):
    """Points in space, and the blocks of cells of highest dimension: mesh type in meshio, block, node numbers; ordered by their types."""
    import numpy as np

    known = [block for block in mesh.cells if block.type in ELEMENTS and len(block.data)]
    solid = [block for block in known if ELEMENTS[block.type] not in CORNERS_OF_PLANE]
    kinds = sorted({block.type for block in solid or known})
    if not kinds:
        cause = f"a mesh has cells of {', '.join(ELEMENTS)}"
        raise ScriptError("the mesh has no cells that are known here", "C1020", [cause], ["convert the cells first"])
    points = np.zeros((len(mesh.points), 3))
    points[:, : np.shape(mesh.points)[1]] = mesh.points
    return points, [(kind, block, np.asarray(block.data)) for kind in kinds for block in known if block.type == kind]


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
        # Mid-side nodes in reverse order, then the center node.
        order = np.r_[order, np.arange(2 * count - 1, count - 1, -1), np.arange(2 * count, cells.shape[1])]
    cells = cells.copy()
    cells[clockwise] = cells[clockwise][:, order]
    return cells


def as_bytes(numbers):
    """Numbers of nodes or cells for the extension."""
    import numpy as np

    return np.ascontiguousarray(numbers, dtype=np.uint32).tobytes()
