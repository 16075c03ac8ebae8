"""Writes the pages of the site (script/docs) for Sphinx: the repository's documents under their own paths, a page for
each source file that they link to, the pages of the API, and the navigation, which follows docs/README.md.

Usage: stage.py DOXYGENS_XML SOURCES_OF_SPHINX
"""

import csv
import html
import os
import pathlib
import re
import shutil
import sys

import cpp_api
import python_api

ROOT = pathlib.Path(__file__).resolve().parents[2]
PICTURES = {".png", ".jpg", ".svg"}
LANGUAGES = {".cpp": "cpp", ".h": "cpp", ".c": "c", ".py": "python", ".proto": "protobuf", ".txt": "cmake"}

# Folder of the API's pages, their title, and their headers: globs from the root. C goes first, so that C++ leaves its
# headers out.
C_HEADERS = ["c_api.h", "c_types.h", "bsdf.h", "observer.h"]
HEADERS = [
    (
        "c",
        "C",
        [f"driver/include/gicube/{name}" for name in C_HEADERS[:2]]
        + [f"proto/gicube/{name}" for name in C_HEADERS[2:]],
    ),
    ("cpp", "C++", ["driver/include/gicube/*.h", "driver/hosts/include/gicube/*.h"]),
    ("scene", "C++: files and scenes", ["driver/scene/include/gicube/scene/*.h"]),
]
ABOUT = {
    "c": "The interface for C and for languages that call C. The [guide](../../docs/guide/c.md) has a whole program.",
    "cpp": "The headers of `libgicube`. Begin with [board.h](board.rst).",
    "scene": "The headers of `libgicube-scene`: files of volumes and pictures, scenes, transfer functions, voxels.",
}


def documents():
    """The Markdown files that become pages, from the root."""
    found = [
        pathlib.Path(name) for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "proto/gicube/wire/README.md")
    ]
    return found + sorted(path.relative_to(ROOT) for path in (ROOT / "docs").rglob("*.md"))


def header_pages():
    """Each public header, and its page without the extension, both from the root."""
    pages = {}
    for folder, _, patterns in HEADERS:
        for pattern in patterns:
            for header in sorted(ROOT.glob(pattern)):
                pages.setdefault(header.relative_to(ROOT), pathlib.Path("api", folder, header.stem))
    return pages


