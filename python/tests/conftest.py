"""Fixtures: a folder of its own for each test, and a small model."""

import os
from pathlib import Path

import pytest

import conserva as cs

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The working folder of a test, from which its sessions name files."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def plate():
    """A model of a plate that is held on its left side, with the body."""
    rubber = cs.neo_hookean(youngs_modulus=100.0, poisson_ratio=0.3, density=1.0)
    model = cs.model("plate")
    body = model.add_body("plate", cs.rectangle(size=[2.0, 1.0], cells=[4, 2]), rubber)
    model.fix(body.boundary("left"))
    return model, body


@pytest.fixture
def simulation(plate):
    """A simulation of the plate in gravity."""
    model, _ = plate
    model.gravity([0.0, -1.0])
    return cs.simulate(model, integrator=cs.energy_momentum(), dt=0.01)


def environment():
    """Variables of a process that imports this package from where it was imported here."""
    places = [str(Path(cs.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, places))}
