"""Writes the reference in both languages side by side: ``python -m conserva._reference > docs/python-reference.md``."""

from . import _api
from ._translate import keyword_name

HEAD = """# The language and the module side by side

Every function, method and property in the script language and in Python, by topic. A name links to its parameters in
[reference.md](reference.md); `help(cs.rectangle)` shows them in Python, with the example. Arguments with `=…` may be left out. Made by
`python -m conserva._reference`; a test fails when this page is not current.
"""


def in_python(function):
    """A call of the function in Python."""
    owner = function["of"] and _api.RENAMED.get(function["of"], function["of"]).lower()
    place = f"{owner}." if owner else "cs."
    if function["form"] == "property":
        return f"{place}{function['name']}"
    if function["form"] == "column":
        return f'{owner}["{function["name"]}"]'
    plain = [parameter for parameter in function["parameters"] if not parameter["keys"]]
    keys = sorted((key for parameter in function["parameters"] for key in parameter["keys"]), key=lambda key: not key["required"])
    given, named = ([keyword_name(row["name"]) + ("" if row["required"] else "=…") for row in rows] for rows in (plain, keys))
    return f"{place}{function['name']}({', '.join(given + (['*', *named] if named else []))})"


def anchor(function):
    """The heading of a function in the reference."""
    name = f"{function['of']}.{function['name']}" if function["of"] else function["name"]
    name = f"{function['of']}[{function['name']}]" if function["form"] == "column" else name
    return name, "".join(letter for letter in name.lower() if letter.isalnum() or letter == "_")


def text():
    """The whole page."""
    lines, topic = [HEAD], None
    for function in sorted(_api.FUNCTIONS, key=lambda function: ORDER.index(function["topic"])):
        if function["topic"] != topic:
            topic = function["topic"]
            lines += [*[""][: len(lines) - 1], f"## {topic}", "", "| | script | Python |", "|---|---|---|"]
        name, place = anchor(function)
        script = function["signature"].replace("|", "\\|")
        lines.append(f"| [{name}](reference.md#{place}) | `{script}` | `{in_python(function)}` |")
    return "\n".join(lines) + "\n"


ORDER = list(dict.fromkeys(function["topic"] for function in _api.FUNCTIONS))

if __name__ == "__main__":
    print(text(), end="")
