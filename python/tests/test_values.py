"""Values between Python and the engine."""

import copy
import gc
import inspect
import pickle
import threading
from pathlib import Path

import numpy as np
import pytest

import conserva as cs


def test_arrays_are_numpy(simulation, plate):
    simulation.step(3)
    column = simulation.history.total
    assert isinstance(column, np.ndarray) and column.dtype == np.float64 and column.shape == (4,)
    assert simulation.history["step"].dtype in (np.int64, np.float64)
    positions = simulation.field("position", plate[1])
    assert positions.shape == (15, 2)


def test_a_history_is_a_mapping_of_columns(simulation):
    simulation.step(2)
    history = simulation.history
    table = dict(history)
    assert list(table) == history.keys() == list(history.columns)
    assert "total" in history and history.get("nothing") is None and len(history) == len(history.values())
    assert all(len(column) == 3 for _, column in history.items())
    with pytest.raises(KeyError, match="did you mean"):
        history["totl"]


def test_maps_are_records(simulation):
    energy = simulation.energy
    assert isinstance(energy, dict) and energy.total == energy["total"]
    with pytest.raises(AttributeError, match="the keys are"):
        energy.totl


def test_numbers_texts_and_paths_of_numpy_and_pathlib_go_in():
    with cs.session(output=Path("out")):
        mesh = cs.rectangle(size=np.array([2.0, 1.0]), cells=(np.int64(4), np.int32(2)))
        mesh.write(Path("plate.msh"))
    again = cs.read_mesh(Path("out/plate.msh").resolve())
    assert (again.nodes, again.cells) == (15, 8)
    assert cs.sum(range(4)) == 6 and cs.sqrt(np.float64(4.0)) == 2.0


def test_positions_are_those_of_a_closed_form():
    mesh = cs.rectangle(size=[2.0, 1.0], cells=[4, 2])
    x, y = np.meshgrid(np.linspace(0.0, 2.0, 5), np.linspace(0.0, 1.0, 3))
    wanted = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    found = mesh.positions
    order = np.lexsort((found[:, 0], found[:, 1]))
    assert np.allclose(found[order], wanted, rtol=0.0, atol=1e-15)
    assert mesh.connectivity.shape == (8, 4)


MESHES = {
    "tri3": ("rectangle", [2.0, 1.0]), "tri6": ("rectangle", [2.0, 1.0]), "quad4": ("rectangle", [2.0, 1.0]), "quad8": ("rectangle", [2.0, 1.0]),
    "quad9": ("rectangle", [2.0, 1.0]), "hex8": ("block", [2.0, 1.0, 1.0]), "tet4": ("block", [2.0, 1.0, 1.0]), "tet10": ("block", [2.0, 1.0, 1.0]),
    "hex20": ("block", [2.0, 1.0, 1.0]), "hex27": ("block", [2.0, 1.0, 1.0]),
}  # fmt: skip


EDGES_OF_PLANE = {3: [(0, 1), (1, 2), (2, 0)], 4: [(0, 1), (1, 2), (2, 3), (3, 0)]}
EDGES_OF_TETRAHEDRON = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
EDGES_OF_HEXAHEDRON = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
FACES_OF_HEXAHEDRON = [(0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)]
# Corners of which each further node is the middle, in the order of VTK, which is that of meshio.
MIDDLES = {
    "tri6": EDGES_OF_PLANE[3], "quad8": EDGES_OF_PLANE[4], "quad9": [*EDGES_OF_PLANE[4], (0, 1, 2, 3)], "tet10": EDGES_OF_TETRAHEDRON,
    "hex20": EDGES_OF_HEXAHEDRON, "hex27": [*EDGES_OF_HEXAHEDRON, *FACES_OF_HEXAHEDRON, tuple(range(8))],
}  # fmt: skip


