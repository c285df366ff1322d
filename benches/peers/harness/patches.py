"""Rows beside those of the formulas: points of patches, smooth meshes, STEP, threads, and time per patch."""

import filecmp
import json
import os
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

from . import install, sphere
from .install import Missing
from .peers import Peer
from .surfaces import SURFACES
from .worker import ONE_THREAD, Failure, Worker

# Patches of the torus whose points are evaluated, and intervals along the edge of each.
PATCHES, RESOLUTION = 10_000, 8
# Refinement of the 320 triangles: a few points, and many.
REFINED = [8, 64]
# Patches of the torus for the time of each.
SIZES = [1_000, 10_000, 50_000, 200_000]
PATCHES_IN_A_TURN = 10_000
LOAD = 600
# Seconds from which a stage is one whose threads count, and how its time is named in answers.
LONG_STAGE, STAGE = 0.1, "stage "
# Runs with two threads and of what takes milliseconds, at least: they are short, and scatter.
SHORT_RUNS = 9
# Bytes of a .glb before its JSON: the header of the file and that of the chunk.
GLB_HEADER = 20

PROGRAMS = [
    Peer("OpenSubdiv", "Apache-2.0 (modified)", version=lambda: install.debian("libosd-dev")),
    Peer("PN triangles", "MIT OR Apache-2.0", version=lambda: "written for this comparison"),
    Peer("manifold3d", "Apache-2.0", version=lambda: install.python_package("manifold3d")),
    Peer("OpenCASCADE (cadquery-ocp)", "LGPL-2.1 with exception", version=lambda: install.python_package("cadquery-ocp")),
]


@dataclass
class Figure:
    """Something measured; `missing` says why it was not."""

    what: str
    who: str
    value: float | None = None
    unit: str = ""
    note: str = ""
    missing: str = ""
    values: dict = field(default_factory=dict)


def patches_program():
    return [install.isopatch_example("peer_patches")]


def in_turns(programs, runs):
    """Medians of the figures of programs, of `(who, command, words)`, asked in turns; a failure is text."""
    workers, answers = {}, {}
    for who, command, words in programs:
        try:
            workers[who] = (Worker(command(), 8 << 30), words)
            answers[who] = []
        except (Missing, Failure) as reason:
            answers[who] = str(reason)
    for _ in range(runs):
        for who, (worker, words) in workers.items():
            if isinstance(answers[who], str):
                continue
            try:
                answers[who].append(worker.ask(words, LOAD))
            except Failure as reason:
                answers[who] = str(reason)
    for worker, _ in workers.values():
        worker.close()
    return {
        who: a if isinstance(a, str) else {key: median(x[key] for x in a) for key in a[0]}
        for who, a in answers.items()
    }


def figures(what, programs, runs, value, unit):
    """A row for each program; `value` makes the number from its figures."""
    rows = []
    for who, answer in in_turns(programs, runs).items():
        if isinstance(answer, str):
            rows.append(Figure(what, who, missing=answer))
        else:
            rows.append(Figure(what, who, value(answer), unit, split(answer), values=answer))
    return rows


def split(answer):
    """Where the time of a row went, if the program says so."""
    if "fit" not in answer:
        return ""
    return f"fit or sewing {1e3 * answer['fit']:.3g} ms, writing {1e3 * answer['write']:.3g} ms, {answer['bytes'] / 1e6:.2g} MB"


def opensubdiv():
    install.debian("libosd-dev")
    return install.cxx("opensubdiv_points.cpp", "-losdCPU")


def pn_triangles():
    return [install.measuring() / "peer-pn-triangles"]


def points(runs):
    def rate(answer):
        return answer["points"] / answer["seconds"] / 1e6

    ours = ["grid", PATCHES, RESOLUTION]
    theirs = ["grid", RESOLUTION]
    unit = "million points with normals a second"
    return figures(
        "spline points on a fixed grid",
        [
            ("isopatch", patches_program, ours),
            ("OpenSubdiv limit stencils", opensubdiv, theirs),
            ("PN triangles (not G1)", pn_triangles, theirs),
        ],
        runs,
        rate,
        unit,
    ) + figures(
        "spline points anywhere",
        [
            ("isopatch", patches_program, ["anywhere", PATCHES, RESOLUTION]),
            ("OpenSubdiv Bfr", opensubdiv, ["anywhere", RESOLUTION]),
        ],
        runs,
        rate,
        unit,
    )


