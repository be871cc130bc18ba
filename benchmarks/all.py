"""All benchmarks, one after another, into one table: out/benchmarks/table.md and table.json.

Takes about half an hour; let the machine do nothing else meanwhile. --quick takes a few minutes
and shows that everything runs; its figures are not to be quoted.
"""

import json
import platform
import sys

import common
from common import BenchmarkError

PARTS = {
    "engine": "At fixed views, against the game engine",
    "renderers": "On the same mesh, against other renderers",
    "floor": "Against a bare C program with the same GL calls",
    "submission": "The processor's share alone",
    "scale": "Against scale",
    "characters": "Characters and films",
}
QUICK = {
    "engine": ["--level", "oa_dm5", "--frames", "20", "--rounds", "1"],
    "renderers": ["--frames", "5", "--rounds", "1"],
    "floor": ["--frames", "20", "--rounds", "1"],
    "submission": ["--level", "oa_dm5", "--frames", "20"],
    "scale": ["--frames", "3", "--rounds", "1"],
    "characters": ["--frames", "5", "--rounds", "1"],
}


def main() -> None:
    """Run the parts and put their tables together."""
    parser = common.parser(__doc__)
    parser.add_argument("--quick", action="store_true", help="few frames and turns")
    parser.add_argument("--only", action="append", choices=PARTS, help="one of the parts")
    arguments = parser.parse_args()
    common.two_cores()
    sections, figures, failed = [], {}, []
    for name in arguments.only or PARTS:
        print(f"--- {name}", file=sys.stderr)
        options = QUICK[name] if arguments.quick else []
        try:
            common.run([sys.executable, common.HERE / f"{name}.py", *options], timeout=3600)
        except BenchmarkError as error:
            failed.append(f"{name}: {error}")
            continue
        sections.append(f"## {PARTS[name]}\n\n{(common.OUT / f'{name}.md').read_text()}")
        figures[name] = json.loads((common.OUT / f"{name}.json").read_text())
    title = f"# Benchmarks\n\n640x480, Mesa's software rasteriser, {common.CORES} cores, Python "
    title += f"{platform.python_version()}; medians, and ratios within a turn.\n\n"
    (common.OUT / "table.md").write_text(title + "\n".join(sections))
    (common.OUT / "table.json").write_text(json.dumps(figures, indent=2) + "\n")
    print(f"{common.OUT / 'table.md'}")
    if failed:
        raise BenchmarkError("; ".join(failed))


if __name__ == "__main__":
    common.guarded(main)
