"""Translation of the script language into Python: examples of the reference, and the words of messages.

Statements and expressions are read once, from left to right, and written as Python at once. The registry says which names are functions and
what they return, so that an options map becomes keywords, a property of a map a key, and a method of arrays a function of Python.
"""

import keyword
import re

TOKEN = re.compile(
    r"""(?P<space>[ \t\r\n]+|//[^\n]*|/\*.*?\*/)
    |(?P<template>`)
    |(?P<text>"(?:\\.|[^"\\])*")
    |(?P<letter>'(?:\\.|[^'\\])')
    |(?P<number>\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][+-]?\d+)?(?!\w))
    |(?P<name>[A-Za-z_]\w*)
    |(?P<sign>\#\{|\.\.=|\.\.|=>|==|!=|<=|>=|&&|\|\||\*\*=?|\+=|-=|\*=|/=|%=|::|[-+*/%<>=!|&(){}\[\],;:.?^…])""",
    re.X | re.S,
)
OPERATORS = [["||"], ["&&"], ["==", "!=", "<", ">", "<=", ">=", "in"], ["+", "-"], ["*", "/", "%"], ["**"]]
LEVELS = {sign: level for level, signs in enumerate(OPERATORS) for sign in signs}
SUM = LEVELS["+"]
IN_PYTHON = {"||": "or", "&&": "and"}
CONSTANTS = {"true": "True", "false": "False", "PI": "cs.PI"}
# Methods of arrays, strings and numbers that the engine provides.
BUILT_IN = {
    "len": "len({0})", "abs": "abs({0})", "to_string": "str({0})", "to_float": "float({0})", "to_int": "int({0})", "push": "{0}.append({1})",
    "contains": "({1} in {0})", "is_empty": "(len({0}) == 0)", "map": "[({1})(entry) for entry in {0}]", "pop": "{0}.pop()",
    "filter": "[entry for entry in {0} if ({1})(entry)]", "keys": "list({0})", "values": "list({0}.values())", "extract": "{0}[{1}:]",
    "some": "any(({1})(entry) for entry in {0})", "all": "all(({1})(entry) for entry in {0})", "is_nan": "({0} != {0})", "split": "{0}.split({1})",
    "starts_with": "{0}.startswith({1})", "ends_with": "{0}.endswith({1})", "sub_string": "{0}[{1}:]", "index_of": "{0}.index({1})",
}  # fmt: skip


class NotTranslated(ValueError):
    """A text that is no program of the language, or uses what has no counterpart."""


class Known:
    """Names of the registry: functions with the place of their options, members of types, and what they return."""

    def __init__(self, functions=()):
        self.functions = {f["name"]: f for f in functions if f["of"] is None}
        self.members = {}
        for function in functions:
            if function["of"]:
                self.members.setdefault(function["name"], []).append(function)


KNOWN = Known()


def tokens_of(text):
    found, place = [], 0
    while place < len(text):
        match = TOKEN.match(text, place)
        if not match:
            raise NotTranslated(f"unknown sign {text[place]!r}")
        kind, word = match.lastgroup, match.group()
        if kind == "template":
            end = place + 1
            parts = []
            while text[end : end + 1] != "`":
                if end >= len(text):
                    raise NotTranslated("an open template")
                if text.startswith("${", end):
                    depth, close = 1, end + 2
                    while depth:
                        if close >= len(text):
                            raise NotTranslated("an open template")
                        depth += {"{": 1, "}": -1}.get(text[close], 0)
                        close += 1
                    parts.append((True, text[end + 2 : close - 1]))
                    end = close
                else:
                    parts.append((False, text[end]))
                    end += 1
            found.append(("template", parts))
            place = end + 1
            continue
        if kind == "space":
            if word.startswith("//"):
                found.append(("comment", word[2:].strip()))
        else:
            found.append((kind, word))
        place = match.end()
    return found


def keyword_name(name):
    """A name as a keyword argument: a word of Python has an underscore behind it."""
    return name + "_" if keyword.iskeyword(name) else name


def dictionary(entries):
    if all(name.isidentifier() and not keyword.iskeyword(name) for name, _ in entries):
        return "dict(" + ", ".join(f"{name}={value}" for name, value in entries) + ")"
    return "{" + ", ".join(f"{name!r}: {value}" for name, value in entries) + "}"


