"""Checks that a site of script/docs is whole: each link leads to a page and an anchor, each page can be reached from
the first one, and nothing is loaded from elsewhere.

Usage: check.py SITE
"""

import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.anchors |= {given[name] for name in ("id", "name") if given.get(name)}
        target = given.get("href") if tag == "a" else given.get("action") if tag == "form" else None
        if target:
            self.links.append(target)
        source = given.get("src") or (given.get("href") if tag == "link" else None)
        if source:
            self.loaded.append(source)


def faults_of(site):
    pages = {path.resolve(): Page(path) for path in site.rglob("*.html")}
    reached, next_ones, found = set(), [(site / "index.html").resolve()], []
    while next_ones:
        path = next_ones.pop()
        if path in reached:
            continue
        reached.add(path)
        for link in pages[path].links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme in ("http", "https", "mailto"):
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if target in pages:
                next_ones.append(target)
                if parts.fragment and urllib.parse.unquote(parts.fragment) not in pages[target].anchors:
                    found.append(f"{path.relative_to(site)}: no anchor {link}")
            elif not target.exists():
                found.append(f"{path.relative_to(site)}: no page {link}")
    found += [f"{path.relative_to(site)}: no page links to it" for path in pages if path not in reached]
    for path, page in pages.items():
        for source in page.loaded:
            parts = urllib.parse.urlsplit(source)
            if parts.scheme == "data":
                continue
            if parts.netloc or not (path.parent / urllib.parse.unquote(parts.path)).exists():
                found.append(f"{path.relative_to(site)}: loads {source}")
    return len(pages), sum(len(page.links) for page in pages.values()), found


def main(folder):
    pages, links, faults = faults_of(pathlib.Path(folder).resolve())
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"{pages} pages, {links} links, {len(faults)} faults")
    return 1 if faults or pages == 0 else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
