"""Writes the list of what the Debian package gicube consists of and links (SPDX 2.3, JSON): its programs and libraries
with their SHA-256, each Debian package that they load, each whose headers are compiled into them, with version and
licence.

Usage: sbom.py BUILD_FOLDER GICUBE.deb FILE
"""

import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
from datetime import datetime, timezone
from pathlib import Path

NAMES = {  # of Debian's copyright files -> SPDX
    "apache-2.0": "Apache-2.0", "bsd-2-clause": "BSD-2-Clause", "bsd-3-clause": "BSD-3-Clause", "bsl-1.0": "BSL-1.0",
    "expat": "MIT", "mit": "MIT", "gpl-2+": "GPL-2.0-or-later", "gpl-3+": "GPL-3.0-or-later",
         "lgpl-2.1+": "LGPL-2.1-or-later",
    "zlib": "Zlib",
}  # fmt: skip


def said(*command, **more):
    return subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True, **more).stdout


def is_elf(file):
    return file.is_file() and not file.is_symlink() and file.open("rb").read(4) == b"\x7fELF"


def dynamic(file, tag):
    return set(re.findall(rf"{tag}\s+(\S+)", said("objdump", "-p", file)))


def loaded_from(names):
    """Where the loader's cache has these libraries."""
    found = {}
    for line in said("/sbin/ldconfig", "-p").splitlines():
        if match := re.match(r"\s+(\S+) \(.*x86-64.*\) => (\S+)", line):
            found.setdefault(match[1], match[2])
    missing = names - found.keys()
    if missing:
        sys.exit(f"sbom: expected installed libraries, got none for {' '.join(sorted(missing))}")
    return [os.path.realpath(found[name]) for name in sorted(names)]


def owners(files):
    """The Debian packages of files. Where /lib is a link to /usr/lib, packages may still name the former."""
    named = [*files, *(file.removeprefix("/usr") for file in files)]
    lines = subprocess.run(["dpkg-query", "--search", *named], capture_output=True, text=True).stdout.splitlines()
    return {package.split(":")[0] for line in lines for package in line.rsplit(": ", 1)[0].split(", ")}


def headers_of_product(build):
    """Headers of the system that objects of the product were compiled from."""
    counted, found = False, set()
    for line in said("ninja", "-C", build, "-t", "deps").splitlines():
        if line and not line.startswith(" "):
            # The Python package and gicube-mpi are others.
            counted = not line.startswith(("tests/", "driver/python/", "driver/cmake/CMakeFiles/gicube-mpi.dir/"))
        elif counted and line.strip().startswith("/usr/include/"):
            found.add(os.path.realpath(line.strip()))
    return sorted(found)


def facts(packages):
    form = "${Package}\t${Version}\t${Architecture}\t${source:Package}\t${Homepage}\n"
    rows = (line.split("\t") for line in said("dpkg-query", "-W", "-f", form, *packages).splitlines())
    return {row[0]: row[1:] for row in rows if row[0] in packages}


def licences(package):
    """The licence of a package as a whole (empty: its copyright file doesn't say so in a form to be read), and all
    names in it."""
    text = Path("/usr/share/doc", package, "copyright").read_text(encoding="utf-8", errors="replace")
    if not re.match(r"Format: *https?://www.debian.org/doc/packaging-manuals/copyright-format/1.0", text):
        return "", []
    whole, names = "", set()
    for paragraph in re.split(r"\n\s*\n", text):
        if licence := re.search(r"^License: *(.+)$", paragraph, re.MULTILINE):
            names.add(licence[1].strip())
            if re.search(r"^Files:\s*\*\s*$", paragraph, re.MULTILINE):
                whole = licence[1].strip()
    return whole, sorted(names)


def spdx_name(name):
    return NAMES.get(name.lower()) or "LicenseRef-debian-" + re.sub(r"[^A-Za-z0-9.-]+", "-", name)


