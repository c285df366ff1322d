"""The command line."""

import argparse
import sys
import time

from . import implicit, patches
from .peers import PEERS
from .surfaces import SURFACES

GIGABYTE = 1 << 30


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--targets", type=float, nargs="+", default=[1e-3, 1e-4, 1e-5], help="largest errors")
    parser.add_argument("--surfaces", nargs="+", default=[s.name for s in SURFACES])
    parser.add_argument("--peers", nargs="+", help="words in the names of programs")
    parser.add_argument("--memory", type=float, default=16, help="GiB that a program may use")
    parser.add_argument("--limit", type=float, default=120, help="seconds that one run may take")
    parser.add_argument("--runs", type=int, default=5, help="runs whose median counts")
    parser.add_argument("--quick", action="store_true", help="a short run")
    return parser.parse_args()


def main():
    chosen = arguments()
    peers = [p for p in PEERS if not chosen.peers or any(word in p.name for word in chosen.peers)]
    surfaces = [s for s in SURFACES if s.name in chosen.surfaces]
    limits = implicit.Limits(int(chosen.memory * GIGABYTE), chosen.limit, chosen.runs)
    start = time.monotonic()

    def say(text):
        print(f"{time.monotonic() - start:7.1f} {text}", file=sys.stderr, flush=True)

    others = patches.all_rows(chosen.runs, chosen.quick, say)
    rows, missing = implicit.compare(peers, surfaces, chosen.targets, limits, say)
    return 0
