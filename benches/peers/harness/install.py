"""Gets the programs: Python packages, crates and Debian packages, each on its own, so that one that fails stops no other."""

import os
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
REPOSITORY = HERE.parent.parent
BUILD = HERE / ".build"
VENV = BUILD / "venv"
PYTHON = VENV / "bin" / "python"
CARGO_TARGET = BUILD / "cargo"
# Peers are compiled for this machine; isopatch is built as its users build it, and looks at run time what the machine has.
NATIVE = {"RUSTFLAGS": "-Ctarget-cpu=native"}
CXX_FLAGS = ["-O3", "-march=native", "-DNDEBUG", "-std=c++17"]


class Missing(Exception):
    """Something cannot be installed, and this is why."""


def call(command, quiet=False, **options):
    """Runs a command; its first words about an error are the reason if it fails."""
    if not quiet:
        print("·", " ".join(str(word) for word in command), file=sys.stderr)
    environment = os.environ | options.pop("environment", {})
    try:
        done = subprocess.run(command, text=True, capture_output=True, env=environment, **options)
    except FileNotFoundError:
        raise Missing(f"{command[0]} is not there") from None
    if done.returncode != 0:
        lines = [line for line in (done.stderr + done.stdout).splitlines() if "error" in line.lower()]
        raise Missing(lines[0].strip() if lines else f"{command[0]} fails")
    return done.stdout


@cache
def requirements():
    """Versions by the name of the package."""
    lines = (HERE / "requirements.txt").read_text().splitlines()
    pins = [line.split("==") for line in lines if "==" in line]
    return {name.strip(): version.strip() for name, version in pins}


@cache
def python_package(name):
    """Installs a package with its pinned version; gives the version."""
    if not PYTHON.exists():
        call([sys.executable, "-m", "venv", VENV])
    version = requirements()[name]
    # The marker is written last, so that an interrupted installation starts again.
    marker = VENV / f"{name}-{version}.installed"
    if not marker.exists():
        pin = HERE / "requirements.txt"
        call([PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-c", pin, name])
        marker.touch()
    return version


def python_peer(script, *packages):
    for package in ("numpy", *packages):
        python_package(package)
    return [PYTHON, HERE / "peers" / script]


def cargo(project, *arguments, environment=None, target=CARGO_TARGET):
    call(
        ["cargo", "build", "--quiet", "--release", "--locked", *arguments],
        cwd=project,
        environment={"CARGO_TARGET_DIR": str(target)} | (environment or {}),
    )
    return target / "release"


@cache
def measuring():
    """Folder with the measuring program and the library of compiled fields."""
    return cargo(HERE / "measure", environment=NATIVE)


def fields():
    return measuring() / "libpeer_fields.so"


@cache
def isopatch_example(name):
    target = Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target"))
    return cargo(REPOSITORY, "-p", "isopatch", "--example", name, target=target) / "examples" / name


@cache
def isopatch_binary():
    """The command, installed: that of ISOPATCH_BIN, or a new build."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target"))
    if given := os.environ.get("ISOPATCH_BIN"):
        built = Path(given)
    else:
        built = cargo(REPOSITORY, "-p", "isopatch-cli", target=target) / "isopatch"
    # A copy, as those of the peers are: a file as the linker has left it in memory takes longer to start.
    BUILD.mkdir(exist_ok=True)
    return Path(shutil.copy(built, BUILD / "isopatch"))


def installed(package):
    """Version of a Debian package; none if it is not installed."""
    try:
        state, version = call(
            ["dpkg-query", "-W", "-f", "${db:Status-Status} ${Version}", package], quiet=True
        ).split()
    except Missing:
        return None
    return version if state == "installed" else None


@cache
def debian(package):
    """Installs a Debian package; gives its version."""
    if not installed(package):
        if os.geteuid() != 0 or not shutil.which("apt-get"):
            raise Missing(f"{package} is not installed (no root, or no apt-get)")
        quiet = {"DEBIAN_FRONTEND": "noninteractive"}
        call(["apt-get", "update", "-qq"], environment=quiet)
        call(["apt-get", "install", "-y", "-qq", "--no-install-recommends", package], environment=quiet)
    return installed(package)


@cache
def cxx(source, *arguments):
    """Compiles a program in C++; gives the command."""
    if not shutil.which("g++"):
        debian("g++")
    source = HERE / "peers" / source
    program = BUILD / source.stem
    newest = max(path.stat().st_mtime for path in (source, *source.parent.glob("*.hpp")))
    if not program.exists() or program.stat().st_mtime < newest:
        BUILD.mkdir(exist_ok=True)
        call(["g++", *CXX_FLAGS, source, "-o", program, *arguments])
    return [program]


def cgal():
    for package in ("libcgal-dev", "libgmp-dev", "libmpfr-dev"):
        debian(package)
    folder = measuring()
    libraries = ["-lgmp", "-lmpfr", f"-L{folder}", "-lpeer_fields", f"-Wl,-rpath,{folder}"]
    return cxx("cgal_surface_mesher.cpp", *libraries)


@cache
def commit():
    """Of this repository, with a plus sign if files have been changed."""
    head = call(["git", "rev-parse", "--short", "HEAD"], quiet=True, cwd=REPOSITORY).strip()
    changes = call(["git", "status", "--porcelain", "-uno"], quiet=True, cwd=REPOSITORY).strip()
    return head + ("+" if changes else "")


def locked(project, crate):
    """Version of a crate in a lock file."""
    lines = (project / "Cargo.lock").read_text().splitlines()
    return lines[lines.index(f'name = "{crate}"') + 1].split('"')[1]
