"""Sphinx's settings for the site; script/docs sets the environment."""

import os
import re

from docutils import nodes

project = "GI-Cube SDK"
version = os.environ["GICUBE_VERSION"]
extensions = ["myst_parser", "sphinx_copybutton", "sphinx_inline_tabs"]
root_doc = "index"
highlight_language = "none"  # a listing without a language is a command or an output

myst_heading_anchors = 4

html_theme = "furo"
html_title = f"GI-Cube SDK {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_copyright = html_show_sphinx = html_show_sourcelink = html_copy_source = False
html_domain_indices = False
html_theme_options = {"navigation_with_keys": True}
add_module_names = False
smartquotes = False  # they make a dash of an option


def _page_of(text, pages):
    """The page that a text names: docs/guide/plan.md, or gicube/board.h."""
    if text.endswith(".md"):
        return text[:-3] if text[:-3] in pages else None
    stem = re.sub(r"^gicube/|\.h$", "", text)
    places = [f"api/{stem}"] if stem.startswith("scene/") else [f"api/{folder}/{stem}" for folder in ("c", "cpp")]
    return next((place for place in places if place in pages), None)


def _link_named_pages(app, tree, docname):
    """Names of documents and headers in the text, as headers and docstrings cite them, become links."""
    name = re.compile(r"(docs/[\w/]+\.md|gicube/[\w/]+\.h)")
    for text in list(tree.findall(nodes.Text)):
        around = text.parent
        while around is not None and not isinstance(
            around, (nodes.reference, nodes.literal_block, nodes.title, nodes.raw)
        ):
            around = around.parent
        parts = name.split(text.astext())
        if around is not None or len(parts) == 1:
            continue
        made = []
        for part in parts:
            page = _page_of(part, app.env.found_docs) if name.fullmatch(part) else None
            if page and page != docname:
                where = app.builder.get_relative_uri(docname, page)
                made.append(nodes.reference("", part, refuri=where, internal=True))
            elif part:
                made.append(nodes.Text(part))
        index = text.parent.index(text)
        text.parent[index : index + 1] = made


def setup(app):
    app.connect("doctree-resolved", _link_named_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
