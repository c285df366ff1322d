"""A program under comparison, as a process that answers requests."""

import os
import resource
import select
import subprocess
import time

# One thread everywhere; programs with a switch of their own get it on their command line.
ONE_THREAD = {
    name: "1"
    for name in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "VTK_SMP_MAX_THREADS", "TBB_NUM_THREADS")
}
# Longest time until a program has loaded.
LOADING = 120
KIB = 1024


class Failure(Exception):
    """A program has no answer, and this is why."""


class Worker:
    """The process; `memory` is the most that it may use, in bytes, above what it has when it has loaded."""

    def __init__(self, command, memory, environment=None):
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=os.environ | ONE_THREAD | (environment or {}),
            bufsize=0,
        )
        self.pending = b""
        try:
            self._wait_until_loaded()
        except Failure:
            self.close()
            raise
        virtual = self._status("VmSize")
        resource.prlimit(self.process.pid, resource.RLIMIT_AS, (virtual + memory, virtual + memory))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()

    def _wait_until_loaded(self):
        while (line := self._line(LOADING)) != "ready":
            if line is None:
                raise Failure("does not load in time")

    def _line(self, seconds):
        """The next line, or None if there is none in time."""
        end = time.monotonic() + seconds
        while b"\n" not in self.pending:
            left = end - time.monotonic()
            if left <= 0 or not select.select([self.process.stdout], [], [], left)[0]:
                return None
            read = os.read(self.process.stdout.fileno(), 1 << 16)
            if not read:
                code = self.process.wait()
                raise Failure("killed" if code == -9 else f"stopped with {'signal ' if code < 0 else 'code '}{abs(code)}")
            self.pending += read
        line, self.pending = self.pending.split(b"\n", 1)
        return line.decode(errors="replace")

    def ask(self, words, seconds):
        """The figures that the program answers to a request."""
        self.send(words)
        return self.receive(seconds)

    def send(self, words):
        try:
            self.process.stdin.write(("\t".join(str(w) for w in words) + "\n").encode())
        except BrokenPipeError:
            raise Failure("stopped") from None

    def receive(self, seconds):
        line = self._line(seconds)
        if line is None:
            raise Failure(f"over {seconds:.0f} s")
        fields = dict(field.split("=", 1) for field in line.split("\t"))
        if "error" in fields:
            raise Failure(fields["error"])
        return {name: float(value) for name, value in fields.items()}

    def _status(self, name):
        with open(f"/proc/{self.process.pid}/status") as status:
            return next(int(line.split()[1]) * KIB for line in status if line.startswith(name + ":"))

    def cpu_seconds(self):
        """User and system time so far."""
        with open(f"/proc/{self.process.pid}/stat") as stat:
            fields = stat.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def forget_peak(self):
        """Starts the measurement of a peak; gives what is in use now."""
        with open(f"/proc/{self.process.pid}/clear_refs", "w") as refs:
            refs.write("5")
        return self._status("VmRSS")

    def peak(self):
        return self._status("VmHWM")
