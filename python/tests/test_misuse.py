"""Wrong calls: each ends with an exception that has a cause or a hint in Python's words, and the interpreter goes on."""

import copy
import pickle
import re
import threading

import numpy as np
import pytest

import conserva as cs


def rubber(**changes):
    return cs.neo_hookean(**{"youngs_modulus": 100.0, "poisson_ratio": 0.3, "density": 1.0, **changes})


def mesh(**changes):
    return cs.rectangle(**{"size": [2.0, 1.0], "cells": [4, 2], **changes})


def model():
    made = cs.model("plate")
    return made, made.add_body("plate", mesh(), rubber())


def sim(**changes):
    made, body = model()
    made.fix(body.boundary("left"))
    return cs.simulate(made, **{"integrator": cs.energy_momentum(), "dt": 0.01, **changes})


def nested():
    entries = []
    entries.append(entries)
    return entries


def recursion():
    return mesh().map(lambda x, y: recursion())


def raising(_):
    raise ValueError("of the user")


def loaded(load):
    made, body = model()
    made.fix(body.boundary("left"))
    made.force(body.boundary("right"), [1.0, 0.0], load)
    cs.simulate(made, integrator=cs.energy_momentum(), dt=0.01).step()


class Axes:
    """Axes that take everything."""

    def __getattr__(self, _):
        return lambda *values, **named: None


def on_another_thread(make, use):
    """Uses on this thread what another thread made."""
    made = []
    thread = threading.Thread(target=lambda: made.append(make()))
    thread.start()
    thread.join()
    use(made[0])


def pickled_with(change):
    function, (state, rows) = sim().save().__reduce__()
    function(*change(state, rows))


def meshio_of(cells, points=((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)), **sets):
    meshio = pytest.importorskip("meshio", reason="the package meshio is not installed")
    return cs.from_meshio(meshio.Mesh(np.array(points), cells, **sets))


def outside():
    with cs.session(output="out"):
        mesh().write("../plate.msh")


