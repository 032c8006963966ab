"""Wrong calls: each ends with an exception that has a cause or a hint in Python's words, and the interpreter goes on."""

import re

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


CASES = {
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
    assert len(CASES) >= 60


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
