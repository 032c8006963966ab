"""Writes the type stubs of the package: ``python -m conserva._stubs > python/conserva/__init__.pyi``."""

from . import _api, _axes, _views
from ._translate import keyword_name

HEAD = '''"""Types of the package, made by `python -m conserva._stubs`; do not edit."""

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, overload

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
ArrayLike = npt.ArrayLike | Sequence[Any]

__version__: str
PI: float

class ConservaError(Exception):
    title: str
    code: str
    label: str
    drawn: str
    causes: list[str]
    hints: list[str]
    @property
    def cause(self) -> str: ...
    @property
    def hint(self) -> str: ...

class ScriptError(ConservaError): ...
class ModelError(ScriptError): ...
class StepFailed(ConservaError): ...
class CheckFailed(ConservaError, AssertionError): ...
class OutputError(ConservaError, OSError): ...
class ConservaWarning(UserWarning): ...

class Record(dict[str, Any]):
    def __getattr__(self, name: str) -> Any: ...

class Object:
    def _repr_html_(self) -> str: ...

class Shown:
    content: bytes
    ending: str
    def save(self, path: str | os.PathLike[str]) -> None: ...
    def _repr_html_(self) -> str: ...

class Run:
    folder: Path | None
    error: BaseException | None
    checks: int
    findings: list[str]
    energy: list[str]
    is_conserving: bool
    is_doubtful: bool
    def history(self, name: str | None = ...) -> Record: ...

class session:
    result: Run | None
    def __init__(
        self,
        output: str | os.PathLike[str] | None = ...,
        *,
        threads: int = ...,
        home: str | os.PathLike[str] = ...,
        allow_read: Sequence[str | os.PathLike[str]] | None = ...,
        parameters: dict[str, Any] | None = ...,
    ) -> None: ...
    def __enter__(self) -> session: ...
    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None: ...

def run(script: str | os.PathLike[str], *, output: str | os.PathLike[str] | Literal[False] | None = ..., threads: int = ..., **parameters: Any) -> Run: ...
def progress(shown: bool = ...) -> None: ...
def text(code: str, variables: dict[str, Any] | None = ...) -> Record: ...
def from_meshio(mesh: Any) -> Mesh: ...
def load_ipython_extension(ipython: Any) -> None: ...
def unload_ipython_extension(ipython: Any) -> None: ...
'''
TAKES = {
    "number": "float", "int": "int", "bool": "bool", "String": "str", "Array": "ArrayLike", "Amplitude": "float | TimeFunction | Callable[[float], float]",
    "Fn": "Callable[..., Any]", "Map": "dict[str, Any]", "any": "Any",
}  # fmt: skip
GIVES = {
    "number": "float", "float": "float", "int": "int", "bool": "bool", "String": "str", "Array": "Any", "Map": "Record", "any": "Any", "": "None",
}  # fmt: skip
COLUMNS = """    def keys(self) -> list[str]: ...
    def values(self) -> list[Any]: ...
    def items(self) -> list[tuple[str, Any]]: ...
    def get(self, name: str, default: Any = ...) -> Any: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def __contains__(self, name: object) -> bool: ..."""
MESH = """    @property
    def positions(self) -> Array: ...
    @property
    def blocks(self) -> list[tuple[str, Array]]: ...
    @property
    def connectivity(self) -> Array: ...
    @property
    def element(self) -> str: ...
    def to_meshio(self) -> Any: ...
    def to_pyvista(self) -> Any: ...
    def plot(self, *, ax: Any = ..., **style: Any) -> Any: ..."""
SIMULATION = """    def report(self) -> Shown: ...
    def to_pyvista(self, fields: Sequence[str] = ...) -> Any: ..."""
EXTRAS = {"History": COLUMNS, "Path": COLUMNS, "Mesh": MESH, "Simulation": SIMULATION}


def type_of(parameter):
    if parameter["choices"]:
        return f"Literal[{', '.join(repr(choice) for choice in parameter['choices'])}]"
    return TAKES.get(parameter["kind"], parameter["kind"])


def argument(parameter):
    default = "" if parameter["required"] else " = ..."
    return f"{keyword_name(parameter['name'])}: {type_of(parameter)}{default}"


def signature(function):
    """The parameters of a function: its own by place, the keys of its options by name."""
    plain = [parameter for parameter in function["parameters"] if not parameter["keys"]]
    needed = [argument(parameter) for parameter in plain if parameter["required"]]
    rest = [argument(parameter) for parameter in plain if not parameter["required"]]
    keys = [key for parameter in function["parameters"] for key in parameter["keys"]]
    is_open = any(parameter["kind"] == "Map" and parameter["keys"] and "…" in function["signature"] for parameter in function["parameters"])
    named = ["*", *(argument(key) for key in keys)] if keys else []
    return ", ".join([*needed, *rest, *named, *(["**others: Any"] if is_open else [])])


def declared(function, indent=""):
    given = signature(function)
    self_ = ["self"] if indent else []
    # A result whose type the registry does not name is typed as any.
    gives = GIVES.get(function["returns"], function["returns"]) if function["returns"] or function["form"] != "property" else "Any"
    return f"{indent}def {function['name']}({', '.join([*self_, *([given] if given else [])])}) -> {gives}: ..."


def forms(function, indent=""):
    """A function in all of its forms: one that writes a picture or a page returns it where the path is left out, or draws on axes."""
    if not _views.ending_of(function):
        return [declared(function, indent)]
    is_drawn = (function["of"], function["name"]) in _axes.DRAWN
    pathless = {**function, "parameters": [parameter for parameter in function["parameters"] if parameter["name"] != "path"]}
    with_axes = declared({**pathless, "returns": "Any" if is_drawn else "Shown"}, indent)
    if is_drawn:
        with_axes = with_axes.replace(") -> Any", ", ax: Any = ...) -> Any")
    return [line for form in (declared(function, indent), with_axes) for line in (f"{indent}@overload", form)]


def text():
    """The stubs of the whole package."""
    lines = [HEAD]
    for name in _api.CLASSES:
        own = [function for function in _api.FUNCTIONS if function["of"] == name]
        lines.append(f"class {_api.RENAMED.get(name, name)}(Object):")
        for function in own:
            if function["form"] == "property":
                lines += ["    @property", declared(function, "    ")]
            elif function["form"] == "column":
                lines += ["    def __getitem__(self, name: str) -> Any: ...", "    def __getattr__(self, name: str) -> Any: ..."]
            else:
                lines += forms(function, "    ")
        lines += [EXTRAS[name]] if name in EXTRAS else [] if own else ["    ..."]
        lines.append("")
    rows = {}
    for function in _api.FUNCTIONS:
        if function["of"] is None:
            rows.setdefault(function["name"], []).append(function)
    for alike in rows.values():
        for function in alike:
            lines += ["@overload", declared(function)] if len(alike) > 1 else forms(function)
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    print(text(), end="")