class Translator:
    """Reads tokens and writes lines of Python."""

    def __init__(self, text, known):
        self.tokens = [token for token in tokens_of(text) if token[0] != "comment"]
        # Words of signs and names, None for other tokens and beyond the end.
        self.words = [word if kind in ("sign", "name") else None for kind, word in self.tokens] + [None, None]
        self.known, self.place, self.types = known, 0, {}
        self.lines, self.depth, self.count, self.locals = [], 0, 0, []

    # Tokens

    def peek(self, ahead=0):
        return self.words[self.place + ahead]

    def take(self, word=None):
        if self.place >= len(self.tokens) or (word is not None and self.peek() != word):
            raise NotTranslated(f"`{word}` is missing")
        self.place += 1
        return self.tokens[self.place - 1][1]

    def accept(self, word):
        if self.peek() == word:
            self.place += 1
            return True
        return False

    def write(self, line):
        self.lines.append("    " * self.depth + line)

    # Statements

    def program(self):
        while self.place < len(self.tokens):
            self.statement(False)
        return "\n".join(self.lines)

    def block(self, gives_value=False):
        self.take("{")
        self.depth += 1
        before = len(self.lines)
        while not self.accept("}"):
            self.statement(gives_value)
        if len(self.lines) == before:
            self.write("pass")
        self.depth -= 1

    def statement(self, gives_value):
        if self.accept(";"):
            return
        word = self.peek()
        special = getattr(self, f"statement_{word}", None) if word and word.isidentifier() else None
        if special and not (word == "switch"):
            self.place += 1
            special(gives_value)
            return
        code, _ = self.expression()
        if self.peek() in ("=", "+=", "-=", "*=", "/=", "%=", "**="):
            sign = self.take()
            self.write(f"{code} {sign} {self.expression()[0]}")
            self.note_assigned(code)
            self.accept(";")
            return
        ends = self.accept(";")
        last = not ends and (self.peek() == "}" or self.place >= len(self.tokens))
        self.write(f"return {code}" if gives_value and last else code)

    def note_assigned(self, code):
        if self.locals and code.isidentifier() and code not in self.locals[-1]["own"]:
            self.locals[-1]["outer"].add(code)

    def note_own(self, name):
        if self.locals:
            self.locals[-1]["own"].add(name)

    def statement_let(self, _):
        name = self.take()
        code, kind = self.expression() if self.accept("=") else ("None", None)
        self.accept(";")
        self.types[name] = kind
        self.note_own(name)
        self.write(f"{name} = {code}")

    statement_const = statement_let

    def statement_if(self, gives_value):
        self.write(f"if {self.expression()[0]}:")
        self.block(gives_value)
        while self.accept("else"):
            if self.accept("if"):
                self.write(f"elif {self.expression()[0]}:")
            else:
                self.write("else:")
            self.block(gives_value)

    def statement_for(self, _):
        if self.accept("("):
            first = self.take()
            self.take(",")
            names = f"{self.take()}, {first}"
            self.take(")")
        else:
            names = self.take()
        self.take("in")
        code = self.expression()[0]
        if "," in names:
            code = f"enumerate({code})"
        for name in names.split(", "):
            self.note_own(name)
        self.write(f"for {names} in {code}:")
        self.block()

    def statement_while(self, _):
        self.write(f"while {self.expression()[0]}:")
        self.block()

    def statement_loop(self, _):
        self.write("while True:")
        self.block()

    def statement_return(self, _):
        self.write("return" if self.peek() in (";", "}") else f"return {self.expression()[0]}")
        self.accept(";")

    def statement_break(self, _):
        self.write("break")

    def statement_continue(self, _):
        self.write("continue")

    def statement_throw(self, _):
        self.write(f"raise RuntimeError({self.expression()[0]})")

    def statement_try(self, _):
        self.write("try:")
        self.block()
        self.take("catch")
        name = ""
        if self.accept("("):
            name = f" as {self.take()}"
            self.take(")")
        self.write(f"except cs.ConservaError{name}:")
        self.block()

    def statement_fn(self, _):
        name = self.take()
        self.take("(")
        self.function(name, self.names(")"))

    def statement_import(self, _):
        raise NotTranslated("an import of a script")

    statement_export = statement_import

    def names(self, end):
        found = []
        while not self.accept(end):
            found.append(self.take())
            self.accept(",")
        return found

    def function(self, name, parameters):
        self.write(f"def {name}({', '.join(parameters)}):")
        self.locals.append({"own": set(parameters), "outer": set()})
        place = len(self.lines)
        if self.peek() == "{":
            self.block(True)
        else:
            self.depth += 1
            self.statement(False)
            self.depth -= 1
        outer = self.locals.pop()["outer"]
        if outer:
            scope = "nonlocal" if self.locals else "global"
            self.lines.insert(place, "    " * (self.depth + 1) + f"{scope} {', '.join(sorted(outer))}")

    # Expressions: the code and what is known of its type

    def expression(self, level=0):
        """An expression of operators from a level on."""
        if self.peek() == "if":
            return self.choice()
        if self.peek() == "switch":
            return self.switch()
        code, kind = self.unary()
        while True:
            sign = self.peek()
            place = LEVELS.get(sign, -1)
            if place >= level:
                self.place += 1
                other, other_kind = self.expression(place + 1)
                if place >= SUM:
                    code, other = self.operand(code, kind, other_kind), self.operand(other, other_kind, kind)
                    kind = "Array" if "Array" in (kind, other_kind) or "list" in (kind, other_kind) else kind
                else:
                    kind = None
                code = f"{code} {IN_PYTHON.get(sign, sign)} {other}"
            elif sign in ("..", "..=") and level <= SUM:
                self.place += 1
                end = self.expression(SUM)[0]
                code, kind = f"range({code}, {end}{' + 1' if sign == '..=' else ''})", None
            else:
                return code, kind

    @staticmethod
    def operand(code, kind, other):
        return f"np.array({code})" if kind == "list" else code

    def choice(self):
        self.take("if")
        condition = self.expression()[0]
        yes = self.braced()
        self.take("else")
        no = self.choice() if self.peek() == "if" else self.braced()
        return f"({yes[0]} if {condition} else {no[0]})", yes[1]

    def braced(self):
        self.take("{")
        value = self.expression()
        self.accept(";")
        self.take("}")
        return value

    def switch(self):
        self.take("switch")
        value = self.expression()[0]
        self.take("{")
        cases, rest = [], "None"
        while not self.accept("}"):
            labels = [self.expression(3)[0]]
            while self.accept("|"):
                labels.append(self.expression(3)[0])
            self.take("=>")
            if self.peek() == "{" and self.peek(1) == "throw":
                raise NotTranslated("an error in a switch")
            given = self.braced()[0] if self.peek() == "{" else self.expression()[0]
            self.accept(",")
            if labels == ["_"]:
                rest = given
            else:
                cases.append(f"{given} if {value} in ({', '.join(labels)},) else ")
        return "(" + "".join(cases) + rest + ")", None

    def unary(self):
        if self.accept("-"):
            code, kind = self.unary()
            return f"-{self.operand(code, kind, None)}", kind
        if self.accept("!"):
            return f"(not {self.unary()[0]})", "bool"
        return self.postfix(*self.primary())

    def primary(self):
        if self.place >= len(self.tokens):
            raise NotTranslated("an expression is missing")
        kind, word = self.tokens[self.place]
        self.place += 1
        if kind == "number":
            return word, "number"
        if kind in ("text", "letter"):
            return word, "String"
        if kind == "template":
            return self.template(word), "String"
        if kind == "name":
            return self.name(word)
        if word == "(":
            if self.accept(")"):
                return "None", None
            code, kind = self.expression()
            self.take(")")
            return f"({code})", kind
        if word == "[":
            return f"[{', '.join(code for code, _ in self.list(']'))}]", "list"
        if word == "#{":
            return dictionary(self.map()), "dict"
        if word == "…":
            return "...", None
        if word in ("|", "||"):
            return self.closure([] if word == "||" else self.names("|")), "Fn"
        raise NotTranslated(f"`{word}` stands where a value should")

    def template(self, parts):
        text = ""
        for is_code, part in parts:
            if is_code:
                inner = Translator(part, self.known)
                inner.types = self.types
                text += "{" + inner.expression()[0].replace('"', "'") + "}"
            else:
                text += {"{": "{{", "}": "}}", '"': '\\"', "\n": "\\n", "\\": "\\\\"}.get(part, part)
        return f'f"{text}"'

    def list(self, end):
        found = []
        while not self.accept(end):
            found.append(self.expression())
            self.accept(",")
        return found

    def map(self):
        entries = []
        while not self.accept("}"):
            if self.accept("…"):
                self.accept(",")
                entries.append(("…", "..."))
                continue
            kind, name = self.tokens[self.place]
            self.place += 1
            name = name.strip('"') if kind == "text" else name
            self.accept("?")
            value = self.expression()[0] if self.accept(":") else "..."
            entries.append((name, value))
            self.accept(",")
        return entries

    def closure(self, parameters):
        self.locals.append({"own": set(parameters), "outer": set()})
        if self.peek() not in ("{", "if"):
            try:
                return f"lambda {', '.join(parameters)}: {self.expression()[0]}" if parameters else f"lambda: {self.expression()[0]}"
            finally:
                self.locals.pop()
        self.locals.pop()
        self.count += 1
        name = f"function_{self.count}"
        self.function(name, parameters)
        return name

    def name(self, word):
        if word in CONSTANTS:
            return CONSTANTS[word], None
        if self.peek() == "(" and word == "print":
            self.take()
            return f"print({', '.join(code for code, _ in self.list(')'))})", None
        if self.peek() == "(":
            self.take()
            function = self.known.functions.get(word)
            prefix = "cs." if function and word not in self.types else ""
            return prefix + word + self.arguments(function), function and function["returns"]
        return word, self.types.get(word)

    def arguments(self, function):
        """Arguments up to the closing bracket: a last map of options becomes keywords."""
        options = {i for i, p in enumerate(function["parameters"]) if p["kind"] == "Map"} if function else set()
        found, later = [], []
        index = 0
        while not self.accept(")"):
            if self.peek() == "#{" and index in options:
                self.take()
                entries = self.map()
                later += ["..." if name == "…" else f"{keyword_name(name)}={value}" for name, value in entries]
            elif self.accept("…"):
                found.append("...")
            elif later:
                later.append(f"{function['parameters'][index]['name']}={self.expression()[0]}")
            else:
                found.append(self.expression()[0])
            self.accept("?")
            self.accept(",")
            index += 1
        return f"({', '.join(found + later)})"

    def postfix(self, code, kind):
        while True:
            if self.accept("["):
                index = self.expression()[0]
                self.take("]")
                code, kind = f"{code}[{index}]", None
            elif self.accept("."):
                code, kind = self.member(code, kind)
            elif self.peek() == "(" and kind in (None, "Fn"):
                self.take()
                code, kind = code + self.arguments(None), None
            else:
                return code, kind

    def member(self, code, kind):
        name = self.take()
        members = self.known.members.get(name, [])
        member = next((m for m in members if m["of"] == kind), members[0] if members and kind not in ("Array", "list", "dict", "Map") else None)
        if not self.accept("("):
            if kind == "dict":
                return f'{code}["{name}"]', None
            if name == "len":
                return f"len({code})", "number"
            return f"{code}.{name}", member and member["returns"] or ("Array" if kind in ("History", "Path") else None)
        if name == "call":
            return f"{code}{self.arguments(None)}", None
        if member:
            return f"{code}.{name}{self.arguments(member)}", member["returns"]
        function = self.known.functions.get(name)
        if function:
            rest = self.arguments(None)[1:-1]
            return f"cs.{name}({code}{', ' if rest else ''}{rest})", function["returns"]
        if name in BUILT_IN:
            values = [value for value, _ in self.list(")")]
            if "{1}" in BUILT_IN[name] and not values:
                raise NotTranslated(f"`{name}` without a value")
            return BUILT_IN[name].format(code, *values), "list" if name in ("map", "filter") else None
        return f"{code}.{name}{self.arguments(None)}", None


