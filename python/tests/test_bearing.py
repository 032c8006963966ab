"""The bearing: Python, a script in Python, and the command give the same bytes; other ways to run scripts."""

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, environment

import conserva as cs
from conserva.__main__ import program

SCRIPT = ROOT / "scripts" / "scenarios" / "bearing.rhai"
sys.path.insert(0, str(ROOT / "examples" / "python"))


def test_the_bearing_from_python_and_from_the_script_has_the_same_history(folder):
    from bearing import bearing

    with cs.session(output=folder / "python") as run:
        bearing(dt=0.02, end=0.6)
    script = cs.run(SCRIPT, output=folder / "script", dt=0.02, until=0.6)
    command = [sys.executable, "-m", "conserva", "run", str(SCRIPT), "--set", "dt=0.02", "--set", "until=0.6", "--out", "command", "--quiet"]
    subprocess.run(command, env=environment(), cwd=folder, check=True, capture_output=True)
    histories = [(folder / name / "history.csv").read_bytes() for name in ("python", "script", "command")]
    assert len(histories[0]) > 3000 and histories[0] == histories[1] == histories[2]
    assert (folder / "python" / "bearing.svg").read_bytes() == (folder / "script" / "bearing.svg").read_bytes()
    assert run.result.error is None and script.checks == 3 and script.is_conserving == run.result.is_conserving
    total = script.history().total
    assert np.array_equal(total, run.result.history().total)


def test_a_check_that_fails_in_a_script_raises_after_its_files_are_written(folder):
    (folder / "wrong.rhai").write_text('let n = param("n", 3); print(`n is ${n}`); expect_close(n, 4);')
    with pytest.raises(cs.CheckFailed):
        cs.run("wrong.rhai")
    assert json.loads((folder / "out" / "wrong" / "summary.json").read_text())
    assert cs.run("wrong.rhai", output=False, n=4).checks == 1


def test_lines_that_a_script_prints_are_printed(folder, capsys):
    (folder / "told.rhai").write_text('print("line of a script");')
    cs.run("told.rhai", output=False)
    cs.help("rectangle")
    assert "line of a script" in capsys.readouterr().out


def test_a_message_about_a_script_has_its_place_and_the_words_of_the_language(folder):
    (folder / "wrong.rhai").write_text("let a = 1;\nlet mesh = rectangle(#{ size: [1.0, 1.0] });")
    for work in (lambda: cs.run("wrong.rhai", output=False), lambda: cs.text((folder / "wrong.rhai").read_text())):
        with pytest.raises(cs.ScriptError) as caught:
            work()
        assert ":2:22" in str(caught.value) and "rectangle(#{" in str(caught.value), str(caught.value)
        assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_a_hint_about_a_cell_names_no_command_of_the_prompt():
    with pytest.raises(cs.ScriptError) as caught:
        cs.text("let a = 1;\na + b")
    assert "let b" in caught.value.hint and ":vars" not in caught.value.hint + str(caught.value)


def test_a_parameter_that_the_script_does_not_have_is_an_error(folder):
    (folder / "a.rhai").write_text("print(1);")
    with pytest.raises(cs.ScriptError):
        cs.run("a.rhai", output=False, nothing=1)


@pytest.mark.parametrize("words, code", [(["--version"], 0), (["doc", "ring"], 0), (["run", "nothing.rhai"], 2), (["nothing"], 2)])
def test_the_command_has_the_exit_codes_of_the_program(words, code, folder):
    done = subprocess.run([sys.executable, "-m", "conserva", *words], env=environment(), capture_output=True, text=True)
    assert done.returncode == code and (done.stdout or done.stderr)


@pytest.mark.skipif(not Path(program()).is_absolute() or not os.access(program(), os.X_OK), reason="the command is not installed")
def test_a_study_starts_its_processes(folder):
    (folder / "study.rhai").write_text('let n = param("n", 1); result("square", n * n);')
    command = [sys.executable, "-m", "conserva", "sweep", "study.rhai", "--vary", "n=1,2,3", "--out", "study"]
    done = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    table = (folder / "study" / "table.csv").read_text()
    assert [line.split(",")[-1] for line in table.splitlines()[1:]] != []
