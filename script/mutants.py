"""Mutants of C++ sources: small faults, each of which a test should notice.

All mutants of a source are compiled at once. Where one can be, the source asks whether it is switched on:
`a + b` becomes `(GICUBE_MUTANT(17) ? (a - b) : (a + b))`, and GICUBE_MUTANT=17 in the environment switches it on. So
one build serves them all. What the compiler evaluates (constant initialisers, template arguments, array sizes, case
labels) can't ask; named constants are mutated where they are used.
"""
import re
import sys
from collections import namedtuple

sys.path.append("/usr/lib/python3/dist-packages")  # where Debian's python3-clang is, for any python3
from clang import cindex  # noqa: E402
from clang.cindex import CursorKind as K  # noqa: E402

# `kind` is one of KINDS; `text` replaces the bytes begin..end. A dropped statement's is ";" where an if may stand
# before it.
Mutant = namedtuple("Mutant", "file line begin end kind text")
KINDS = ["relation", "arithmetic", "constant", "rounding", "statement", "arguments"]

SWAPPED = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&",
           "+": "-", "-": "+", "*": "+", "/": "*", "%": "*", "<<": ">>", ">>": "<<", "&": "|", "|": "&", "^": "|",
           "+=": "-=", "-=": "+=", "*=": "+=", "/=": "*=", "<<=": ">>=", ">>=": "<<=", "|=": "&=", "&=": "|=",
           "^=": "|=",
           "++": "--", "--": "++"}
RELATIONS = {"<", "<=", ">", ">=", "==", "!=", "&&", "||"}
# Calls that round: what they are without.
UNROUNDED = {"lround": "static_cast<long>({})", "lrint": "static_cast<long>({})", "lrintf": "static_cast<long>({})",
             "llround": "static_cast<long long>({})", "round": "std::trunc({})", "ceil": "std::floor({})",
             "floor": "std::ceil({})", "to_nearest": "static_cast<std::uint32_t>({})",
             "round_shift": "({1} >> {0})", "divide_by_full_scale": "({1} >> {0})"}
SYMMETRIC = {"min", "max", "hypot", "dot", "inner", "gcd"}
A_HALF = re.compile(r"(1(u|U|ull)?|\{1\}\)?) ?<<|/ 2$|/ 2\)$|0\.5$")

FUNCTIONS = {K.FUNCTION_DECL, K.CXX_METHOD, K.CONSTRUCTOR, K.DESTRUCTOR, K.FUNCTION_TEMPLATE, K.CONVERSION_FUNCTION}
NOT_MUTATED = {K.STATIC_ASSERT, K.PARM_DECL, K.CXX_UNARY_EXPR, K.TEMPLATE_TYPE_PARAMETER, K.TEMPLATE_NON_TYPE_PARAMETER,
               K.ENUM_CONSTANT_DECL, K.FIELD_DECL, K.ENUM_DECL, K.TYPE_ALIAS_DECL}
CASES = {K.CASE_STMT, K.DEFAULT_STMT}
NARROW = {cindex.TypeKind.SHORT: "short", cindex.TypeKind.USHORT: "unsigned short",
          cindex.TypeKind.UCHAR: "unsigned char",
          cindex.TypeKind.SCHAR: "signed char"}
NUMBERS = {getattr(cindex.TypeKind, name) for name in
           "SHORT USHORT UCHAR SCHAR INT UINT LONG ULONG LONGLONG ULONGLONG FLOAT DOUBLE".split()}


def without_comments(text):
    """On one line, so that what follows keeps its line number."""
    text = re.sub(r'("(?:\\.|[^"\\])*")|//[^\n]*', lambda m: m.group(1) or "", text)
    return re.sub(r"\s*\n\s*", " ", text)


