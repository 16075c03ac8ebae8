"""Compares a bill of materials (driver/cmake/sbom.py) with what ldd, readelf and dpkg say of the unpacked package, and
with docs/design/dependencies.csv.

Usage: check_bill.py BILL.json ROOT SOURCE_FOLDER
"""

import csv
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

TOOLCHAIN = {"glibc", "gcc-12"}  # of every program
faults = []


def said(*command, **more):
    return subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True, **more).stdout


def expect_equal(what, expected, got):
    if expected != got:
        faults.append(f"{what}: missing {sorted(expected - got)}, too many {sorted(got - expected)}")


def sources(packages):
    if not packages:
        return {}
    form = "${Package} ${source:Package}\n"
    answer = subprocess.run(["dpkg-query", "-W", "-f", form, *packages], stdout=subprocess.PIPE, text=True).stdout
    return dict(line.split() for line in answer.splitlines())


def of_metapackages(names):
    """libboost-dev is of boost-defaults, and depends on that of boost1.74."""
    depends = said("dpkg-query", "-W", "-f", "${Depends}\n", *names)
    return set(sources(re.findall(r"libboost[\w.+-]+-dev", depends)).values())


bill = json.loads(Path(sys.argv[1]).read_text())
root, tree = Path(sys.argv[2]), Path(sys.argv[3])
packages = {each["SPDXID"]: each for each in bill["packages"]}
# noqa: E731
related = lambda kind: {packages[each["relatedSpdxElement"]]["name"]
                        for each in bill["relationships"] if each["relationshipType"] == kind}

# Every program and library, byte by byte.
elves = [file for file in root.rglob("*") if file.is_file() and not file.is_symlink()
         and file.read_bytes()[:4] == b"\x7fELF"]
expect_equal("files", {"./" + str(file.relative_to(root)) for file in elves},
             {each["fileName"] for each in bill["files"]})
for each in bill["files"]:
    sums = {one["algorithm"]: one["checksumValue"] for one in each["checksums"]}
    if hashlib.sha256((root / each["fileName"]).read_bytes()).hexdigest() != sums["SHA256"]:
        faults.append(f"{each['fileName']}: another SHA-256")

# Every library that they name, where ldd finds it.
paths = set()
for elf in elves:
    names = set(re.findall(r"\(NEEDED\).*\[(.*)\]", said("readelf", "-d", elf)))
    found = dict(re.findall(r"^\s*(\S+) => (\S+)",
                            said("ldd", elf, env={**os.environ, "LD_LIBRARY_PATH": str(root / "usr/lib")}),
                            re.MULTILINE))
    paths |= {os.path.realpath(found[name]) for name in names if name in found
              and not found[name].startswith(str(root))}
owner = {line.split(":")[0] for path in paths
         for line in said("dpkg", "-S", "*" + path.removeprefix("/usr")).splitlines() if line.endswith(path)
         or line.endswith(" " + path.removeprefix("/usr"))}  # fmt: skip
# ldd names the loader, of libc6, in another form
expect_equal("packages linked", owner | {"libc6"}, related("DYNAMIC_LINK"))

# Versions, and licences of all packages but the toolchain's, whose files are no machine readable ones.
used = related("DYNAMIC_LINK") | related("STATIC_LINK")
source = sources(used)
expect_equal("packages installed", set(source), used)
for each in packages.values():
    if each["name"] not in used:
        continue
    version = said("dpkg-query", "-W", "-f", "${Version}\n", each["name"]).split()
    if each["versionInfo"] not in version:
        faults.append(f"{each['name']}: expected version {version}, got {each['versionInfo']}")
    declared = each["licenseDeclared"]
    if "no licence" in each["licenseComments"] and source[each["name"]] not in TOOLCHAIN:
        faults.append(f"{each['name']}: no licence")
    if declared.startswith("LicenseRef-") and declared not in {one["licenseId"]
        for one in bill["hasExtractedLicensingInfos"]}:
        faults.append(f"{each['name']}: {declared} is not explained")

# What is used has its row in the table, and what script/packages.txt calls a library of the product is used.
with (tree / "docs/design/dependencies.csv").open(newline="") as table:
    rows = {name for row in list(csv.reader(table))[1:] for name in row[0].split(", ")}
sections = re.findall(r"# Libraries of [^\n]*\n(.*?)\n#", (tree / "script/packages.txt").read_text(), re.DOTALL)
libraries = sources({line.split()[0] for section in sections for line in section.splitlines()})
development = sources({name for name in rows if name.endswith("-dev")})
if missing := set(source.values()) - set(development.values()) - of_metapackages(development) - TOOLCHAIN:
    faults.append(f"docs/design/dependencies.csv: no row for {sorted(missing)}")
for name, its_source in libraries.items():
    if its_source not in source.values() and not of_metapackages([name]) & set(source.values()):
        faults.append(f"script/packages.txt: {name} is not in the bill")

print("\n".join(faults) or f"bill of materials: {len(elves)} files and {len(used)} packages are as they should be")
sys.exit(bool(faults))
