"""Exceptions, made of the parts of a message."""

from ._translate import translated


class ConservaError(Exception):
    """Base of all exceptions of Conserva.

    Attributes
    ----------
    code : str
        Stable code of the message, such as ``C1020``; ``docs/errors.md`` has a section for each.
    title : str
        What is wrong, in one sentence.
    cause : str
        The numbers that show it.
    hint : str
        How to mend it.
    causes, hints : list of str
        Each of them where there is more than one.
    drawn : str
        The message with its place, where it is about a text in the script language.
    """

    def __init__(self, title="", code="", causes=(), hints=(), label="", drawn=""):
        self.title, self.code, self.label, self.drawn = title, code, label, drawn
        self.causes, self.hints = list(causes), list(hints)
        super().__init__(title)

    @property
    def cause(self):
        return "; ".join(self.causes)

    @property
    def hint(self):
        return "; ".join(self.hints)

    def __str__(self):
        if self.drawn:
            return self.drawn
        first = f"{self.title} [{self.code}]" if self.code else self.title
        label = [f"  = here: {self.label}"] if self.label else []
        return "\n".join([first, *label, *(f"  = cause: {text}" for text in self.causes), *(f"  = hint: {text}" for text in self.hints)])

    def __reduce__(self):
        return (type(self), (self.title, self.code, self.causes, self.hints, self.label, self.drawn))


class ScriptError(ConservaError):
    """A call is wrong: a name, a type, a range, or a callable that raised."""


class NotPickled(ScriptError, TypeError):
    """An object that cannot be pickled or copied deeply."""


class ModelError(ScriptError):
    """A model cannot be simulated as it is."""


class StepFailed(ConservaError):
    """A step or an equilibrium was not found; ``simulation.why()`` has its report."""


class CheckFailed(ConservaError, AssertionError):
    """A check, such as ``expect_close``, does not hold."""


class OutputError(ConservaError, OSError):
    """A file of the results could not be written."""

    def __str__(self):
        return ConservaError.__str__(self)


class Interrupted(KeyboardInterrupt):
    """A computation that Conserva itself has ended, by ``stop_after`` or for the interrupt key."""


class ConservaWarning(UserWarning):
    """A warning about a model or a run; the run goes on."""


CLASSES = {"check": CheckFailed, "numerics": StepFailed, "output": OutputError}

# End of hints that holds at the command prompt only; it is removed in Python.
OF_PROMPT = "; `:vars` lists the variables"

# Prefix of the codes of model errors in `docs/errors.md`.
MODEL_CODES = ("C01",)


def exception_of(parts):
    """The exception of a message."""
    if parts["kind"] == "interrupted":
        return Interrupted(parts["title"])
    kind = CLASSES.get(parts["kind"], ConservaError)
    if parts["kind"] == "script":
        kind = ModelError if parts["code"].startswith(MODEL_CODES) else ScriptError
    if parts["is_in_script"]:
        hints = [hint.replace(OF_PROMPT, "") for hint in parts["hints"]]
        return kind(parts["title"], parts["code"], parts["causes"], hints, parts["label"], parts["drawn"].replace(OF_PROMPT, "").strip())
    words = {key: translated(parts[key]) for key in ("title", "label")}
    causes, hints = ([translated(text) for text in parts[key]] for key in ("causes", "hints"))
    return kind(words["title"], parts["code"], causes, hints, words["label"])
