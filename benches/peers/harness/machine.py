"""What the figures were measured on."""

import datetime
import os
import platform
from pathlib import Path

from . import install
from .install import Missing

# Vector units that make a difference.
FLAGS = ["sse4_2", "avx", "avx2", "fma", "avx512f", "avx512dq", "avx512vl"]


def first_line(command):
    try:
        return install.call(command, quiet=True).splitlines()[0]
    except (Missing, IndexError):
        return "unknown"


def cpu(field):
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        name, _, value = line.partition(":")
        if name.strip() == field:
            return value.strip()
    return "unknown"


def memory():
    line = next(line for line in Path("/proc/meminfo").read_text().splitlines() if line.startswith("MemTotal"))
    return int(line.split()[1]) * 1024


def describe():
    flags = cpu("flags").split()
    return {
        "date": datetime.date.today().isoformat(),
        "isopatch": install.commit(),
        "cores": os.cpu_count(),
        "cpu": cpu("model name"),
        "flags": [flag for flag in FLAGS if flag in flags],
        "cache": cpu("cache size"),
        "memory": memory(),
        "load": os.getloadavg()[0],
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "rustc": first_line(["rustc", "--version"]),
        "compiler": first_line(["g++", "--version"]),
        "python": platform.python_version(),
    }
