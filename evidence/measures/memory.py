"""Peak memory of a process."""

from pathlib import Path


def peak_memory() -> float:
    """Return peak memory of this process so far, in bytes; NaN where the system does not report it (not Linux).

    Not getrusage's ru_maxrss, which counts the parent process in as well.
    """
    status = Path("/proc/self/status")
    if not status.is_file():
        return float("nan")
    return 1024 * int(status.read_text(encoding="ascii").split("VmHWM:")[1].split()[0])
