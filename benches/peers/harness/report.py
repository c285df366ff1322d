"""The tables of docs/benchmarks.md, and all figures as JSON."""

import json
import math
from dataclasses import asdict

OURS = ["isopatch quick", "isopatch full"]

HEAD = """# Benchmarks beside other programs

This page is generated: `benches/peers/run` installs the other programs, runs everything and writes it. Change nothing by hand.

{machine}

## How it is measured
- Every program is a process that has loaded before the clock starts, with one thread. Times are CPU seconds, the median of
  {runs} runs in turns with the others (one run where it takes over {long:.0f} s, marked ¹). *Loading* is what start and imports cost.
- *Memory* is the peak of a run in a new process, less what the process had when it had loaded.
- The surfaces are the six of Tong & Kim 2009, in the same boxes for all. Programs that want a grid get it from compiled
  code (vectorised, single precision stored), and that time counts; fidget makes machine code itself; CGAL calls compiled code.
  isopatch gets the formula as text, and parses it on the clock.
- *Error* is the largest distance from the result to the true surface, over samples inside triangles (7 each) and on patches
  (91 each), each with its nearest point by Newton's method, relative to the diagonal of the box around the surface. Results with over
  {samples} samples are sampled on evenly spread elements. One program measures all (`benches/peers/measure`); it shares no code with isopatch.
- The resolution (or tolerance, or depth) of a program is searched such that its error just meets the target; the search
  does not count. isopatch is not searched: it is asked for the target, as a user would, and its results often are better than that.
- *Normals*: the largest angle between the normal of a triangle or patch and that of the true surface, and the 99th percentile.
  Triangles lower than 3e-6 of the diagonal don't count.
- *Bytes*: for meshes 12 a vertex and 12 a triangle; for isopatch the control points, each stored once, 24 bytes, and 12 a
  face. In brackets the native file.
- *Not reached*: no result within {limit:.0f} s a run and {memory:.0f} GiB; the row shows the best that there was.
- What takes milliseconds (STEP, refined meshes) is run nine times at least.
- Two threads against two copies: medians of the ratios of at least nine runs one after the other, of wall time. Cores are so
  far *apart* as it takes a cache line from one to the other and back; where a machine is shared, that changes while it runs.
- Time for each patch: the sizes are made in turns, the small ones several times in each, and medians count.
"""


