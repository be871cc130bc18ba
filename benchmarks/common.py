"""What the benchmarks share: the fixed views, processes run in turn, medians and tables.

Machines are noisy, so nothing here is told as a time alone: what is compared is run in one go
and in turn (A B C A B C ...), and the table gives the ratio of medians with the spread beside it.
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
OUT = HERE.parent / "out" / "benchmarks"
VIEWS = HERE / "views.txt"

LLVMPIPE = {"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": "llvmpipe", "LP_NUM_THREADS": "2"}
"""What makes Mesa draw on the processor with two threads, whatever else the machine has."""

CORES = 2


@dataclass(frozen=True)
class View:
    """A fixed view of a level: eye in Quake units, degrees, positive pitch looks down."""

    level: str
    place: tuple[float, float, float, float, float]

    @property
    def camera(self) -> str:
        """As ``--camera`` takes it: x,y,z,yaw,pitch."""
        return ",".join(f"{value:g}" for value in self.place)

    @property
    def name(self) -> str:
        """Short and unique."""
        return f"{self.level} {self.place[0]:g} {self.place[1]:g} {self.place[2]:g}"


@dataclass(frozen=True)
class Ended:
    """A process that has run to its end: its output, seconds and peak memory in MiB."""

    output: str
    seconds: float
    peak_mb: float


class BenchmarkError(Exception):
    """Something that the comparison needs is missing or went wrong; told in one line."""


def read_views(path: Path = VIEWS, only: str | None = None) -> list[View]:
    """The views of a file, or those of one level."""
    views = []
    for line in path.read_text().splitlines():
        level, *numbers = line.partition("#")[0].split() or [""]
        if not level or (only is not None and level != only):
            continue
        x, y, z, yaw, pitch = map(float, numbers)
        views.append(View(level, (x, y, z, yaw, pitch)))
    if not views:
        raise BenchmarkError(f"{path} has no view of {only}" if only else f"{path} has no view")
    return views


def by_level(views: Iterable[View]) -> dict[str, list[View]]:
    """Views grouped by level, in order."""
    groups: dict[str, list[View]] = {}
    for view in views:
        groups.setdefault(view.level, []).append(view)
    return groups


def two_cores() -> None:
    """Keep this process and its children on two cores, the size that figures are told for."""
    allowed = sorted(os.sched_getaffinity(0))
    if len(allowed) < CORES:
        raise BenchmarkError(f"{CORES} cores are needed; this process may use {len(allowed)}")
    os.sched_setaffinity(0, allowed[:CORES])


def need(tool: str, package: str) -> str:
    """The path of a tool, or an error that names Debian's package."""
    found = shutil.which(tool)
    if found is None:
        raise BenchmarkError(f"{tool} is not installed; on Debian: apt-get install {package}")
    return found


def need_file(path: str, package: str) -> str:
    """The path itself if it is there, or an error that names Debian's package."""
    if not Path(path).exists():
        raise BenchmarkError(f"{path} is missing; on Debian: apt-get install {package}")
    return path


def run(
    command: Sequence[str | Path], env: Mapping[str, str] | None = None, timeout: float = 600
) -> Ended:
    """Run a process to its end.

    Args:
        command: Program and arguments.
        env: Variables on top of this process's own.
        timeout: Seconds after which it is killed.

    Raises:
        BenchmarkError: it failed; with the end of what it said.
    """
    OUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        start = time.monotonic()
        process = subprocess.Popen(
            [str(part) for part in command],
            env={**os.environ, **(env or {})},
            stdout=output,
            stderr=errors,
            stdin=subprocess.DEVNULL,
        )
        killer = threading.Timer(timeout, process.kill)
        killer.start()
        _, status, used = os.wait4(process.pid, 0)
        seconds = time.monotonic() - start
        timed_out = not killer.is_alive()
        killer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        errors.seek(0)
        said, complaints = output.read(), errors.read()
    if timed_out:
        raise BenchmarkError(f"{command[0]} did not end within {timeout:g} s")
    if process.returncode != 0:
        tail = "\n  ".join((said + complaints).strip().splitlines()[-8:])
        raise BenchmarkError(f"{command[0]} ended with {process.returncode}:\n  {tail}")
    return Ended(said, seconds, used.ru_maxrss / 1024)


@dataclass(frozen=True)
class Comparison:
    """One row of a table: for each contender what was taken in each turn; the first is ours.

    Attributes:
        what: What was measured, with its unit.
        taken: By contender, one value a turn.
    """

    what: str
    taken: dict[str, list[float]]

    @property
    def ours(self) -> str:
        """The contender that the others are compared with."""
        return next(iter(self.taken))

    def ratio(self, name: str) -> float:
        """Ours over another's: the median over the turns of the ratio within a turn."""
        pairs = zip(self.taken[self.ours], self.taken[name], strict=True)
        return median([a / b for a, b in pairs])

    def noise(self, name: str) -> float:
        """Half the distance between the quartiles of a contender's turns, over its median."""
        values = self.taken[name]
        if len(values) < 4:
            return (max(values) - min(values)) / 2 / median(values)
        low, _, high = statistics.quantiles(values, n=4)
        return (high - low) / 2 / median(values)


def median(values: Iterable[float]) -> float:
    """The median."""
    return statistics.median(values)


def mean(values: Iterable[float]) -> float:
    """The mean."""
    return statistics.fmean(values)


def report(name: str, title: str, rows: Sequence[Comparison]) -> None:
    """Print a table of comparisons and keep it as ``out/benchmarks/NAME.md`` and ``.json``."""
    names = list(rows[0].taken)
    header = [title, *names, *(f"ratio to {n}" for n in names[1:]), "noise"]
    cells: list[list[object]] = []
    for row in rows:
        noise = max(row.noise(n) for n in names)
        ratios = [row.ratio(n) for n in names[1:]]
        cells.append([row.what, *(median(row.taken[n]) for n in names), *ratios, f"{noise:.0%}"])
    write(name, markdown(header, cells), [asdict(row) for row in rows])


def markdown(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table; numbers with a sensible count of digits, aligned right."""
    lines = [[_cell(value) for value in row] for row in rows]
    numeric = [all(_is_number(line[k]) for line in lines) and k > 0 for k in range(len(header))]
    rule = ["---:" if right else "---" for right in numeric]
    return "\n".join("| " + " | ".join(line) + " |" for line in [list(header), rule, *lines])


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.0f}" if abs(value) >= 100 else f"{value:.2f}"
    return str(value)


def _is_number(text: str) -> bool:
    return text.strip("x%+- ").replace(".", "", 1).isdigit() or text in ("", "-")


def write(name: str, table: str, figures: Any) -> None:
    """Print a table and keep it with its figures as ``out/benchmarks/NAME.md`` and ``.json``."""
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / f"{name}.md").write_text(table + "\n")
    (OUT / f"{name}.json").write_text(json.dumps(figures, indent=2) + "\n")
    print(table)


def parser(description: str) -> argparse.ArgumentParser:
    """An argument parser that prints a module's docstring as it stands."""
    return argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def guarded(main: Callable[[], None]) -> None:
    """Run a script; what is missing or went wrong is told in one place."""
    try:
        main()
    except BenchmarkError as error:
        print(f"{Path(sys.argv[0]).name}: {error}", file=sys.stderr)
        sys.exit(2)
