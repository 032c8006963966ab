"""Signals, threads, processes and the end of the interpreter."""

import multiprocessing
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from conftest import environment

import conserva as cs

MODEL = """
import conserva as cs
def simulation(cells=4):
    rubber = cs.neo_hookean(youngs_modulus=100.0, poisson_ratio=0.3, density=1.0)
    model = cs.model("flight")
    body = model.add_body("plate", cs.rectangle(size=[2.0, 1.0], cells=[2 * cells, cells]), rubber)
    model.initial_velocity(body, linear=[1.0, 0.0], angular=2.0)
    return cs.simulate(model, integrator=cs.energy_momentum(), dt=0.01)
"""
NAMES = {}
exec(MODEL, NAMES)
simulation = NAMES["simulation"]


def process(text, **options):
    code = MODEL + textwrap.dedent(text)
    return subprocess.Popen([sys.executable, "-c", code], env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


INTERRUPTED = {
    "a run": "sim = simulation(); start = lambda: sim.run_to(1e9)",
    "a run with Python's handler set again": """
        import signal
        sim = simulation(); sim.step(); signal.signal(signal.SIGINT, signal.default_int_handler); start = lambda: sim.run_to(1e9)""",
    "a script": "open('endless.rhai', 'w').write('loop { }'); sim = None; start = lambda: cs.run('endless.rhai', output=False)",
    "a callable": "sim = simulation(); sim.on_step(lambda _: __import__('time').sleep(0.01)); start = lambda: sim.run_to(1e9)",
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Windows are others")
@pytest.mark.parametrize("case", INTERRUPTED)
def test_the_interrupt_key_ends_at_a_whole_step(case):
    running = process(
        textwrap.dedent(INTERRUPTED[case])
        + textwrap.dedent("""
        print("ready", flush=True)
        try:
            start()
        except KeyboardInterrupt:
            if sim:
                steps = len(sim.history.time) - 1
                assert sim.steps == steps > 0 and abs(sim.time - 0.01 * steps) < 1e-9
                sim.step()
                assert sim.steps == steps + 1
            print("interrupted")
        """)
    )
    assert running.stdout.readline() == "ready\n"
    time.sleep(1.0)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=30)
    assert (out, running.returncode) == ("interrupted\n", 0), err


def test_objects_of_another_thread_say_so_and_are_freed():
    sim = simulation()
    caught = []

    def use():
        try:
            sim.step()
        except cs.ScriptError as error:
            caught.append(error)

    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert "another thread" in str(caught[0]) and caught[0].hint
    made = []
    thread = threading.Thread(target=lambda: made.append(simulation()))
    thread.start()
    thread.join()
    with pytest.raises(cs.ScriptError, match="another thread"):
        made[0].step()
    made.clear()
    sim.step()


def test_threads_compute_side_by_side_with_the_same_bytes():
    results = [None] * 4

    def work(place):
        sim = simulation()
        sim.run_to(0.2)
        results[place] = sim.history.total

    threads = [threading.Thread(target=work, args=(place,)) for place in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert all(np.array_equal(result, results[0]) for result in results)


def test_other_threads_run_while_it_computes():
    counted, over = [0], threading.Event()

    def count():
        while not over.is_set():
            counted[0] += 1
            time.sleep(0.001)

    sim = simulation(24)
    thread = threading.Thread(target=count)
    thread.start()
    begun, before = time.perf_counter(), counted[0]
    sim.run_to(0.3)
    elapsed, during = time.perf_counter() - begun, counted[0] - before
    over.set()
    thread.join()
    # A step that held the lock would let the other thread count once in 5 ms at most.
    assert during > 0.05 * elapsed / 0.001


def total_energy(cells):
    sim = simulation(cells)
    sim.run_to(0.1)
    return sim.energy.total


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_processes_compute_for_this_one(method):
    wanted = [total_energy(cells) for cells in (2, 4)]
    context = multiprocessing.get_context(method)
    with context.Pool(2) as pool:
        assert pool.map(total_energy, (2, 4)) == wanted


@pytest.mark.parametrize("daemon", [True, False])
def test_the_interpreter_ends_while_a_thread_computes(daemon):
    running = process(f"""
        import threading, time
        def work():
            try:
                simulation().run_to({"1e9" if daemon else "0.5"})
            except BaseException:
                pass
        threading.Thread(target=work, daemon={daemon}).start()
        time.sleep(0.5)
        print("over", flush=True)
    """)
    out, err = running.communicate(timeout=60)
    assert (out, running.returncode, "Fatal" in err) == ("over\n", 0, False), err


def test_use_after_the_session_has_ended_is_an_exception():
    with cs.session():
        sim = simulation()
    sim.step()
    assert sim.steps == 1


def test_warnings_are_those_of_python():
    with pytest.warns(cs.ConservaWarning, match="has no facets"), cs.session():
        cs.rectangle(size=[2.0, 1.0], cells=[2, 1]).boundary_where("nowhere", lambda x, y: False)