def geometric_mean(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def size(count):
    for unit, scale in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= scale:
            return f"{count / scale:.3g} {unit}"
    return f"{count:.0f} B"


def seconds(value):
    return f"{value:.3g} s" if value >= 1 else f"{1e3 * value:.3g} ms"


def degrees(angle):
    return f"{angle:.3g}°"


def power(target):
    return f"{target:.0e}".replace("e-0", "e-")


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def machine_text(machine, versions, missing):
    lines = [
        f"Measured on {machine['date']} with isopatch {machine['isopatch']}: {machine['cores']} × {machine['cpu']} "
        f"({', '.join(machine['flags'])}; cache {machine['cache']}), {size(machine['memory'])} of memory, {machine['system']}, "
        f"{machine['rustc']}, {machine['compiler']}, Python {machine['python']}. Load average at the start: {machine['load']:.1f}.",
        "",
        table(["program", "version", "licence (none is shipped)"], versions),
    ]
    if missing:
        lines += ["", "Not installed, and why:", ""]
        lines += [f"- {name}: {reason}" for name, reason in missing.items()]
    return "\n".join(lines)


def row_cells(row):
    if not row.result:
        return [row.surface, row.peer, f"no result: {row.reason}"] + [""] * 7
    r, once = row.result, "¹" if len(row.seconds) == 1 else ""
    file = f" ({size(r['file'])})" if r["file"] else ""
    return [
        row.surface,
        row.peer,
        "" if row.reached else f"**not reached**: {row.reason}",
        f"{r['error']:.2e}",
        seconds(row.time()) + once,
        size(r["bytes"]) + file,
        f"{r['elements']:,.0f}",
        f"{degrees(r['normal'])} ({degrees(r['normal_p99'])})",
        size(max(row.memory, 0)),
        str(r["euler"]) + ("" if r["euler"] == row.euler else " **wrong**"),
    ]


def by_target(rows, target):
    names = ["surface", "program", "", "error", "time", "bytes", "elements", "normals", "memory", "Euler"]
    cells = [row_cells(row) for row in rows if row.target == target]
    return f"### Largest error {power(target)}\n\n" + table(names, cells)


def reached(rows, peer, target):
    return {row.surface: row for row in rows if row.peer == peer and row.target == target and row.reached}


def ratios(rows, ours, peer, target):
    """Geometric means of how many times as fast and as small isopatch is, where both reach the target."""
    us, them = reached(rows, ours, target), reached(rows, peer, target)
    common = [name for name in us if name in them]
    if not common:
        return None
    return {
        "surfaces": len(common),
        "time": geometric_mean([them[s].time() / us[s].time() for s in common]),
        "bytes": geometric_mean([them[s].result["bytes"] / us[s].result["bytes"] for s in common]),
    }


def summary(rows, targets):
    peers = list(dict.fromkeys(row.peer for row in rows))
    surfaces = list(dict.fromkeys(row.surface for row in rows))
    cells = []
    for target in targets:
        for peer in peers:
            there = reached(rows, peer, target)
            cell = [power(target), peer, f"{len(there)} of {len(surfaces)}"]
            if there:
                values = there.values()
                cell += [
                    seconds(geometric_mean([row.time() for row in values])),
                    size(geometric_mean([row.result["bytes"] for row in values])),
                    degrees(max(row.result['normal'] for row in values)),
                    size(max(max(row.memory for row in values), 0)),
                ]
            else:
                cell += [""] * 4
            for ours in OURS:
                r = None if peer in OURS else ratios(rows, ours, peer, target)
                cell.append(f"{r['time']:.3g} × / {r['bytes']:.3g} ×" if r else "")
            cells.append(cell)
    head = ["error", "program", "reached", "time", "bytes", "normals", "memory"]
    head += [f"{ours}: times as fast / as small" for ours in OURS]
    return (
        "## From formula to surface: sums\n\nGeometric means of times and bytes over the surfaces that a program reached; the "
        "largest normal error and memory of them. The last columns compare on the surfaces that both reached; under 1 isopatch "
        "is slower or larger.\n\n" + table(head, cells)
    )


def losses(rows, targets, figures):
    """Where isopatch is slower or larger."""
    lines = []
    for target in targets:
        for peer in dict.fromkeys(row.peer for row in rows if row.peer not in OURS):
            for ours in OURS:
                r = ratios(rows, ours, peer, target)
                if r and r["time"] < 1:
                    lines.append(f"{ours} is {1 / r['time']:.3g} times as slow as {peer} at {power(target)}.")
                if r and r["bytes"] < 1:
                    lines.append(f"{ours} is {1 / r['bytes']:.3g} times as large as {peer} at {power(target)}.")
    for row in rows:
        if row.peer in OURS and not row.reached:
            lines.append(f"{row.peer} does not reach {power(row.target)} on {row.surface}: {row.reason}.")
    for what in dict.fromkeys(f.what for f in figures):
        same = [f for f in figures if f.what == what and not f.missing]
        ours = [f for f in same if f.who.startswith("isopatch")]
        for us in ours:
            for them in same:
                if them in ours:
                    continue
                better = us.value / them.value if "second" in us.unit or us.unit == "MB/s" else them.value / us.value
                if better < 1:
                    lines.append(f"{what}: {us.who} is {1 / better:.3g} times as slow as {them.who}.")
    text = "\n".join(f"- {line}" for line in lines) or "Nowhere in these tables."
    return "## Where isopatch loses\n\n" + text


def own_best(rows, peer="fidget"):
    """A program that stops short of small errors: its time to its own best one beside isopatch's to 1e-4."""
    cells = []
    for surface in dict.fromkeys(row.surface for row in rows):
        theirs = [r for r in rows if r.peer == peer and r.surface == surface and r.result]
        if not theirs:
            continue
        best = min(theirs, key=lambda r: r.result["error"])
        cell = [surface, f"{best.result['error']:.2e}", seconds(best.time())]
        for ours in OURS:
            # The largest error asked of isopatch that is not above the other's.
            fine = [r for r in rows if r.peer == ours and r.surface == surface and r.reached]
            fine = [r for r in fine if r.result["error"] <= best.result["error"]]
            us = min(fine, key=lambda r: r.time(), default=None)
            cell.append(f"{seconds(us.time())} ({best.time() / us.time():.3g} ×)" if us else "not so near")
        cells.append(cell)
    if not cells:
        return ""
    head = ["surface", f"best error of {peer}", "its time", *(f"{ours} to that or less" for ours in OURS)]
    return f"## {peer} to its own best error\n\n" + table(head, cells)


def loading(rows):
    cells = []
    for peer in dict.fromkeys(row.peer for row in rows):
        values = [row.loading for row in rows if row.peer == peer and row.result]
        if values:
            cells.append([peer, seconds(sorted(values)[len(values) // 2])])
    return "## Loading\n\n" + table(["program", "CPU seconds until it is ready"], cells)


def others(figures):
    parts = ["## Patches, meshes, STEP, threads"]
    for what in dict.fromkeys(f.what for f in figures):
        cells = []
        for f in figures:
            if f.what == what:
                value = f"missing: {f.missing}" if f.missing else f"{f.value:.4g} {f.unit}"
                cells.append([f.who, value, f.note])
        parts.append(f"**{what[0].upper()}{what[1:]}**\n\n" + table(["", "", ""], cells))
    return "\n\n".join(parts)


def markdown(result):
    rows, figures, limits = result["rows"], result["figures"], result["limits"]
    targets = sorted({row.target for row in rows}, reverse=True)
    machine = machine_text(result["machine"], result["versions"], result["missing"])
    text = HEAD.format(
        machine=machine,
        runs=limits.runs,
        limit=limits.seconds,
        memory=limits.memory / (1 << 30),
        long=result["long"],
        samples="6 million",
    )
    parts = [text]
    if rows:
        parts += [summary(rows, targets)]
    parts += [losses(rows, targets, figures)]
    parts += [others(figures)] if figures else []
    if rows:
        parts += [own_best(rows), loading(rows), "## From formula to surface: every row"]
        parts += [by_target(rows, target) for target in targets]
    return "\n\n".join(part.strip() for part in parts if part) + "\n"


def as_json(result):
    plain = dict(result)
    plain["rows"] = [asdict(row) for row in result["rows"]]
    plain["figures"] = [asdict(figure) for figure in result["figures"]]
    plain["limits"] = asdict(result["limits"])
    return json.dumps(plain, indent=1, allow_nan=False) + "\n"
