"""The bearing of Hesch & Betsch (2007) in Python: `scripts/scenarios/bearing.rhai` has the same lines, and gives the same history.csv."""

import sys

import conserva as cs


def bearing(dt: float = 0.005, torque: float = 0.1, end: float = 2.0) -> cs.Simulation:
    """Two rings in frictionless contact, pressed into each other, and spun up by a torque on the inner one."""
    steel = cs.neo_hookean(youngs_modulus=1e5, poisson_ratio=0.1, density=1e-3)
    model = cs.model("bearing")
    outer = model.add_body("outer ring", cs.ring(inner_radius=1.0, outer_radius=1.5, cells=[10, 48]), steel)
    inner = model.add_body("inner ring", cs.ring(inner_radius=0.5, outer_radius=1.002, cells=[10, 40]), steel)
    model.fix(outer.boundary("outer"))
    model.add_contact(
        "race",
        secondary=inner.boundary("outer"),
        primary=outer.boundary("inner"),
        method=cs.mortar(),
        equality=False,
        update="persistency",
    )
    model.torque(inner.boundary("inner"), cs.hat(0.0, 0.5, torque))

    sim = cs.simulate(model, integrator=cs.energy_momentum(), dt=dt, fields_every=0.1)
    settled = sim.settle()
    print(f"settled: strain energy {settled.strain:.6g}")
    sim.run_to(end)
    sim.plot("defect.svg", "energy_defect")
    sim.picture("bearing.svg", field="von_mises")
    cs.expect_conserved(sim, "ledger", tolerance=1e-11)
    cs.expect_conserved(sim, "energy", after=0.5, tolerance=1e-10)
    return sim


if __name__ == "__main__":
    with cs.session(output=sys.argv[1] if len(sys.argv) > 1 else "out/bearing"):
        print(bearing())