class Finder:
    """The mutants of one source."""

    def __init__(self, path, name, arguments):
        self.path, self.name = path, name
        with open(path, "rb") as file:
            self.source = file.read()
        self.found = []
        self.constexpr = []  # (begin, end) of functions that the compiler may evaluate
        self.options = ["-x", "c++", "-Wno-c++11-narrowing"] + arguments
        unit = cindex.Index.create().parse(path, args=self.options)
        self.errors = {(d.location.line, d.spelling) for d in unit.diagnostics if d.severity >= cindex.Diagnostic.Error}
        for cursor in unit.cursor.get_children():
            self.walk(cursor, None, False)

    def text(self, begin, end):
        return self.source[begin:end].decode("latin-1")

    def of(self, cursor):
        return self.text(cursor.extent.start.offset, cursor.extent.end.offset)

    def here(self, cursor):
        file = cursor.extent.start.file
        return file is not None and file.name == self.path

    def add(self, cursor, kind, text):
        begin, end = cursor.extent.start, cursor.extent.end
        text = without_comments(text)
        if kind == "statement" or text != without_comments(self.of(cursor)):
            self.found.append(Mutant(self.name, begin.line, begin.offset, end.offset, kind, text))

    def walk(self, cursor, parent, inside):
        if parent is None or cursor.extent.start.file is not None:
            if not self.here(cursor):
                return
        if cursor.kind in NOT_MUTATED:
            return
        children = list(cursor.get_children())
        if cursor.kind in FUNCTIONS:
            body = [c for c in children if c.kind == K.COMPOUND_STMT]
            if not body:
                return
            head = self.text(cursor.extent.start.offset, body[0].extent.start.offset)
            if re.search(r"\bconsteval\b", head):
                return
            if re.search(r"\bconstexpr\b", head):
                self.constexpr.append((cursor.extent.start.offset, cursor.extent.end.offset))
            inside = True
        elif cursor.kind == K.VAR_DECL:
            before = self.of(cursor).split("=")[0]
            if not inside or "constexpr" in before or "constinit" in before:
                return
        elif inside:
            self.look(cursor, parent, children)
        for i, child in enumerate(children):
            if cursor.kind == K.CASE_STMT and i == 0:
                continue
            if cursor.kind == K.IF_STMT and i == 0 and re.match(r"if constexpr\b", self.of(cursor)):
                continue
            self.walk(child, cursor, inside)

    def look(self, cursor, parent, children):
        if self.is_statement(cursor, parent):
            self.add(cursor, "statement", ";" if parent.kind == K.COMPOUND_STMT else "")
        kind = cursor.kind
        if kind in (K.BINARY_OPERATOR, K.COMPOUND_ASSIGNMENT_OPERATOR) and len(children) == 2:
            self.binary(cursor, parent, *children)
        elif kind == K.UNARY_OPERATOR and len(children) == 1:
            self.unary(cursor, parent, children[0])
        elif kind == K.IF_STMT and children and children[0].kind.is_expression():
            condition = children[0]
            if not re.match(r"if constexpr\b", self.of(cursor)) and not self.is_relation(condition):
                self.add(condition, "relation", "!(%s)" % self.of(condition))
        elif kind in (K.INTEGER_LITERAL, K.FLOATING_LITERAL, K.CXX_BOOL_LITERAL_EXPR):
            self.constant(cursor)
        elif kind == K.DECL_REF_EXPR:
            to = cursor.referenced
            if to is not None and to.kind == K.VAR_DECL and to.type.is_const_qualified() and \
                    to.type.get_canonical().kind in NUMBERS and re.match(r"k[A-Z]", to.spelling):
                self.constant(cursor)
        elif kind == K.CALL_EXPR:
            self.call(cursor)

    def is_statement(self, cursor, parent):
        if not (cursor.kind.is_expression() or cursor.kind in (K.BREAK_STMT, K.CONTINUE_STMT) or
                cursor.kind == K.RETURN_STMT and self.of(cursor) == "return"):
            return False
        if cursor.kind in (K.BREAK_STMT, K.CONTINUE_STMT, K.RETURN_STMT):
            return parent.kind == K.COMPOUND_STMT
        if parent.kind == K.COMPOUND_STMT:
            return True
        siblings = list(parent.get_children())
        if parent.kind in (K.FOR_STMT, K.CXX_FOR_RANGE_STMT) or parent.kind in CASES:
            return siblings[-1] == cursor
        return parent.kind == K.IF_STMT and siblings[0] != cursor and siblings[0].kind.is_expression()

    def operator(self, left, right):
        return without_comments(self.text(left.extent.end.offset, right.extent.start.offset)).strip()

    def is_relation(self, cursor):
        children = list(cursor.get_children())
        while cursor.kind == K.UNEXPOSED_EXPR and len(children) == 1:
            cursor, children = children[0], list(children[0].get_children())
        return cursor.kind == K.BINARY_OPERATOR and len(children) == 2 and self.operator(*children) in RELATIONS

    def binary(self, cursor, parent, left, right):
        sign = self.operator(left, right)
        if sign not in SWAPPED:
            return
        numbers = all(c.type.get_canonical().kind in NUMBERS or c.type.get_canonical().kind in (
            cindex.TypeKind.DEPENDENT, cindex.TypeKind.UNEXPOSED, cindex.TypeKind.BOOL) for c in (left, right))
        if not numbers and sign not in RELATIONS:
            return
        if sign.endswith("=") and sign not in RELATIONS and not self.is_statement(cursor, parent):
            return
        if sign in "+-" and A_HALF.search(self.of(right)):
            self.add(cursor, "rounding", self.of(left))
        kind = "relation" if sign in RELATIONS else "arithmetic"
        a, b = self.of(left), self.of(right)
        self.add(cursor, kind, "%s %s %s" % (a, SWAPPED[sign], b))

    def unary(self, cursor, parent, operand):
        whole, inner = self.of(cursor), self.of(operand)
        sign = whole.replace(inner, "", 1).strip()
        if sign in ("++", "--") and self.is_statement(cursor, parent):
            self.add(cursor, "arithmetic", SWAPPED[sign] + inner)
        elif sign in ("-", "~") and operand.type.get_canonical().kind in NUMBERS:
            self.add(cursor, "arithmetic", inner)
        elif sign == "!":
            self.add(cursor, "relation", "!!(%s)" % inner)

    def constant(self, cursor):
        begin, end = cursor.extent.start.offset, cursor.extent.end.offset
        before, after = self.source[:begin].rstrip()[-1:], self.source[end:].lstrip()[:1]
        if before == b"<" and after in b">," or before == b"," and after == b">":
            return  # a template's argument
        if before == b"[" and after == b"]":
            return  # an index: beside it mostly lies what is not there
        text = self.of(cursor)
        if cursor.kind == K.CXX_BOOL_LITERAL_EXPR:
            return self.add(cursor, "constant", "false" if text == "true" else "true")
        kind = cursor.type.get_canonical().kind
        if kind not in NUMBERS:
            return
        real = kind in (cindex.TypeKind.FLOAT, cindex.TypeKind.DOUBLE)
        word = ("static_cast<%s>(%%s)" % NARROW[kind]) if kind in NARROW else "%s"
        self.add(cursor, "constant", word % (text + " + 1"))
        number = re.sub(r"['uUlL]", "", text)
        if real or not number.isdigit():  # or a name
            tenth = " * 1.1f" if kind == cindex.TypeKind.FLOAT else " * 1.1" if real else " * 11 / 10"
            self.add(cursor, "constant", word % (text + tenth))
            self.add(cursor, "constant", word % (text + tenth.replace("11", "9").replace("1.1", "0.9")))
        elif int(number) >= 1:
            self.add(cursor, "constant", text + " - 1")
            if int(number) >= 10:
                self.add(cursor, "constant", text + " * 9 / 10")

    def call(self, cursor):
        arguments = [a for a in cursor.get_arguments() if a is not None]
        texts = [self.of(a) for a in arguments]
        begin, end = cursor.extent.start.offset, cursor.extent.end.offset
        if not arguments or any(not self.here(a) or not t for a, t in zip(arguments, texts)) or \
                any(a.extent.start.offset < begin or a.extent.end.offset > end for a in arguments):
            return
        whole = self.of(cursor)
        if not whole.endswith(")"):
            return
        if cursor.spelling in UNROUNDED and len(arguments) == 1:
            size = re.search(r"<\s*(\w+)\s*>\s*\($", self.text(begin, arguments[0].extent.start.offset))
            form = UNROUNDED[cursor.spelling]
            if "{1}" not in form:
                self.add(cursor, "rounding", form.format(texts[0]))
            elif size:
                self.add(cursor, "rounding", form.format(size.group(1), "(%s)" % texts[0]))
        for first, second in zip(arguments, arguments[1:]):
            if self.text(first.extent.end.offset, second.extent.start.offset).strip() != ",":
                continue  # an operator, or a default
            types = [re.sub(r"\bconst\b|&|\s", "", a.type.get_canonical().spelling) for a in (first, second)]
            if types[0] != types[1] or self.of(first) == self.of(second) or cursor.spelling in SYMMETRIC:
                continue
            self.add(cursor, "arguments", self.text(begin, first.extent.start.offset) + self.of(second) + ", " +
                     self.of(first) + self.text(second.extent.end.offset, end))

    def wrong_lines(self, text):
        """Lines of the source that are not C++ in `text`, what write() made of it, but were before."""
        unit = cindex.Index.create().parse(self.path, args=self.options,
                                           unsaved_files=[(self.path, text.decode("latin-1"))])
        return {d.location.line - 1 for d in unit.diagnostics
                if d.severity >= cindex.Diagnostic.Error and d.location.file is not None
                and d.location.file.name == self.path
                and (d.location.line - 1, d.spelling) not in self.errors}

    def mutants(self):
        """Each once, in the source's order."""
        return sorted(set(self.found), key=lambda m: (m.begin, m.end, m.kind, m.text))