def step(runs, folder):
    mesh = Path(folder, "sphere.off")
    sphere.write_off(mesh, *sphere.icosphere(2))
    rows = figures(
        "320 triangles to STEP",
        [
            ("isopatch (G1 patches)", patches_program, ["step", mesh]),
            (
                "OpenCASCADE (flat faces, sewn)",
                lambda: install.python_peer("opencascade_sewing.py", "cadquery-ocp"),
                ["step", mesh],
            ),
        ],
        max(runs, SHORT_RUNS),
        lambda answer: 1e3 * answer["seconds"],
        "ms",
    )
    return rows + figures(
        "STEP writer",
        [("isopatch", patches_program, ["write", PATCHES])],
        runs,
        lambda answer: answer["bytes"] / answer["seconds"] / 1e6,
        "MB/s",
    )


def whole_process(command):
    """CPU and wall seconds, and the peak of memory, of a program from start to end, and what it printed."""
    start = time.perf_counter()
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | ONE_THREAD
    )
    # What the programs print is short, so that neither pipe fills.
    text, complaint = process.stdout.read(), process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise Failure((complaint.strip() or "fails").splitlines()[-1])
    return {
        "seconds": usage.ru_utime + usage.ru_stime,
        "wall": time.perf_counter() - start,
        "memory": usage.ru_maxrss * 1024,
    }, text


def refine(runs, folder):
    """From a mesh file to a file of refined points with normals: single precision and triangles, from all."""
    mesh = Path(folder, "sphere.off")
    sphere.write_off(mesh, *sphere.icosphere(2))
    rows = []
    for n in REFINED:
        out = Path(folder, f"refined-{n}")
        commands = {
            "isopatch A-patches": lambda n=n, out=out: [
                install.isopatch_binary(), "fit", mesh, "--quiet", "--threads", "1", "--resolution", str(n),
                "-o", f"{out}.glb",
            ],
            "isopatch spline": lambda n=n, out=out: [
                install.isopatch_binary(), "fit", mesh, "--quiet", "--threads", "1", "--resolution", str(n),
                "--method", "spline", "-o", f"{out}.glb",
            ],
            "manifold3d smooth and refine": lambda n=n, out=out: [
                *install.python_peer("manifold_smooth.py", "manifold3d"), mesh, str(n), f"{out}.bin",
            ],
        }  # fmt: skip
        what = f"320 triangles to points with normals, every edge in {n}, whole process"
        rows += refined_rows(what, commands, max(runs, SHORT_RUNS))
    return rows


def refined_rows(what, commands, runs):
    answers = {who: [] for who in commands}
    missing = {}
    for _ in range(runs):
        for who, command in commands.items():
            if who in missing:
                continue
            try:
                words = command()
                # What it takes to destroy a former file is none of theirs.
                Path(words[-1]).unlink(missing_ok=True)
                answers[who].append(whole_process(words))
            except (Missing, Failure) as reason:
                missing[who] = str(reason)
    rows = []
    for who, runs_of in answers.items():
        if who in missing:
            rows.append(Figure(what, who, missing=missing[who]))
            continue
        values = {key: median(run[key] for run, _ in runs_of) for key in runs_of[0][0]}
        printed = runs_of[0][1].strip()
        values |= {k: float(v) for k, v in (w.split("=") for w in printed.split("\t") if "=" in w)}
        values["points"] = values.get("points") or vertices_of_glb(commands[who]()[-1])
        note = f"{values['points']:,.0f} points"
        note += f"; {1e3 * values['loading']:.0f} ms of it imports" if "loading" in values else ""
        rows.append(Figure(what, who, 1e3 * values["seconds"], "ms", note, values=values))
    return rows


def vertices_of_glb(path):
    with open(path, "rb") as file:
        header = file.read(GLB_HEADER)
        scene = json.loads(file.read(int.from_bytes(header[12:16], "little")))
    return scene["accessors"][0]["count"]