@pytest.mark.parametrize("element", MESHES)
def test_meshio_has_the_nodes_of_vtk_for_every_element(element):
    pytest.importorskip("meshio")
    name, size = MESHES[element]
    mesh = getattr(cs, name)(size=size, cells=[2] * len(size), element=element)
    other = mesh.to_meshio()
    cells = other.cells[0].data
    corners = cells.shape[1] - len(MIDDLES.get(element, []))
    for place, ends in enumerate(MIDDLES.get(element, []), corners):
        assert np.allclose(other.points[cells[:, place]], other.points[cells[:, list(ends)]].mean(axis=1)), (place, ends)
    assert len(cells) == mesh.cells and len(other.points) == mesh.nodes


def test_a_load_as_a_callable_gives_the_bytes_of_a_time_function(plate):
    def column(load):
        rubber = cs.neo_hookean(youngs_modulus=100.0, poisson_ratio=0.3, density=1.0)
        model = cs.model("pulled")
        body = model.add_body("plate", cs.rectangle(size=[2.0, 1.0], cells=[4, 2]), rubber)
        model.fix(body.boundary("left"))
        model.force(body.boundary("right"), [1.0, 0.0], load)
        simulation = cs.simulate(model, integrator=cs.energy_momentum(), dt=0.01)
        simulation.run_to(0.2)
        return simulation.history.total

    ramp = cs.ramp(0.0, 1.0, 1.0)
    assert np.array_equal(column(lambda t: t), column(lambda t: ramp.value(t)))
    assert np.allclose(column(lambda t: t), column(ramp), rtol=1e-12)


def test_hooks_are_called_with_the_simulation(simulation):
    seen = []
    simulation.on_step(lambda sim: seen.append(sim.time))
    simulation.step(3)
    assert np.allclose(seen, [0.01, 0.02, 0.03])


def test_a_closed_form_of_free_fall():
    rubber = cs.neo_hookean(youngs_modulus=100.0, poisson_ratio=0.3, density=1.0)
    model = cs.model("fall")
    body = model.add_body("block", cs.rectangle(size=[1.0, 1.0], cells=[2, 2]), rubber)
    model.gravity([0.0, -9.81])
    simulation = cs.simulate(model, integrator=cs.energy_momentum(), dt=0.01)
    simulation.run_to(1.0)
    assert simulation.body(body).center[1] == pytest.approx(0.5 - 0.5 * 9.81, rel=1e-12)


def test_objects_are_shown(simulation, plate):
    mesh = plate[1].mesh
    assert mesh._repr_svg_().startswith("<svg") and mesh._repr_svg_().count("M") == 8
    assert cs.block(size=[1.0, 1.0, 1.0], cells=[1, 1, 1])._repr_svg_() is None
    assert "plate" in simulation._repr_html_() and "Simulation" in repr(simulation)
    assert all("<svg" in value._repr_html_() for value in (simulation, plate[1], plate[1].mesh, plate[1].material))


def test_positions_are_the_memory_of_the_mesh():
    mesh = cs.rectangle(size=[2.0, 1.0], cells=[4, 2])
    first, second = mesh.positions, mesh.positions
    assert first.__array_interface__["data"][0] == second.__array_interface__["data"][0] and not first.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        first[0, 0] = 1.0
    kept = first.copy()
    del mesh, second
    gc.collect()
    assert np.array_equal(first, kept)
    # Results belong to the caller.
    assert cs.linspace(0.0, 1.0, 3).flags.writeable


def test_an_array_outlives_the_thread_that_made_it():
    made = []
    thread = threading.Thread(target=lambda: made.append(cs.rectangle(size=[2.0, 1.0], cells=[40, 20]).positions))
    thread.start()
    thread.join()
    gc.collect()
    assert made[0][:, 0].max() == 2.0


def test_a_study_shows_itself_as_a_table():
    rows = cs.sweep(vary={"n": [1, 2]}, run=lambda p: {"half": 0.5 * p.n})
    assert isinstance(rows, list) and rows[1].half == 1.0
    table = rows._repr_html_()
    assert "<th>half</th>" in table and "<td>0.5</td>" in table and table.count("<tr>") == 3


def test_completion_knows_the_keys():
    assert list(inspect.signature(cs.rectangle).parameters) == ["size", "cells", "origin", "grading", "element"]
    fix = inspect.signature(cs.model("a").fix)
    assert list(fix.parameters) == ["boundary", "components"] and fix.parameters["boundary"].default is inspect.Parameter.empty