def write(source, numbered, constexpr, first_line):
    """The bytes `source` with these mutants, {number: Mutant}, in place; `first_line`, which includes HEADER, stands
    before."""
    nodes = {}
    for number, mutant in sorted(numbered.items()):
        nodes.setdefault((mutant.begin, mutant.end), []).append((number, mutant))
    order = sorted(nodes, key=lambda n: (n[0], -n[1]))  # outer ones first

    def switch(number, at):
        evaluated = any(b <= at < e for b, e in constexpr)
        return ("gicube_mutant::on_at_run_time(%d)" if evaluated else "gicube_mutant::on(%d)") % number

    def render(begin, end, inner):
        out, at = b"", begin
        while inner:
            node = inner.pop(0)
            if node[0] < at:
                continue  # not nested: can't be, but for macros
            nested = []
            while inner and inner[0][1] <= node[1]:
                nested.append(inner.pop(0))
            text = render(node[0], node[1], nested)
            stopped = None
            for number, mutant in nodes[node]:
                condition = switch(number, node[0])
                if mutant.kind == "statement":
                    stopped = (("if (%s) ; else " if mutant.text else "(%s ? (void)0 : (void)(") % condition,
                               "" if mutant.text else "))")
                else:
                    text = ("(%s ? (%s) : (" % (condition, mutant.text)).encode("latin-1") + text + b"))"
            if stopped:
                text = stopped[0].encode() + text + stopped[1].encode()
            out += source[at:node[0]] + text
            at = node[1]
        return out + source[at:end]

    return first_line + render(0, len(source), order)


MAX_NUMBER = 4096  # of a mutant, exclusive

HEADER = ("""// Switches on the mutant that GICUBE_MUTANT names. With GICUBE_MUTANTS_REACHED, the name of a file,
// notes there which ones a program reaches: in shared memory, so that a killed program's are kept.
#pragma once
#include <fcntl.h>
#include <sys/mman.h>
#include <cstdlib>
#include <type_traits>
namespace gicube_mutant {
inline int chosen() {
  const char* number = std::getenv("GICUBE_MUTANT");
  return number == nullptr ? 0 : std::atoi(number);
}
inline unsigned char* map_reached() {
  const char* file = std::getenv("GICUBE_MUTANTS_REACHED");
  if (file == nullptr) return nullptr;
  void* bytes = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, ::open(file, O_RDWR | O_CLOEXEC), 0);
  return bytes == MAP_FAILED ? nullptr : static_cast<unsigned char*>(bytes);
}
inline int selected = chosen();
inline unsigned char* reached = map_reached();
inline bool on(int number) {
  if (reached != nullptr) reached[number] = 1;
  return number == selected;
}
constexpr bool on_at_run_time(int number) { return std::is_constant_evaluated() ? false : on(number); }
}  // namespace gicube_mutant
""")
