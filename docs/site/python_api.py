"""Pages of the Python package's API, from its sources: classes, methods, fields and functions with their docstrings.
Nothing is imported, so that no build is needed."""

import ast
import re

# Page, title, modules.
PAGES = [
    ("board", "Boards, rays and pictures", ["board", "board_group", "pending", "image", "counters"]),
    ("arrays", "Arrays of rays and pairs", ["arrays"]),
    ("volume", "Volumes", ["volume", "images"]),
    ("scenes", "Files, transfer functions, scenes, plans", ["scenes"]),
    ("tomography", "Tomography", ["tomography"]),
    ("records", "Records and enumerations", ["records", "record_calls"]),
    ("errors", "Errors", ["errors"]),
    ("plot", "Charts: gicube.plot", ["plot"]),
    ("testing", "Tests: gicube.testing", ["testing"]),
    ("observe", "Observers: gicube.observe", ["observe"]),
]
OWN_NAME = {"plot", "testing", "observe"}  # modules that programs import by their names


def escaped(text):
    """A line of plain prose, with code in `...`, as reStructuredText."""
    parts = re.split(r"(`[^`]*`)", text)
    code = [
        f"``{part[1:-1]}``" if part.startswith("`") and len(part) > 2 else re.sub(r"([\\*_|`])", r"\\\1", part)
        for part in parts
    ]
    return "".join(code)


def prose(text, indent):
    """A docstring's paragraphs. Lines that begin with names of parameters become a list, indented blocks code."""
    lines, out = text.strip("\n").splitlines(), []
    code = False
    for number, line in enumerate(lines):
        depth = len(line) - len(line.lstrip())
        named = re.match(r"(\w+(?:, \w+)*): (?=\S)", line)
        blank_above = number > 0 and not lines[number - 1].strip()
        if not line.strip():
            out.append("")
        elif depth and (code or blank_above):
            if not code:
                out += ["::", ""]
            code = True
            out.append("   " + line)
        else:
            if code:
                out.append("")
            code = False
            if named and depth == 0:
                names = ", ".join(f"``{name}``" for name in named[1].split(", "))
                out += ["", f"- {names}: {escaped(line[named.end():])}"]
            elif depth and out and out[-1].startswith(("- ", "  ")):
                out.append("  " + escaped(line.strip()))
            else:
                if out and out[-1].startswith(("- ", "  ")):
                    out.append("")
                out.append(escaped(line.strip()))
    return "".join(f"{indent}{line}\n" if line else "\n" for line in out)


def signature(function, method):
    """The parameters, without annotations of more than a name: those are long, and the text says what is meant."""
    arguments = ast.parse("def f(): pass").body[0].args
    given = function.args
    arguments.args = [ast.arg(each.arg) for each in given.args]
    arguments.kwonlyargs = [ast.arg(each.arg) for each in given.kwonlyargs]
    arguments.defaults, arguments.kw_defaults = given.defaults, given.kw_defaults
    arguments.vararg = given.vararg and ast.arg(given.vararg.arg)
    arguments.kwarg = given.kwarg and ast.arg(given.kwarg.arg)
    if method and arguments.args:
        arguments.args = arguments.args[1:]
    returns = f" -> {ast.unparse(given_return)}" if (given_return := function.returns) is not None else ""
    return f"({ast.unparse(arguments)}){returns.replace(chr(39), '')}"


def is_property(function):
    return any(
        isinstance(each, ast.Name) and each.id in ("property", "cached_property") for each in function.decorator_list
    )


def entry(kind, name, text, indent, *options):
    """A directive of Sphinx's Python domain with its text."""
    lines = f"{indent}.. py:{kind}:: {name}\n" + "".join(f"{indent}   :{option}:\n" for option in options) + "\n"
    return lines + (prose(text, indent + "   ") + "\n" if text else "")


def docstring_behind(body, number):
    """The text below a field, if there is one."""
    following = body[number + 1] if number + 1 < len(body) else None
    if (
        isinstance(following, ast.Expr)
        and isinstance(following.value, ast.Constant)
        and isinstance(following.value.value, str)
    ):
        return re.sub(r"\n\s+", "\n", following.value.value)
    return ""