def threads(runs, folder, tolerance=1e-4):
    """Two threads against two copies with one thread each: jobs a second, of wall time; whole runs, and their long stages.

    How far the cores are apart is measured before each run, as it makes much of the difference.
    """
    rows = []
    memory = 8 << 30
    program = install.isopatch_example("peer_surfaces")
    for surface in SURFACES:
        with (
            Worker([program, "full", "2"], memory) as two,
            Worker([program, "full"], memory) as first,
            Worker([program, "full"], memory) as second,
            Worker([install.measuring() / "peer-cores"], memory) as cores,
        ):
            files = [Path(folder, name) for name in ("two", "one")]
            two.ask(surface.request(tolerance, files[0]), LOAD)
            alone = first.ask(surface.request(tolerance, files[1]), LOAD)
            same = filecmp.cmp(*files, shallow=False)
            shared, copies, apart = [], [], []
            for _ in range(max(runs, SHORT_RUNS)):
                apart.append(cores.ask(["there and back"], LOAD)["nanoseconds"])
                shared.append(two.ask(surface.request(tolerance), LOAD))
                start = time.perf_counter()
                for worker in (first, second):
                    worker.send(surface.request(tolerance))
                answers = [worker.receive(LOAD) for worker in (first, second)]
                both = {key: sum(answer[key] for answer in answers) / 2 for key in answers[0]}
                copies.append(both | {"wall": time.perf_counter() - start})
        note = f"{'same bytes' if same else 'OTHER BYTES'}; cores {median(apart):.0f} ns apart ({min(apart):.0f} to {max(apart):.0f})"
        for key in ["wall"] + [key for key in alone if key.startswith(STAGE) and alone[key] > LONG_STAGE]:
            here, there = [run[key] for run in shared], [run[key] for run in copies]
            # Of runs one after the other: the machine changes in between.
            ratio = median(copies / (2 * two) for two, copies in zip(here, there))
            what = f"two threads against two copies, {'whole runs' if key == 'wall' else f'stages over {1e3 * LONG_STAGE:.0f} ms'}"
            who = surface.name if key == "wall" else f"{surface.name}: {key.removeprefix(STAGE)}"
            values = {"two_threads": here, "two_copies": there, "apart": apart}
            rows.append(
                Figure(what, who, ratio, "×", f"{1e3 * median(here):.0f} ms with two threads; {note}", values=values)
            )
    # Whole runs first.
    return sorted(rows, key=lambda row: "whole" not in row.what)


def per_patch(runs, sizes):
    """Sizes in turns, small ones several times in each, so that all see the machine in the same moods."""
    what = "time for each patch of a torus"
    answers = {size: [] for size in sizes}
    missing = {}
    with Worker(patches_program(), 16 << 30) as worker:
        for _ in range(runs):
            for size in sizes:
                if size in missing:
                    continue
                try:
                    repeats = max(1, PATCHES_IN_A_TURN // size)
                    answers[size] += [worker.ask(["patches", size], LOAD) for _ in range(repeats)]
                except Failure as reason:
                    missing[size] = str(reason)
    rows = [Figure(what, f"{size:,} asked", missing=reason) for size, reason in missing.items()]
    for size in sizes:
        if size in missing:
            continue
        answer = {key: median(a[key] for a in answers[size]) for key in answers[size][0]}
        value = 1e6 * answer["seconds"] / answer["patches"]
        rows.append(Figure(what, f"{answer['patches']:,.0f} patches", value, "µs", values=answer))
    values = [row.value for row in rows if row.value]
    if values:
        rows.append(Figure(what, "largest over smallest", max(values) / min(values), "×"))
    return rows


def all_rows(runs, quick, say):
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        parts = {
            "points": lambda: points(runs),
            "STEP": lambda: step(runs, folder),
            "refined": lambda: refine(runs, folder),
            "threads": lambda: threads(runs, folder),
            "patches": lambda: per_patch(runs, SIZES[:2] if quick else SIZES),
        }
        for name, part in parts.items():
            say(name)
            try:
                made = part()
            except (Missing, Failure) as reason:
                made = [Figure(name, "isopatch", missing=str(reason))]
            rows += made
            for row in made:
                text = row.missing or f"{row.value:.4g} {row.unit} {row.note}"
                say(f"  {row.what}: {row.who}: {text}")
    return rows