CASES = {
    "a simulation of another thread": lambda: on_another_thread(sim, lambda other: other.step()),
    "a mesh of another thread": lambda: on_another_thread(mesh, lambda other: cs.model("a").add_body("b", other, rubber())),
    "positions of a mesh of another thread": lambda: on_another_thread(mesh, lambda other: other.positions),
    "a state of another simulation": lambda: sim().restore(sim().save()),
    "a contact with a body of another model": lambda: model()[0].add_contact("c", secondary=model()[1].boundary("left"), primary=model()[1].boundary("right")),
    "a spring to a body of another model": lambda: model()[0].add_spring("s", from_=model()[1], to=model()[1], stiffness=1.0),
    "a field of a body of another model": lambda: sim().field("position", cs.model("a").add_body("other", mesh(), rubber())),
    "a state without its end": lambda: pickled_with(lambda state, rows: (state[:-9], rows)),
    "a state with a changed byte": lambda: pickled_with(lambda state, rows: (state[:40] + bytes([state[40] ^ 1]) + state[41:], rows)),
    "a state without rows": lambda: pickled_with(lambda state, rows: (state, b"\xff")),
    "bytes that are no state": lambda: pickled_with(lambda state, rows: (b"", b"")),
    "a simulation that is pickled": lambda: pickle.dumps(sim()),
    "a model that is copied deeply": lambda: copy.deepcopy(model()[0]),
    "a mesh without cells from meshio": lambda: meshio_of([("line", [[0, 1]])]),
    "a cell without area from meshio": lambda: meshio_of([("triangle", [[0, 1, 1]])]),
    "a point that is not a number from meshio": lambda: meshio_of([("triangle", [[0, 1, 2]])], points=[(0.0, 0.0), (1.0, 0.0), (np.nan, 1.0)]),
    "a facet within a mesh from meshio": lambda: meshio_of(
        [("triangle", [[0, 1, 2], [0, 2, 3]]), ("line", [[0, 2]])], cell_sets={"inner": [np.zeros(0, int), np.array([0])]}
    ),
    "points of the wrong shape": lambda: cs.polygon(points=np.ones((2, 4)), size=0.1),
    "an array of texts": lambda: cs.linspace(np.array(["a", "b"]), 1.0, 3),
    "an array of complex numbers": lambda: mesh(size=np.array([1j, 2.0])),
    "a table of three columns": lambda: cs.table(np.ones((3, 3))),
    "a cell of wrong syntax": lambda: cs.text("let a = ;"),
    "a cell with an unknown variable": lambda: cs.text("b + 1"),
    "a cell with a variable that cannot be passed": lambda: cs.text("a", {"a": object()}),
    "axes for a function that draws none": lambda: mesh().refine(1, ax=None),
    "an option that axes do not have": lambda: sim().plot("total", ax=Axes(), width=300),
    "a movie of a run without recording": lambda: sim().movie(),
    "a file outside of the folder": outside,
    "no values": lambda: cs.rectangle(),
    "a key is missing": lambda: cs.rectangle(size=[1.0, 1.0]),
    "an unknown key": lambda: mesh(elemnt="quad4"),
    "an unknown choice": lambda: mesh(element="quad5"),
    "an array of the wrong length": lambda: mesh(size=[1.0, 2.0, 3.0]),
    "a number for an array": lambda: mesh(size=1.0),
    "a text for an array": lambda: mesh(size="2 x 1"),
    "a matrix for an array": lambda: mesh(size=np.ones((2, 2))),
    "negative sizes": lambda: mesh(size=[-1.0, 1.0]),
    "no cells": lambda: mesh(cells=[0, 1]),
    "parts of cells": lambda: mesh(cells=[1.5, 1]),
    "too many cells": lambda: mesh(cells=[10**9, 10**9]),
    "a number above 64 bits": lambda: mesh(cells=[10**30, 1]),
    "not a number": lambda: mesh(size=[float("nan"), 1.0]),
    "infinite": lambda: mesh(size=[float("inf"), 1.0]),
    "a complex number": lambda: cs.sqrt(1j),
    "a set": lambda: mesh(size={1.0, 2.0}),
    "a generator": lambda: mesh(size=(x for x in [1.0, 2.0])),
    "bytes": lambda: cs.model(b"plate"),
    "an array of objects": lambda: cs.sum(np.array([object()])),
    "a list within itself": lambda: cs.sum(nested()),
    "a class": lambda: cs.expect(int),
    "a module": lambda: cs.model(re),
    "keys that are no texts": lambda: cs.rectangle({1: 2}),
    "options by place that are no dict": lambda: cs.rectangle([1.0, 1.0], cells=[1, 1]),
    "a range": lambda: rubber(poisson_ratio=0.7),
    "a truth value for a number": lambda: rubber(density=True),
    "none for a number": lambda: rubber(density=None),
    "a mesh for a material": lambda: cs.model("a").add_body("b", mesh(), mesh()),
    "a material for a mesh": lambda: cs.model("a").add_body("b", rubber(), rubber()),
    "too few values": lambda: cs.hat(1.0),
    "too many values": lambda: cs.hat(1.0, 2.0, 3.0, 4.0),
    "an unknown keyword": lambda: cs.linspace(0.0, 1.0, number=3),
    "a value twice": lambda: cs.linspace(0.0, 1.0, 3, first=1.0),
    "a parameter left out between": lambda: cs.linspace(0.0, count=3),
    "an unknown boundary": lambda: model()[1].boundary("lift"),
    "an unknown field": lambda: sim().field("stres", sim().bodies[0]),
    "an unknown column": lambda: sim().history["totl"],
    "an unknown attribute": lambda: sim().tme,
    "an unknown method": lambda: sim().run(1.0),
    "an attribute that is set": lambda: setattr(sim(), "dt", 1.0),
    "an attribute of its own": lambda: setattr(sim(), "note", 1.0),
    "a class that is called": lambda: cs.Mesh(5),
    "a class that is called without values": lambda: cs.Simulation(),
    "a body of another model": lambda: model()[0].fix(model()[1].boundary("left")),
    "two bodies of one name": lambda: (lambda made: made[0].add_body("plate", mesh(), rubber()))(model()),
    "a model without bodies": lambda: cs.simulate(cs.model("empty"), integrator=cs.energy_momentum(), dt=0.01),
    "a step of no size": lambda: sim(dt=0.0),
    "a negative step": lambda: sim(dt=-1.0),
    "back to the past": lambda: sim().run_to(-1.0),
    "a check that does not hold": lambda: cs.expect_close(1.0, 2.0),
    "a callable that raises": lambda: loaded(raising),
    "a callable of too few parameters": lambda: loaded(lambda: 1.0),
    "a callable of too many parameters": lambda: loaded(lambda t, u: 1.0),
    "a callable that returns a text": lambda: loaded(lambda t: "much"),
    "a callable that returns nothing": lambda: loaded(lambda t: None),
    "a callable that returns not a number": lambda: loaded(lambda t: float("nan")),
    "a callable in place of a number": lambda: rubber(density=lambda: 1.0),
    "a region that is no truth value": lambda: mesh().boundary_where("a", lambda x, y: "yes"),
    "a text for a number": lambda: cs.linspace("a", 1.0, 3),
    "callables that call without end": recursion,
    "a file that is not there": lambda: cs.read_mesh("nothing.msh"),
    "a file that is no mesh": lambda: cs.read_mesh(__file__),
    "a folder that is no mesh": lambda: cs.read_mesh("."),
    "a script that is not there": lambda: cs.run("nothing.rhai"),
    "a session in a folder that is not there": lambda: cs.session(home="nothing").__enter__(),
    "a release that is repeated": lambda: (lambda s: (s._number, s.__class__(0).time))(sim()),
}