def comment_behind(lines, node):
    """The comment on a field's line."""
    match = re.search(r"  # (.*)", lines[node.end_lineno - 1])
    return match[1] if match else ""


def class_entry(node, lines):
    bases = [ast.unparse(base) for base in node.bases]
    text = entry("class", node.name, ast.get_docstring(node) or "", "")
    is_enumeration = "Enum" in bases
    for number, member in enumerate(node.body):
        if isinstance(member, (ast.FunctionDef, ast.AsyncFunctionDef)):
            about = ast.get_docstring(member) or ""
            is_setter = any(isinstance(each, ast.Attribute) for each in member.decorator_list)
            if (
                is_setter
                or (member.name.startswith("_") and member.name != "__init__")
                or (member.name == "__init__" and not about)
            ):
                continue
            if is_property(member):
                text += entry("property", member.name, about, "   ")
            else:
                kind = (
                    "classmethod"
                    if any(ast.unparse(each) == "classmethod" for each in member.decorator_list)
                    else "method"
                )
                text += entry(kind, member.name + signature(member, True), about, "   ")
        elif isinstance(member, ast.AnnAssign) and isinstance(member.target, ast.Name):
            about = docstring_behind(node.body, number) or comment_behind(lines, member)
            options = [f"type: {ast.unparse(member.annotation)}"]
            if member.value is not None and (default := default_of(member.value)):
                options.append(f"value: {default}")
            text += entry(
                "attribute", member.target.id, about, "   ", *[option.replace(": ", ": ", 1) for option in options]
            ).replace(":type: ", ":type: ")
        elif is_enumeration and isinstance(member, ast.Assign):
            text += entry(
                "attribute",
                member.targets[0].id,
                docstring_behind(node.body, number),
                "   ",
                f"value: {ast.unparse(member.value)}",
            )
    return text


def default_of(value):
    """A field's default as one reads it: of field(default_factory=list) it is an empty list."""
    if isinstance(value, ast.Call) and ast.unparse(value.func) == "field":
        for keyword in value.keywords:
            if keyword.arg == "default_factory":
                made = ast.unparse(keyword.value)
                return {"list": "[]", "dict": "{}"}.get(
                    made, re.sub(r"^lambda: ", "", made + ("" if "lambda" in made else "()"))
                )
            if keyword.arg == "default":
                return ast.unparse(keyword.value)
        return ""
    return ast.unparse(value)


def module_entries(path):
    text = path.read_text()
    tree, lines = ast.parse(text), text.splitlines()
    made = ""
    for node in tree.body:
        name = getattr(node, "name", "")
        if name == "shown":  # of the package's own modules
            continue
        if isinstance(node, ast.ClassDef) and not name.startswith("_") and ast.get_docstring(node):
            made += class_entry(node, lines)
        elif (
            isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
            and not name.startswith("_")
            and ast.get_docstring(node)
        ):
            fixture = any("fixture" in ast.unparse(each) for each in node.decorator_list)
            made += entry("function", name + ("" if fixture else signature(node, False)), ast.get_docstring(node), "")
        elif isinstance(node, (ast.AnnAssign, ast.Assign)):
            target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
            above = re.match(r"#: (.*)", lines[node.lineno - 2]) if node.lineno > 1 else None
            if above and isinstance(target, ast.Name):
                made += entry("data", target.id, above[1], "")
    return made


def heading(title):
    return f"{title}\n{'=' * len(title)}\n\n"


def pages(package):
    """Names and texts of all pages."""
    about = ast.get_docstring(ast.parse((package / "__init__.py").read_text()))
    entries = "".join(f"   {name}\n" for name, _, _ in PAGES)
    guide = "The :doc:`guide for Python </docs/guide/python>` says what differs from C++.\n\n"
    yield "index", heading("Python") + prose(about, "") + "\n" + guide + ".. toctree::\n\n" + entries
    for name, title, modules in PAGES:
        text = heading(title)
        for module in modules:
            source = ast.parse((package / f"{module}.py").read_text())
            if len(modules) == 1 and ast.get_docstring(source):
                text += prose(ast.get_docstring(source), "") + "\n"
            text += (
                f".. py:module:: gicube.{module}\n\n" if module in OWN_NAME else ".. py:currentmodule:: gicube\n\n"
            )
            text += module_entries(package / f"{module}.py")
        yield name, text
