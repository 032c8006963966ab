"""Conserva: contact dynamics that conserves energy and momentum.

Everything that the script language has is here under its own name, with options as keywords::

    import conserva as cs

    rubber = cs.neo_hookean(youngs_modulus=100.0, poisson_ratio=0.3, density=1.0)
    flight = cs.model("flight")
    plate = flight.add_body("plate", cs.rectangle(size=[2.0, 1.0], cells=[8, 4]), rubber)
    flight.initial_velocity(plate, linear=[1.0, 0.0], angular=2.0)
    sim = cs.simulate(flight, integrator=cs.energy_momentum(), dt=0.01)
    sim.run_to(1.0)
    print(sim.history.energy_defect.max())

Objects are bound to the thread that made them; numbers, arrays and texts may go anywhere.
"""

import atexit as _atexit
import math as _math

from . import _api, _core, _told
from ._errors import CheckFailed, ConservaError, ConservaWarning, ModelError, OutputError, ScriptError, StepFailed
from ._magic import load_ipython_extension, text, unload_ipython_extension
from ._meshes import from_meshio
from ._objects import Object, Record
from ._run import Run, run, session
from ._views import Shown

__version__ = _api.REGISTRY["version"]

#: Ratio of the circumference of a circle to its diameter.
PI = _math.pi

globals().update({_api.RENAMED.get(name, name): kind for name, kind in _api.CLASSES.items()})
globals().update(_api.GLOBALS)


def progress(shown=True):
    """Shows on standard error how far computations are, or stops that."""
    _told.shows_progress = shown


__all__ = sorted(
    {"CheckFailed", "ConservaError", "ConservaWarning", "ModelError", "Object", "OutputError", "PI", "Record", "Run", "ScriptError", "Shown", "StepFailed"}
    | {"from_meshio", "progress", "run", "session", "text"}
    | {_api.RENAMED.get(name, name) for name in _api.CLASSES}
    | {function["name"] for function in _api.FUNCTIONS if function["of"] is None}
)

_atexit.register(_core.shutdown)
