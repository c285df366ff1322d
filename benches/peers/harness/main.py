"""Compares isopatch with other programs on this machine, and writes docs/benchmarks.md and docs/benchmarks.json."""

import argparse
import sys
import time
from pathlib import Path

from . import implicit, install, machine, patches, report
from .install import Missing
from .peers import PEERS
from .surfaces import SURFACES

GIB = 1 << 30
# What --quick leaves.
QUICK_TARGETS, QUICK_SURFACES, QUICK_RUNS = [1e-3, 1e-4], ["torus", "dodeca"], 1


def arguments():
    parser = argparse.ArgumentParser(prog="benches/peers/run", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="two surfaces, two errors, one run of each")
    parser.add_argument("--targets", type=float, nargs="+", metavar="E", help="largest errors [1e-3 1e-4 1e-5]")
    parser.add_argument("--surfaces", nargs="*", metavar="NAME", help="names of surfaces [all six]")
    parser.add_argument("--peers", nargs="+", metavar="WORD", help="words in the names of programs [all]")
    parser.add_argument("--runs", type=int, help="runs whose median counts [5]")
    parser.add_argument("--memory", type=float, default=16, metavar="GIB", help="that a program may use [16]")
    parser.add_argument("--limit", type=float, default=120, metavar="S", help="seconds that a run may take [120]")
    parser.add_argument("--skip-patches", action="store_true", help="only the rows from formulas")
    folder = install.REPOSITORY / "docs"
    parser.add_argument("--output", type=Path, default=folder, metavar="DIR", help="folder of the results [docs]")
    chosen = parser.parse_args()
    every = [s.name for s in SURFACES]
    chosen.targets = chosen.targets or (QUICK_TARGETS if chosen.quick else [1e-3, 1e-4, 1e-5])
    chosen.runs = chosen.runs or (QUICK_RUNS if chosen.quick else 5)
    if chosen.surfaces is None:
        chosen.surfaces = QUICK_SURFACES if chosen.quick else every
    return chosen


def versions(peers):
    """Rows of name, version and licence of what could be installed, and of the rest nothing."""
    rows = []
    for peer in peers:
        try:
            rows.append([peer.name, peer.version(), peer.licence])
        except Missing:
            continue
    return rows


def main():
    chosen = arguments()
    peers = [p for p in PEERS if not chosen.peers or any(word in p.name for word in chosen.peers)]
    surfaces = [s for s in SURFACES if s.name in chosen.surfaces]
    limits = implicit.Limits(int(chosen.memory * GIB), chosen.limit, chosen.runs)
    start = time.monotonic()

    def say(text):
        print(f"{time.monotonic() - start:7.1f} {text}", file=sys.stderr, flush=True)

    result = {"machine": machine.describe(), "limits": limits, "long": implicit.LONG, "rows": [], "missing": {}}
    result["figures"] = [] if chosen.skip_patches else patches.all_rows(chosen.runs, chosen.quick, say)

    def save():
        result["versions"] = versions([p for p in peers if p.name not in result["missing"]])
        result["versions"] += [] if chosen.skip_patches else versions(patches.PROGRAMS)
        chosen.output.mkdir(parents=True, exist_ok=True)
        (chosen.output / "benchmarks.md").write_text(report.markdown(result))
        (chosen.output / "benchmarks.json").write_text(report.as_json(result))

    # After every surface, so that a run that is stopped leaves what it has.
    implicit.compare(peers, surfaces, chosen.targets, limits, result, say, save)
    save()
    print(report.markdown(result))
    return 0
