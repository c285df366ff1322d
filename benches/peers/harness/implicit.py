"""From formula to surface: time, bytes and normals at equal largest error."""

import json
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

from . import install
from .install import Missing, call
from .worker import Failure, Worker

# A run that takes longer in the search is not repeated.
LONG = 15.0


@dataclass
class Limits:
    # Bytes above those of the loaded program, and seconds of one run.
    memory: int
    seconds: float
    runs: int = 5


@dataclass
class Row:
    """What a program reached on a surface for a target."""

    peer: str
    surface: str
    target: float
    reached: bool
    # What vertices − edges + faces should be.
    euler: int = 0
    # Why not, if not.
    reason: str = ""
    # The last or best result: error, normal, bytes, …
    result: dict = field(default_factory=dict)
    # CPU seconds of the runs, and wall seconds.
    seconds: list = field(default_factory=list)
    wall: list = field(default_factory=list)
    memory: float = 0.0
    loading: float = 0.0

    def time(self):
        return median(self.seconds) if self.seconds else None


class Runner:
    """One program: its process, what it made so far, and how its results were measured."""

    def __init__(self, peer, limits):
        self.peer, self.limits = peer, limits
        self.command, self.environment = peer.prepare(), peer.environment()
        self.worker = None
        # Results by surface and parameter, or why there is none.
        self.known = {}
        self.reason = ""

    def start(self):
        return Worker(self.command, self.limits.memory, self.environment)

    def close(self):
        if self.worker:
            self.worker.close()
        self.worker = None

    def ask(self, surface, parameter, output="-"):
        if self.worker is None:
            self.worker = self.start()
        try:
            return self.worker.ask(surface.request(parameter, output), self.limits.seconds)
        except Failure:
            # What failed may have left anything behind.
            self.close()
            raise

    def attempt(self, surface, parameter):
        """A result with its measures; None, and a reason, if there is none."""
        key = (surface.name, parameter)
        if key not in self.known:
            with tempfile.TemporaryDirectory() as folder:
                try:
                    path = Path(folder, "result")
                    answer = self.ask(surface, parameter, path)
                    self.known[key] = answer | measure(surface, path) | {"parameter": parameter}
                except Failure as failure:
                    self.known[key] = f"{failure} at {self.peer.parameter} {parameter:.4g}"
        if isinstance(self.known[key], str):
            self.reason = self.known[key]
            return None
        return self.known[key]

    def best(self, surface):
        """The result with the least error so far."""
        results = [r for (name, _), r in self.known.items() if name == surface.name and not isinstance(r, str)]
        return min(results, key=lambda r: r["error"], default={})


def measure(surface, path):
    """Errors of a result, by the program that is the same for all."""
    program = install.measuring() / "peer-measure"
    try:
        text = call([program, surface.name, str(surface.diagonal), path], quiet=True)
    except Missing as reason:
        raise Failure(f"cannot be measured: {reason}") from None
    return json.loads(text)


def search(runner, surface, target, coarser):
    """The row of a target; `coarser` is that of a larger one, or None."""
    runner.reason = ""
    known = coarser.result if coarser and coarser.reached else None
    found = runner.peer.search.find(lambda p: runner.attempt(surface, p), target, known)
    row = Row(runner.peer.name, surface.name, target, found is not None, surface.euler)
    row.result = found or runner.best(surface)
    if not found:
        row.reason = runner.reason or "does not come nearer"
    return row


def time_rows(pairs, surface, limits):
    """Runs programs in turns."""
    for _ in range(limits.runs):
        for runner, row in pairs:
            if row.result["seconds"] >= LONG:
                continue
            try:
                answer = runner.ask(surface, row.result["parameter"])
            except Failure as failure:
                row.reason = str(failure)
                continue
            row.seconds.append(answer["seconds"])
            row.wall.append(answer["wall"])
    for _, row in pairs:
        if not row.seconds:
            row.seconds, row.wall = [row.result["seconds"]], [row.result["wall"]]


def memory_of(runner, row, surface):
    """Peak of one run in a process of its own, above what was in use when it had loaded."""
    try:
        with runner.start() as worker:
            row.loading = worker.cpu_seconds()
            before = worker.forget_peak()
            worker.ask(surface.request(row.result["parameter"]), runner.limits.seconds)
            row.memory = worker.peak() - before
    except Failure as failure:
        row.reason = row.reason or str(failure)


def compare(peers, surfaces, targets, limits, result, say, save):
    """Adds all rows to the result, and the programs that are missing with the reason; saves after every surface."""
    runners = []
    for peer in peers:
        try:
            runners.append(Runner(peer, limits))
        except Missing as reason:
            result["missing"][peer.name] = str(reason)
    for surface in surfaces:
        coarser = {}
        for target in sorted(targets, reverse=True):
            coarser = one_target(runners, surface, target, coarser, limits, say)
            result["rows"] += coarser.values()
        save()


def one_target(runners, surface, target, coarser, limits, say):
    """The rows by the name of the program; `coarser` has those of the target before."""
    rows, fresh = {}, []
    for runner in runners:
        name = runner.peer.name
        say(f"{surface.name} {target:.0e} {name}: search")
        row = rows[name] = search(runner, surface, target, coarser.get(name))
        runner.close()
        known = coarser.get(name)
        if known and known.result and known.result["parameter"] == row.result["parameter"]:
            # The same run as for the target before.
            row.seconds, row.wall, row.memory, row.loading = known.seconds, known.wall, known.memory, known.loading
        elif row.result:
            fresh.append((runner, row))
    time_rows(fresh, surface, limits)
    for runner, row in fresh:
        runner.close()
        memory_of(runner, row, surface)
    for row in rows.values():
        say(describe(row))
    return rows


def describe(row):
    if not row.result:
        return f"  {row.peer:18} no result: {row.reason}"
    r = row.result
    note = "" if row.reached else f"  NOT REACHED: {row.reason}"
    return (
        f"  {row.peer:18} {row.time():9.4f} s  {r['elements']:9.0f} elements  {r['bytes']:11.0f} B  error {r['error']:.2e}  "
        f"normals {r['normal']:6.2f}° ({r['normal_p99']:.2f}°)  {row.memory / 1e6:7.1f} MB  Euler {r['euler']}{note}"
    )