def test_what_cannot_be_pickled_says_what_to_do(simulation, plate):
    assert copy.copy(simulation) is simulation
    for work in (copy.deepcopy, pickle.dumps):
        for value in (simulation, *plate):
            with pytest.raises(TypeError) as caught:
                work(value)
            assert caught.value.cause and caught.value.hint


@pytest.mark.parametrize("again", [copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))], ids=["copy", "pickle"])
def test_values_are_pickled_and_copied(again, simulation, plate):
    mesh = cs.disk(radius=1.0, cells=[2, 8], element="quad8")
    mesh.boundary_where("top", lambda x, y: y > 0.5)
    other = again(mesh)
    assert str(other) == str(mesh) and other.element == "quad8" and np.array_equal(other.positions, mesh.positions)
    rubber = cs.mooney_rivlin(c10=0.16, c01=0.02, bulk_modulus=100.0, density=1e-9).viscous(shear_viscosity=0.1)
    assert str(again(rubber)) == str(rubber) and again(rubber).uniaxial(1.5) == rubber.uniaxial(1.5)
    for value in (cs.hat(0.0, 0.5, 2.0), cs.mortar(), cs.newmark(beta=0.3), cs.coulomb(coefficient=0.3), cs.rigid_disk(center=[0.0, 0.0], radius=1.0)):
        assert type(again(value)) is type(value) and str(again(value)) == str(value)
    simulation.step(2)
    assert np.array_equal(again(simulation.history).total, simulation.history.total) and again(simulation.energy) == simulation.energy


def test_a_state_of_another_model_is_refused(simulation):
    state = pickle.loads(pickle.dumps(simulation.save()))
    assert "state of simulation" in str(state)
    model = cs.model("other")
    model.add_body("plate", cs.rectangle(size=[2.0, 1.0], cells=[5, 2]), cs.neo_hookean(youngs_modulus=1.0, poisson_ratio=0.3, density=1.0))
    with pytest.raises(cs.ScriptError, match="does not fit"):
        cs.simulate(model, integrator=cs.energy_momentum(), dt=0.01).restore(state)


def test_pictures_are_shown_without_a_path(simulation):
    simulation.step(3)
    assert simulation.picture(field="velocity")._repr_html_().startswith("<svg")
    assert simulation.plot("total").content.startswith(b"<svg") and cs.plot_curves([{"x": [0.0, 1.0], "y": [0.0, 1.0]}]).ending == ".svg"
    for unrecorded in (simulation.movie, simulation.report):
        with pytest.raises(cs.ScriptError, match="no recording"):
            unrecorded()
    with pytest.raises(cs.ScriptError, match="gif"):
        simulation.movie("a.mp4")


def test_movies_and_pages_are_shown_without_a_path(folder):
    with cs.session(output="out"):
        model = cs.model("flight")
        rubber = cs.neo_hookean(youngs_modulus=100.0, poisson_ratio=0.3, density=1.0)
        model.add_body("plate", cs.rectangle(size=[2.0, 1.0], cells=[4, 2]), rubber)
        model.gravity([0.0, -1.0])
        simulation = cs.simulate(model, integrator=cs.energy_momentum(), dt=0.01)
        simulation.step(3)
        movie, page = simulation.movie(seconds=1), simulation.report()
    assert not list(folder.rglob("shown*"))
    assert movie.content.startswith(b"\x89PNG") and b"acTL" in movie.content and "base64" in movie._repr_html_()
    assert page._repr_html_().startswith("<iframe srcdoc=") and b"</html>" in page.content
    page.save("page.html")
    assert Path("page.html").read_bytes() == page.content


def test_exceptions_can_be_pickled():
    with pytest.raises(cs.ScriptError) as caught:
        cs.rectangle(size=[1.0, 1.0], cels=[1, 1])
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is cs.ScriptError and str(again) == str(caught.value) and again.code == "C1024"


def test_a_session_without_a_folder_says_that_it_writes_nothing(simulation, capsys):
    simulation.picture("plate.svg")
    assert "no output folder" in capsys.readouterr().out and not Path("plate.svg").exists()