class Stage:
    def __init__(self, out):
        self.out = out
        self.pages = set(documents())
        self.headers = header_pages()
        self.linked = set()  # files and folders that become pages since a document links to them

    def write(self, path, text):
        target = self.out / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text)

    def target_of(self, path):
        """Where a link to a path of the repository leads, from the root; None: to the path itself."""
        if path == pathlib.Path("README.md"):
            return pathlib.Path("index.md")
        if path in self.pages or path.suffix in PICTURES:
            return None
        if path in self.headers:
            return self.headers[path].with_suffix(".rst")
        if (path / "README.md") in self.pages:
            return path / "README.md"
        if not (ROOT / path).exists():
            sys.exit(f"stage.py: a document links to {path}, which does not exist")
        self.linked.add(path)
        return (
            pathlib.Path("files", path, "index.md") if (ROOT / path).is_dir() else pathlib.Path("files", f"{path}.md")
        )

    def with_links(self, text, path):
        """A document's text with links that lead to the site's pages."""

        def link(match):
            target, _, anchor = match[1].partition("#")
            if "://" in target or not target:
                return match[0]
            place = pathlib.Path(os.path.normpath(path.parent / target))
            leads_to = self.target_of(place)
            if leads_to is None:
                return match[0]
            relative = os.path.relpath(leads_to, path.parent)
            return f"]({relative}{'#' + anchor if anchor else ''})"

        return re.sub(r"\]\(([^)\s]+)\)", link, text)

    def document(self, path):
        text = with_names(with_tabs(self.with_links((ROOT / path).read_text(), path)))
        if path == pathlib.Path("README.md"):
            self.write("index.md", text + self.navigation())
        else:
            self.write(path, text)

    def navigation(self):
        """One list for each section of docs/README.md: the pages in the order of their links."""
        text = (ROOT / "docs/README.md").read_text()
        parts = []
        for title, body in re.findall(r"^##+ (.*?)\n(.*?)(?=^##+ |\Z)", text, re.DOTALL | re.MULTILINE):
            entries = [os.path.normpath(f"docs/{link}") for link in re.findall(r"\]\(([^)#]+)\.md\)", body)]
            if title == "Contributing":
                entries.append("CHANGELOG")
            if entries:
                parts.append((title, list(dict.fromkeys(entries))))
        api = [
            f"{title} <api/{folder}/index>" for folder, title, _ in sorted(HEADERS, key=lambda each: each[1] == "C")
        ]
        parts.insert(-2, ("API", [*api, "Python <api/python/index>", "Index <genindex>"]))
        parts.insert(0, ("Overview", ["docs/README"]))
        return "".join(toctree(entries, f":caption: {title}") for title, entries in parts)

    def api(self, xml):
        read = cpp_api.Headers(xml)
        for folder, title, _ in HEADERS:
            headers = [(header, page) for header, page in self.headers.items() if page.parent.name == folder]
            rows = []
            for header, page in headers:
                about = re.match(r"(?://|/\*) (.*?)(?:\.\s|\.$|$|:$)", (ROOT / header).read_text(), re.MULTILINE)[1]
                rows.append(f"| [{included(header)}]({page.name}.rst) | {about} |\n")
                self.write(f"{page}.rst", read.page(included(header), "c" if folder == "c" else "cpp"))
            table = "| header | content |\n| --- | --- |\n" + "".join(rows)
            entries = toctree([page.name for _, page in headers], ":hidden:")
            self.write(f"api/{folder}/index.md", f"# {title}\n\n{ABOUT[folder]}\n\n{table}\n{entries}")
        for name, text in python_api.pages(ROOT / "driver/python/gicube"):
            self.write(f"api/python/{name}.rst", text)

    def files(self):
        for path in sorted(self.linked):
            if (ROOT / path).is_dir():
                inside = sorted(each for each in (ROOT / path).iterdir() if not each.name.startswith((".", "_")))
                for each in inside:
                    if each.is_file():
                        self.file(each.relative_to(ROOT))
                rows = [
                    f"- [{each.name}]({each.name}.md)\n" if each.is_file() else f"- {each.name}\n" for each in inside
                ]
                self.write(f"files/{path}/index.md", f"---\norphan: true\n---\n# {path}\n\n{''.join(rows)}")
            else:
                self.file(path)

    def file(self, path):
        language = LANGUAGES.get(path.suffix, "none")
        text = (ROOT / path).read_text()
        shown = table(text) if path.suffix == ".csv" else f"`````{{code-block}} {language}\n{text}\n`````\n"
        self.write(f"files/{path}.md", f"---\norphan: true\n---\n# {path}\n\n{shown}")


def table(text):
    """A table of figures as HTML, since Markdown would read its cells."""
    head, *rows = csv.reader(text.splitlines())
    lines = [(head, "th"), *((row, "td") for row in rows)]
    cells = ("".join(f"<{kind}>{html.escape(cell)}</{kind}>" for cell in row) for row, kind in lines)
    body = "".join(f"<tr>{row}</tr>\n" for row in cells)
    return f'<div class="table-wrapper container"><table class="docutils figures">\n{body}</table></div>\n'


def included(header):
    """A header as programs include it."""
    return re.sub(r".*?(?=gicube/)", "", re.sub(r".*/include/", "", str(header)))


def toctree(entries, *options):
    lines = "\n".join((":hidden:", *(option for option in options if option != ":hidden:")))
    return "\n```{toctree}\n" + lines + "\n\n" + "\n".join(entries) + "\n```\n"


def with_tabs(text):
    """Listings in several languages that follow each other become tabs."""
    names = {"cpp": "C++", "python": "Python"}
    fence = r"```(?:cpp|python)(?: [^\n]*)?\n(?:(?!```).*\n)*?```\n"

    def tabs(match):
        made = []
        for listing in re.findall(fence, match[0]):
            language = re.match(r"```(\w+)", listing)[1]
            made.append(f"`````{{tab}} {names[language]}\n{with_names(listing)}`````\n")
        languages = re.findall(r"^```(cpp|python)", match[0], re.MULTILINE)
        return "".join(made) if len(set(languages)) == len(languages) > 1 else match[0]

    return re.sub(rf"(?:^{fence}\n?)+", tabs, text, flags=re.MULTILINE)


def with_names(text):
    """Listings that name their file, as the first word behind the language, show that name."""
    return re.sub(
        r"^```(\w+) (\S+)\n((?:(?!```).*\n)*?)```$",
        r"````{code-block} \1\n:caption: \2\n\n\3````",
        text,
        flags=re.MULTILINE,
    )


def main(xml, out):
    stage = Stage(pathlib.Path(out))
    for path in documents():
        stage.document(path)
    for picture in (ROOT / "docs").rglob("*"):
        if picture.suffix in PICTURES:
            target = stage.out / picture.relative_to(ROOT)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(picture, target)
    stage.api(xml)
    stage.files()


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
