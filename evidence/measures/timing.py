"""Time, memory and the table in which they are reported."""

import importlib
import platform
import statistics
import time
from collections.abc import Callable, Iterable
from pathlib import Path

from sparsurf.threads import available_cores


class Table:
    """Figures, printed as they are measured.

    Attributes
    ----------
    rows : list of dict: what, dots, value (CPU seconds or what `unit` says), wall (the same of the wall clock),
        unit, at_most (what the project promises); None where there is none
    """

    def __init__(self) -> None:
        self.rows = []
        print(self.markdown(), end="", flush=True)

    def add(
        self,
        what: str,
        dots: int | None,
        value: float | None,
        unit: str,
        wall: float | None = None,
        most: float | None = None,
    ) -> float | None:
        """Add a row to the table, print it, and return its value."""
        row = {"what": what, "dots": dots, "value": value, "wall": wall, "unit": unit, "at_most": most}
        self.rows.append(row)
        print(_line(row.values()), flush=True)
        return value

    def time(
        self,
        what: str,
        dots: int | None,
        run: Callable,
        repeats: int,
        unit: str = "s",
        per: float = 1.0,
        most: float | None = None,
    ) -> float | None:
        """Return the median time of `run()` after one call for warm-up, in `unit`, of which `per` are a second."""
        cpu, wall = timed(run, repeats)
        return self.add(what, dots, cpu * per, unit, wall * per, most)

    def missed(self) -> list[str]:
        """Return the names of the rows above their limit; where no CPU time is known, the wall time counts."""
        measured = [(row, row["wall"] if row["value"] is None else row["value"]) for row in self.rows]
        return [row["what"] for row, value in measured if row["at_most"] and value > row["at_most"]]

    def markdown(self) -> str:
        """Return the whole table."""
        lines = ["| figure | dots | CPU | wall | unit | at most |", "|---|---|---|---|---|---|"]
        return "\n".join(lines + [_line(row.values()) for row in self.rows]) + "\n"


def _line(cells: Iterable) -> str:
    texts = ["" if c is None else f"{c:.3g}" if isinstance(c, float) else str(c) for c in cells]
    return "| " + " | ".join(texts) + " |"


def timed(run: Callable, repeats: int) -> tuple[float, float]:
    """Return median CPU and wall seconds of `run()` over `repeats` calls after one in vain."""
    run()
    times = []
    for _ in range(repeats):
        cpu, wall = time.process_time(), time.perf_counter()
        run()
        times.append((time.process_time() - cpu, time.perf_counter() - wall))
    return tuple(statistics.median(column) for column in zip(*times, strict=True))


def peak_memory() -> float:
    """Return peak memory of this process so far, in bytes; NaN where the system does not report it (not Linux).

    Not getrusage's ru_maxrss, which counts the parent process in as well.
    """
    status = Path("/proc/self/status")
    if not status.is_file():
        return float("nan")
    return 1024 * int(status.read_text(encoding="ascii").split("VmHWM:")[1].split()[0])


def machine() -> dict[str, str | int]:
    """Describe the machine: processor, cores and versions."""
    cpu = platform.processor()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        names = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        cpu = names[0].split(":", 1)[1].strip() if names else cpu
    versions = {name: importlib.import_module(name).__version__ for name in ("numpy", "scipy", "numba")}
    return {"cpu": cpu, "cores": available_cores(), "python": platform.python_version(), **versions}
