"""The space of gicube-explore, a TOML file: scenes, fields with their values, objectives, constraints."""
import math
import operator
import pathlib
import re
import tomllib
from types import SimpleNamespace

from studies.runs import InputError, is_field
from studies.table import FileError

KNOWN = ("transistors", "memory_bits", "pins")  # figures of a configuration without a run
UNITS = {"frame_ms": "ms", "energy": "J", "power": "W"}
OBJECTIVES = ("frame_ms", "energy", "transistors", "memory_bits")
COMPARISONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
ITS_OWN = ("input", "output", "stats", "quiet", "frames", "boards")
KEYS = ("scenes", "fields", "fix", "objectives", "constraints")


def read_space(path):
    """scenes, parameters [(field, [value, ...])], fixed [(name, value)], objectives, constraints; all values as texts.
    Paths of scenes are relative to the file's folder. Raises FileError, InputError."""
    path = pathlib.Path(path)
    try:
        whole = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileError(f"{path}: file: expected one that can be read, got {error.strerror}") from error
    except ValueError as error:
        raise InputError(str(path), "a TOML file", error) from error
    for name in whole:
        expect(name in KEYS, name, f"one of {', '.join(KEYS)}", "a key of another name")
    for name, kind in (("scenes", list), ("objectives", list), ("constraints", list), ("fields", dict), ("fix", dict)):
        value = whole.setdefault(name, kind())
        expect(isinstance(value, kind), name, "a list" if kind is list else "a table", value)
        expect(kind is dict or all(isinstance(each, str) for each in value), name, "a list of strings", value)
    expect(whole["scenes"] and whole["fields"], "scenes" if not whole["scenes"] else "fields", "at least one", "none")
    scenes = [name if name.startswith("builtin:") else str(path.parent / name) for name in whole["scenes"]]
    fixed = [(name, text_of(name, value)) for name, value in whole["fix"].items()]
    parameters = [(name, values_of(name, values)) for name, values in whole["fields"].items()]
    for name, _ in fixed:
        expect(name not in ITS_OWN and name not in whole["fields"], f"fix: {name}",
               "a parameter that is not set elsewhere", "one that is")
    if "threads" not in whole["fix"]:
        fixed.append(("threads", "1"))
    objectives = list(dict.fromkeys(whole["objectives"] or OBJECTIVES))
    expect(len(objectives) > 1, "objectives", "at least two", objectives)
    return SimpleNamespace(scenes=scenes, parameters=parameters, fixed=fixed, objectives=objectives,
                           constraints=[Constraint(text) for text in whole["constraints"]])


def expect(holds, what, expected, got):
    if not holds:
        raise InputError(what, expected, got)


def text_of(name, value):
    """A value in the form of gicube-sweep: true and false are on and off."""
    expect(isinstance(value, (str, int, float)), name, "a text, a number, true or false", value)
    return ("on" if value else "off") if isinstance(value, bool) else str(value)


def values_of(name, values):
    expect(is_field(name), name, "a field of the board's configuration, as asic.processors", "another name")
    expect(isinstance(values, list) and values, name, "a list of values", values)
    texts = [text_of(name, value) for value in values]
    expect(len(set(texts)) == len(texts), name, "each value once", values)
    return texts


class Constraint:
    """NAME < NUMBER UNIT, also <=, > and >=."""

    def __init__(self, text):
        found = re.fullmatch(r"\s*(\S+?)\s*(<=|>=|<|>)\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(\S*)\s*", text)
        expect(found, "constraints", "NAME < NUMBER, as frame_ms < 33", f'"{text}"')
        self.text, self.name, self.sign = text.strip(), found[1], found[2]
        try:
            self.limit = float(found[3])
        except ValueError as error:
            raise InputError(self.text, "a number", found[3]) from error
        unit = UNITS.get(self.name, "")
        expect(found[4] in ("", unit), self.text, f"the unit {unit}" if unit else "no unit", found[4])

    def worst(self, values):
        """The worst figure of the scenes for this constraint."""
        return (max if "<" in self.sign else min)(values)

    def holds(self, value):
        return COMPARISONS[self.sign](value, self.limit)

    def violation(self, value):
        """0 if it holds; else the excess relative to the limit."""
        return 0.0 if self.holds(value) else abs(value - self.limit) / (abs(self.limit) or 1) + 1e-9


def mean(values):
    """Geometric mean, so that long and short scenes have equal weight."""
    return math.exp(sum(map(math.log,
                            values)) / len(values)) if min(values) > 0 else 0.0 if min(values) == 0 else math.nan