def entry(package, fact):
    version, architecture, source, homepage = fact
    whole, names = licences(package)
    return ({
        "SPDXID": f"SPDXRef-{re.sub('[^A-Za-z0-9.-]', '-', package)}",
        "name": package,
        "versionInfo": version,
        "supplier": "Organization: Debian",
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "sourceInfo": f"Debian source package {source}",
        "licenseConcluded": "NOASSERTION",
        "licenseDeclared": spdx_name(whole) if whole else "NOASSERTION",
        "licenseComments": f"In /usr/share/doc/{package}/copyright: "
                           f"{', '.join(names) or 'no licence in machine readable form'}",
        "copyrightText": "NOASSERTION",
        **({"homepage": homepage} if homepage else {}),
        "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                          "referenceLocator": f"pkg:deb/debian/{package.replace('+', '%2B')}"
                                              f"@{version.replace('+', '%2B')}?arch={architecture}"}],
    })  # fmt: skip


def bill(build, deb):
    name, version = said("dpkg-deb", "-f", deb, "Package").strip(), said("dpkg-deb", "-f", deb, "Version").strip()
    with tempfile.TemporaryDirectory() as root:
        subprocess.run(["dpkg-deb", "-x", deb, root], check=True)
        elves = sorted(filter(is_elf, Path(root).rglob("*")))
        outside = set().union(*(dynamic(elf, "NEEDED") for elf in elves)) - set().union(*(dynamic(elf, "SONAME")
            for elf in elves))
        files = [(str(elf.relative_to(root)), elf.read_bytes()) for elf in elves]
    linked = owners(loaded_from(outside))
    known = facts(linked)
    sources = {fact[2] for fact in known.values()}
    # A source package whose library is loaded is listed by that library. The kernel's headers only provide numbers.
    compiled = {package: fact for package, fact in facts(owners(headers_of_product(build))).items()
                if fact[2] not in sources | {"linux"}}  # fmt: skip
    main = f"SPDXRef-{name}"
    relations = [("SPDXRef-DOCUMENT", "DESCRIBES", main)]
    listed = []
    for number, (path, data) in enumerate(files):
        listed.append({"SPDXID": f"SPDXRef-file-{number}", "fileName": f"./{path}", "licenseConcluded": "Apache-2.0",
                       "licenseInfoInFiles": ["NOASSERTION"], "copyrightText": "NOASSERTION", "fileTypes": ["BINARY"],
                       "checksums": [{"algorithm": kind, "checksumValue": hashlib.new(kind, data).hexdigest()}
                                     for kind in ("SHA1", "SHA256")]})  # fmt: skip
        relations.append((main, "CONTAINS", f"SPDXRef-file-{number}"))
    others = [entry(package, fact) for package, fact in sorted({**known, **compiled}.items())]
    relations += [(main, "DYNAMIC_LINK" if each["name"] in linked else "STATIC_LINK", each["SPDXID"])
                  for each in others]
    product = {
        "SPDXID": main, "name": name, "versionInfo": version, "downloadLocation": "NOASSERTION", "filesAnalyzed": False,
        "licenseConcluded": "NOASSERTION", "licenseDeclared": "Apache-2.0", "copyrightText": "NOASSERTION",
        "checksums": [{"algorithm": "SHA256", "checksumValue": hashlib.sha256(Path(deb).read_bytes()).hexdigest()}],
    }  # fmt: skip
    references = sorted({each["licenseDeclared"]
                         for each in others if each["licenseDeclared"].startswith("LicenseRef-")})
    made = int(os.environ.get("SOURCE_DATE_EPOCH", 0)) or int(Path(deb).stat().st_mtime)
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"{name}-{version}",
        "documentNamespace": f"https://spdx.org/spdxdocs/{name}-{version}-{product['checksums'][0]['checksumValue']}",
        "creationInfo": {"created": datetime.fromtimestamp(made, timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"),
                         "creators": ["Tool: gicube-sbom"]},
        "packages": [product, *others],
        "files": listed,
        "relationships": [dict(zip(("spdxElementId", "relationshipType", "relatedSpdxElement"), each))
                          for each in relations],
        "hasExtractedLicensingInfos": [
            {"licenseId": each, "name": each, "extractedText": "See the package's /usr/share/doc/NAME/copyright."}
            for each in references],
    }  # fmt: skip


if __name__ == "__main__":
    Path(sys.argv[3]).write_text(json.dumps(bill(sys.argv[1], sys.argv[2]), indent=1) + "\n", encoding="utf-8")