@pytest.mark.parametrize("case", CASES)
def test_a_wrong_call_is_an_exception_with_its_cause(case):
    with pytest.raises((cs.ConservaError, AttributeError, KeyError)) as caught:
        CASES[case]()
    error = caught.value
    if isinstance(error, cs.ConservaError):
        assert error.title and (error.causes or error.hints or error.label), str(error)
        assert "#{" not in str(error), str(error)
    else:
        assert str(error)
    # The interpreter and the session go on.
    assert mesh().cells == 8


def test_there_are_enough_wrong_calls():
    assert len(CASES) >= 90


def test_a_simulation_goes_on_after_errors():
    simulation, fresh = sim(), sim()
    simulation.step()
    for wrong in (lambda: simulation.run_to(-1.0), lambda: simulation.field("stres", simulation.bodies[0]), lambda: simulation.step("a")):
        with pytest.raises(cs.ScriptError):
            wrong()
    simulation.step()
    fresh.step(2)
    assert np.array_equal(simulation.history.total, fresh.history.total)


def test_what_a_callable_raised_is_the_cause():
    with pytest.raises(cs.ScriptError, match="of the user") as caught:
        loaded(raising)
    assert isinstance(caught.value.__cause__, ValueError)


def test_a_message_of_an_inner_call_is_kept():
    with pytest.raises(cs.ScriptError) as caught:
        mesh().map(lambda x, y: [cs.hat(1.0), y])
    assert caught.value.code == "C1003"


def test_exceptions_have_classes():
    assert issubclass(cs.ModelError, cs.ScriptError) and issubclass(cs.ScriptError, cs.ConservaError)
    with pytest.raises(cs.CheckFailed):
        cs.expect(False)
    with pytest.raises(cs.ModelError):
        CASES["a model without bodies"]()


def test_a_step_that_fails_says_so():
    made, body = model()
    made.fix(body.boundary("left"))
    made.force(body.boundary("right"), [-1e9, 1e9], lambda t: 1.0)
    simulation = cs.simulate(made, integrator=cs.energy_momentum(), dt=1.0, max_halvings=0)
    with pytest.raises(cs.StepFailed) as caught:
        simulation.step()
    assert caught.value.code and simulation.why()
    assert simulation.steps == 0
