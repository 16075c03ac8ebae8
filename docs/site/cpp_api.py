"""Pages of the headers' API, from Doxygen's XML: one page per header, with its declarations in their order."""

import pathlib
import re
import xml.etree.ElementTree as ElementTree

KINDS = {"function": "function", "variable": "member", "typedef": "type", "enum": "enum", "define": "macro"}


class Headers:
    def __init__(self, folder):
        self.files = {}  # by the name that programs include: the element, and the declarations by their lines
        self.compounds = {}
        self.names = {}  # of every id: the qualified name
        for path in sorted(pathlib.Path(folder).glob("*.xml")):
            if path.name in ("index.xml", "Doxyfile.xml"):
                continue
            for compound in ElementTree.parse(path).getroot().iter("compounddef"):
                self.compounds[compound.get("id")] = compound
        for compound in self.compounds.values():
            self._register(compound)
        for entries in self.files.values():
            entries["members"].sort(key=lambda member: int(member.find("location").get("line")))

    def _file(self, name):
        return self.files.setdefault(name, {"about": None, "members": []})

    def _register(self, compound):
        kind, name = compound.get("kind"), compound.findtext("compoundname")
        if kind in ("class", "struct", "union"):
            self.names[compound.get("id")] = name
        if kind == "file":
            self._file(compound.find("location").get("file"))["about"] = compound
        if (
            kind in ("class", "struct", "union")
            and "::" not in re.sub(r"^(gicube(::(test|scene))?)::", "", name)
            and "<" not in name
        ):
            self._file(compound.find("location").get("file"))["members"].append(compound)
        for member in compound.iter("memberdef"):
            self.names[member.get("id")] = member.findtext("qualifiedname") or member.findtext("name")
            for value in member.iter("enumvalue"):
                self.names[value.get("id")] = f"{self.names[member.get('id')]}::{value.findtext('name')}"
            is_global = kind == "namespace" or (kind == "file" and member.get("id").startswith(compound.get("id")))
            if is_global and member.get("kind") in KINDS:
                self._file(member.find("location").get("file"))["members"].append(member)

    # Text.

    def inline(self, element, domain):
        made = plain(element.text or "")
        for child in element:
            inner = "".join(child.itertext())
            if child.tag == "ref" and child.get("refid") in self.names and domain == "cpp":
                made += joined(made, f":cpp:any:`{inner} <{self.names[child.get('refid')]}>`", child.tail)
            elif child.tag == "computeroutput":
                made += joined(made, f"``{inner}``", child.tail)
            elif child.tag in ("programlisting", "verbatim", "itemizedlist", "simplesect", "parameterlist"):
                pass  # blocks, by paragraphs()
            else:
                made += self.inline(child, domain)
            made += plain(child.tail or "")
        return made

    def paragraphs(self, element, indent, domain):
        """The text of a declaration. Its first sentence and the next ones are one paragraph, as in the header."""
        blocks = []
        for part in ("briefdescription", "detaileddescription"):
            for number, paragraph in enumerate(element.findall(f"{part}/para")):
                text = " ".join(self.inline(paragraph, domain).split())
                if (
                    text
                    and blocks
                    and part == "detaileddescription"
                    and number == 0
                    and not blocks[-1].startswith("..")
                ):
                    blocks[-1] += " " + text
                elif text:
                    blocks.append(text)
                for listing in paragraph.iter("programlisting"):
                    code = code_of(listing)
                    language = domain if ";" in code else "none"  # else a table or a formula
                    blocks.append(f".. code-block:: {language}\n   :force:\n\n" + indented(code, "   "))
                for listing in paragraph.iter("verbatim"):
                    blocks.append("::\n\n" + indented(listing.text or "", "   "))
        return "".join(indented(block, indent) + "\n" for block in blocks)

    # Declarations.

    def compound(self, element, domain):
        name = element.findtext("compoundname")
        short = re.sub(r"^gicube(::(test|scene))?::", "", name)
        kind = "struct" if element.get("kind") == "struct" or domain == "c" else element.get("kind")
        parameters = template_of(element)
        bases = [f"{base.get('prot')} {base.text}" for base in element.findall("basecompoundref")]
        inherited = f" : {', '.join(bases)}" if bases and domain == "cpp" else ""
        made = f"{short}\n{'-' * len(short)}\n\n.. {domain}:{kind}:: {parameters}{name}{inherited}\n\n"
        made += self.paragraphs(element, "   ", domain) + "\n"
        sections = [each for each in element.findall("sectiondef") if each.get("kind").startswith("public")]
        members = [member for section in sections for member in section.findall("memberdef")]
        for member in sorted(members, key=lambda each: int(each.find("location").get("line"))):
            made += self.member(member, "   ", domain, True)
        for inner in element.findall("innerclass"):
            nested = self.compounds.get(inner.get("refid"))
            if nested is not None and inner.get("prot") == "public":
                for member in nested.iter("memberdef"):
                    made += self.member(member, "   ", domain, False, nested.findtext("compoundname").split("::")[-1])
        return made

    def member(self, element, indent, domain, in_class, within=""):
        kind, name = KINDS[element.get("kind")], element.findtext("name")
        if kind == "enum" and name.startswith("@"):  # without a name: its values are constants
            return "".join(self.constant(value, indent) for value in element.findall("enumvalue"))
        if not name or "@" in name or name.startswith(("operator", "~")):
            return ""
        if domain == "c" and kind == "type" and "".join(element.find("type").itertext()) == f"struct {name}":
            return ""  # the record itself is there
        scope = (within + "::") if within else ("" if in_class or domain == "c" else scope_of(element))
        if kind == "macro":
            if not element.findtext("briefdescription/para") and element.find("detaileddescription/para") is None:
                return ""
            parameters = ", ".join(each.text or "" for each in element.findall("param/defname"))
            called = f"({parameters})" if parameters else ""
            return f"{indent}.. c:macro:: {name}{called}\n\n{self.paragraphs(element, indent + '   ', 'c')}\n"
        text = self.paragraphs(element, indent + "   ", domain)
        if kind == "enum":
            scoped = "enum-class" if element.get("strong") == "yes" else "enum"
            made = f"{indent}.. {domain}:{scoped}:: {scope}{name}\n\n{text}\n"
            values = element.findall("enumvalue")
            return made + "".join(self.value(value, indent + "   ", domain) for value in values)
        declaration = self.declaration(element, kind, scope + name, domain)
        return f"{indent}.. {domain}:{kind}:: {declaration}\n\n{text}\n"

    def constant(self, element, indent):
        number = (element.findtext("initializer") or "").removeprefix("= ")
        text = self.paragraphs(element, indent + "   ", "c")
        return f"{indent}.. c:macro:: {element.findtext('name')}\n\n{indent}   {number}\n\n{text}\n"

    def value(self, element, indent, domain):
        text = self.paragraphs(element, indent + "   ", domain)
        return f"{indent}.. {domain}:enumerator:: {element.findtext('name')}\n\n{text}\n"

    def declaration(self, element, kind, name, domain):
        kept = " ".join("".join(element.find("type").itertext()).split())
        arguments = " ".join((element.findtext("argsstring") or "").split())
        if kind == "type" and domain == "cpp":
            return f"{name} = {kept}" if "(" not in kept else name
        if kind == "type":
            return f"{kept} {name}{arguments}" if "(" in kept else f"{kept} {name}"
        before = "".join(f"{word} " for word in ("static", "explicit") if element.get(word) == "yes")
        initializer = element.find("initializer")
        initial = " ".join("".join(initializer.itertext()).split()) if initializer is not None else ""
        if len(initial) > 40:  # a table
            initial = ""
        template = template_of(element) if domain == "cpp" else ""
        before = before if kind == "function" and domain == "cpp" else ""
        return f"{template}{before}{kept} {name}{arguments} {initial}".strip()

    def page(self, header, domain):
        """The header's text and declarations."""
        entries = self.files[header]
        made = f"{header}\n{'=' * len(header)}\n\n"
        if entries["about"] is not None:
            made += self.paragraphs(entries["about"], "", domain) + "\n"
        last = ""  # functions of one name share a heading
        for element in entries["members"]:
            if element.tag == "compounddef":
                made += self.compound(element, domain)
            else:
                text = self.member(element, "", domain, False)
                title = element.findtext("name") + ("()" if element.get("kind") == "function" else "")
                headed = element.get("kind") == "enum" or (element.get("kind") == "function" and domain == "cpp")
                if text and headed and "@" not in title and title != last:
                    text = f"{title}\n{'-' * len(title)}\n\n{text}"
                    last = title
                made += text
        return made


