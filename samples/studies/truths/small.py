"""The small version of the truths: prints a line for each value and the number of values that hold. Exit code 1: fewer
than 95% of the stochastic values hold, or a value without noise does not."""
import argparse
import os
import sys

from studies import truths
from studies.points import BIN


def chosen(words):
    """Cases of the small version; with words, all cases with one of them in their names."""
    cases = truths.all_cases()
    return [case for case in cases if any(word in case.name for word in words)] if words else [case for case in cases
        if case.small is not None]


def verdict(values):
    """Shares of stochastic and of other values that hold; 1 without values."""
    parts = [[holds for *_, limit, _, holds in values if (limit > 0) == exact] for exact in (False, True)]
    return [sum(part) / len(part) if part else 1.0 for part in parts]


def main():
    parser = argparse.ArgumentParser(prog="script/truths --small", description=__doc__)
    parser.add_argument("words", nargs="*", metavar="CASE",
                        help="run all cases with one of these words in their names, with the page's settings")
    parser.add_argument("--board", default="emu:", metavar="URI", help="URI of the board (%(default)s)")
    given = parser.parse_args()
    truths.uri = given.board
    os.environ.setdefault("GICUBE_BOARD", str(BIN / "gicube-board"))
    values = []
    for case in chosen(given.words):
        found = truths.measured(case, {} if given.words else case.small)
        print(f"{case.name}: {found['ms']:.4g} simulated ms, {found['seconds']:.2g} s")
        for quantity, truth, _, value, error, limit, off, holds in found["values"]:
            distance = f"{100 * off:.3g}%" if limit else f"{off:.2f} standard errors"
            print(f"  {quantity}: {truth:.6g}, board {value:.6g} +- {error:.2g}, off by {distance}"
                  + (1 - holds) * "  <--")
        values += found["values"]
    stochastic, others = verdict(values)
    print(f"{len(values)} values: {100 * stochastic:.1f}% of the stochastic ones within three standard errors, "
          f"{100 * others:.1f}% of the others within their limits")
    sys.exit(stochastic < 0.95 or others < 1)


if __name__ == "__main__":
    main()
