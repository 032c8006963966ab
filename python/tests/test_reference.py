"""The package has everything that the language has, with documentation, stubs and examples that run."""

import contextlib
import io

import numpy as np
import pytest
from conftest import ROOT

import conserva as cs
from conserva import _api, _reference, _stubs, _translate


def test_python_has_every_function_method_and_property():
    missing = []
    for function in _api.FUNCTIONS:
        owner = cs if function["of"] is None else getattr(cs, _api.RENAMED.get(function["of"], function["of"]))
        name = {"column": "__getitem__"}.get(function["form"], function["name"])
        found = vars(owner).get(name)
        if found is None or not (isinstance(found, property) if function["form"] == "property" else callable(found)):
            missing.append(function["signature"])
    assert missing == []
    assert len(_api.FUNCTIONS) > 290


def test_every_key_of_options_is_documented():
    for function in _api.FUNCTIONS:
        text = _api.documentation(function)
        for parameter in function["parameters"]:
            for key in parameter["keys"] or [parameter]:
                assert f"{_translate.keyword_name(key['name'])} : " in text, function["signature"]


@pytest.mark.parametrize("function", _api.FUNCTIONS, ids=lambda function: function["signature"].split("(")[0])
def test_every_example_runs_in_python(function):
    code = _translate.program(function["example"])
    with cs.session(home=ROOT / "scripts"), contextlib.redirect_stdout(io.StringIO()):
        exec(compile(code, function["signature"], "exec"), {"cs": cs, "np": np})


def test_a_translated_script_computes_the_same_numbers(folder):
    script = """
        let sum = 0.0;
        for i in 0..5 { if i == 3 { continue; } sum += i * 0.5; }
        let squares = linspace(0.0, 1.0, 5).map(|x| x * x);
        let twice = [1.0, 2.0] * 2.0;
        let total = 0;
        let add = |x| { total += x; };
        add.call(2);
        let text = `${sum} of ${squares.len()}`;
    """
    names = {"cs": cs, "np": np}
    exec(_translate.program(script), names)
    assert names["sum"] == 3.5 and names["total"] == 2 and names["text"] == "3.5 of 5"
    assert np.array_equal(names["squares"], [0.0, 0.0625, 0.25, 0.5625, 1.0]) and np.array_equal(names["twice"], [2.0, 4.0])


def test_the_stubs_are_current():
    stubs = (ROOT / "python" / "conserva" / "__init__.pyi").read_text(encoding="utf-8")
    assert stubs == _stubs.text(), "make them anew: python -m conserva._stubs > python/conserva/__init__.pyi"


def test_the_page_of_both_languages_is_current():
    page = (ROOT / "docs" / "python-reference.md").read_text(encoding="utf-8")
    assert page == _reference.text(), "make it anew: python -m conserva._reference > docs/python-reference.md"


def test_the_page_of_both_languages_links_to_sections():
    sections = (ROOT / "docs" / "reference.md").read_text(encoding="utf-8").splitlines()
    for function in _api.FUNCTIONS:
        assert f"### {_reference.anchor(function)[0]}" in sections, function["signature"]