def scope_of(element):
    qualified = element.findtext("qualifiedname") or ""
    return qualified[: -len(element.findtext("name"))] if qualified.endswith(element.findtext("name")) else ""


def template_of(element):
    parameters = element.findall("templateparamlist/param")
    if not parameters:
        return ""
    texts = [
        " ".join(filter(None, ("".join(each.find("type").itertext()), each.findtext("declname"))))
        for each in parameters
    ]
    return f"template<{', '.join(texts)}> "


def code_of(listing):
    lines = []
    for line in listing.iter("codeline"):
        text = ""
        for part in line.iter():
            if part.tag == "sp":
                text += " "
            elif part is not line:
                text += part.text or ""
            text += (part.tail or "") if part is not line else ""
        lines.append(text.rstrip())
    return "\n".join(lines)


def plain(text):
    return re.sub(r"([\\*_|`:])", r"\\\1", text)


def joined(before, markup, after):
    """Markup between words that touch it: reStructuredText wants a blank, which an escape hides."""
    left = "" if not before or before[-1] in " (\n" else "\\ "
    right = "\\ " if after and after[0].isalnum() else ""
    return left + markup + right


def indented(text, indent):
    return "".join(f"{indent}{line}\n" if line.strip() else "\n" for line in text.split("\n"))