def program(text, known=None):
    """A script in Python; ``cs`` stands for this package and ``np`` for NumPy.

    Raises
    ------
    NotTranslated
        The script uses what has no counterpart, such as imports.
    """
    try:
        return Translator(text, known or KNOWN).program()
    except (IndexError, RecursionError) as error:
        raise NotTranslated("the text ends too early") from error


def snippet(text):
    """A piece of script within a message as Python; text that is no script is returned as it is."""
    if not re.search(r"#\{|\|[a-z, ]*\||\blet |\btrue\b|\bfalse\b|;$|\w\(", text):
        return text
    try:
        translator = Translator(text, KNOWN)
        return "; ".join(line.strip() for line in translator.program().splitlines()).replace("cs.", "")
    except (NotTranslated, IndexError, RecursionError, AttributeError):
        return text


PHRASES = [
    ("an object map `#{ … }`", "keywords or a `dict`"),
    ("object map", "`dict`"),
    ("a closure", "a callable"),
    ("closures", "callables"),
    ("closure", "callable"),
    ("truth value", "bool"),
]


def translated(text):
    """A message in which names of types and pieces of script are those of Python."""
    for words, instead in PHRASES:
        text = text.replace(words, instead)
    return re.sub(r"`([^`\n]+)`", lambda match: f"`{snippet(match[1])}`", text)
