"""A long log through ``adaptive-ff replay``: how long it takes, and how much memory beyond the log itself.

The log is made of a joint in closed form, at 1 kHz: 10 million samples are 2.8 h. Each run is a process of its own, so
that its peak memory is its own; the first, short one compiles what is not compiled yet.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

PERIOD = 0.001
FREQUENCIES, AMPLITUDES = (0.0713, 0.2391, 0.917), (0.25, 0.15, 0.05)
INERTIA, COULOMB, VISCOUS, NOISE = 2.0, 3.0, 4.0, 0.05
CHUNK = 1_000_000
SHARES = (0.01, 0.25, 0.5, 1.0)
"""Lengths of the logs, over the longest."""


def write_log(path: Path, samples: int) -> None:
    """Write a log of a joint that moves along three sines, with time, velocity and torque."""
    generator = np.random.default_rng(101)
    series = {name: np.empty(samples) for name in ("time", "velocity", "torque")}
    for start in range(0, samples, CHUNK):
        part = slice(start, min(start + CHUNK, samples))
        t = PERIOD * np.arange(part.start, part.stop)
        pairs = [(2.0 * np.pi * f, a) for f, a in zip(FREQUENCIES, AMPLITUDES, strict=True)]
        velocity = sum(a * np.sin(omega * t) for omega, a in pairs)
        acceleration = sum(a * omega * np.cos(omega * t) for omega, a in pairs)
        friction = COULOMB * np.sign(velocity) + VISCOUS * velocity
        series["time"][part], series["velocity"][part] = t, velocity
        series["torque"][part] = INERTIA * acceleration + friction + NOISE * generator.standard_normal(t.size)
    np.savez(path, **series)


def peak_memory() -> int:
    """Return the largest memory that this process has had, bytes.

    Linux says it in a file; the number of ``getrusage`` there is that of the process which started this one, where that
    was larger.
    """
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    except OSError:
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def replay_in_process(path: Path) -> dict[str, Any]:
    """Replay a log with the command in a process of its own; return its time (s) and peak memory (bytes)."""
    code = (
        "import json, sys\n"
        "from adaptive_ff.cli.main import app\n"
        "from benchmarks.measured.long_log import peak_memory\n"
        "app(sys.argv[1:], standalone_mode=False)\n"
        "print(json.dumps(peak_memory()))\n"
    )
    options = ["--out", str(path.parent / "out")]
    begin = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, "replay", str(path), *options],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).resolve().parents[2],
    )
    return {"seconds": time.perf_counter() - begin, "peak": json.loads(done.stdout.splitlines()[-1])}


def measure(samples: int) -> list[dict[str, Any]]:
    """Return time and memory for logs of several lengths, the longest of so many samples."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for share in SHARES:
            path = Path(folder) / "log.npz"
            count = round(share * samples)
            write_log(path, count)
            size = path.stat().st_size
            rows.append({"samples": count, "log": size, **replay_in_process(path)})
            path.unlink()
    return rows


def table(rows: list[dict[str, Any]]) -> Table:
    """Return what was measured, a log a row."""
    made = Table(title=f"Replay of long logs at 1 kHz, {os.cpu_count()} cores", box=SIMPLE)
    for heading in ("samples", "log, MB", "time, s", "peak memory, MB", "beyond the log, MB"):
        made.add_column(heading, justify="right")
    for row in rows:
        sizes = (row["log"], row["peak"], row["peak"] - row["log"])
        log, peak, beyond = (f"{size / 1e6:.0f}" for size in sizes)
        made.add_row(f"{row['samples']}", log, f"{row['seconds']:.1f}", peak, beyond)
    return made
