"""The tables of gicube-board --hardware-cost."""
import re
import subprocess
from types import SimpleNamespace

from studies.runs import RunFailed


class Refused(RunFailed):
    """The board refuses the configuration; the message is its own."""


def hardware_cost(board, words=()):
    """`items`: [name, formula, bits, text] of each memory and their totals; `parts`: [name, M transistors as a text];
    transistors, memory_bits and pins: sums over all parts. Raises Refused."""
    done = subprocess.run([board, *words, "--hardware-cost"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise Refused(done.stderr.strip())
    # Lines "NAME   FORMULA   BITS bit   3.0 Mb SRAM", and "  NAME   FORMULA   COUNT transistors", "NAME   1.8 M
    # transistors".
    items = re.findall(r"^(\S.*?)  +(\S.*?)? +(\d+) bit +(.+)$", done.stdout, re.MULTILINE)
    parts = re.findall(r"^(\S.*?)  +([\d.]+) M transistors$", done.stdout, re.MULTILINE)
    transistors = re.findall(r" (\d+) transistors$", done.stdout, re.MULTILINE)
    totals = [int(bits) for name, _, bits, _ in items if name.startswith("Total ")]
    pins = re.search(r" = (\d+) pins;", done.stdout)
    if not parts or not transistors or len(totals) != 2 or not pins:
        raise RunFailed(f"{board} --hardware-cost: no table")
    return SimpleNamespace(items=items, parts=parts, transistors=float(sum(map(int, transistors))),
                           memory_bits=float(sum(totals)),
                           pins=float(pins[1]))
