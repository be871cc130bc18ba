"""The shader scripts of an archive, and which of several entries with one name counts."""

from collections.abc import Iterator, Mapping
from typing import Protocol

from followspot.assets.shader_parser import Entry, find_entries
from followspot.assets.shader_script import ShaderScript, lookup_name
from followspot.errors import AssetError

MAX_SCRIPT_BYTES = 4 << 20
"""Largest script that is read; the largest of OpenArena's has 120 kB."""


class ReadsScripts(Protocol):
    """What `load_scripts` asks of an archive."""

    def names(self, prefix: str, suffix: str) -> list[str]:
        """List the files whose names begin and end so."""

    def read(self, name: str) -> bytes:
        """Read a file's bytes, or raise `AssetError`."""

    def source(self, name: str) -> str:
        """Say where a file lies, for records and errors."""

    def root(self, name: str) -> int:
        """Say which of the archive's roots holds a file, the first being the one that wins."""


class Scripts(Mapping[str, ShaderScript]):
    """The entries of an archive's scripts by their names, each read when it is first asked for."""

    def __init__(self, entries: Mapping[str, Entry], lost: tuple[AssetError, ...]) -> None:
        self._entries = entries
        self._lost = lost
        self._read: dict[str, ShaderScript] = {}

    def __getitem__(self, name: str) -> ShaderScript:
        if name not in self._read:
            self._read[name] = self._entries[name].read()
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def find(self, name: str) -> ShaderScript | None:
        """The entry that a level's or model's surface means by a name, if there is one."""
        return self.get(lookup_name(name))

    @property
    def problems(self) -> tuple[AssetError, ...]:
        """Files and entries that are lost, then wrong arguments in the entries read so far."""
        wrong = (problem for shader in self._read.values() for problem in shader.problems)
        return (*self._lost, *wrong)


def load_scripts(archive: ReadsScripts, folder: str = "") -> Scripts:
    """Find the entries in every ``scripts/*.shader`` of an archive, or below a folder in it.

    Of several entries with one name the engine's choice holds, which is not the one of files:
    it joins all scripts, the first pak's in front (``ScanAndLoadShaderFiles``), and the first
    entry counts. So an entry of an earlier pak wins over one in a differently named script of
    a later pak; loose files come last. The scripts of one pak are joined from the last to the
    first; in the pak's own order in the engine, by name here. All this holds within one root: an
    entry of an earlier root, which may be another game, wins over any of a later one.

    An unreadable file is one of the result's problems; the others are kept.
    """
    found: dict[str, Entry] = {}
    lost: list[AssetError] = []
    names = sorted(archive.names(f"{folder}scripts/", ".shader"), reverse=True)
    order = {name: (archive.root(name), *_joining_order(archive.source(name))) for name in names}
    for name in sorted(names, key=order.__getitem__):
        try:
            data = archive.read(name)
            if len(data) > MAX_SCRIPT_BYTES:
                expected = f"a script of at most {MAX_SCRIPT_BYTES} bytes"
                raise AssetError(archive.source(name), expected=expected, found=f"{len(data)}")
        except AssetError as error:
            lost.append(error)
            continue
        entries, problems = find_entries(data.decode("latin-1"), archive.source(name))
        lost += problems
        for entry in entries:
            found.setdefault(entry.name, entry)
    return Scripts(found, tuple(lost))


def _joining_order(source: str) -> tuple[bool, str]:
    """Sort key of a script's full name: paks in the order of their names, then loose files."""
    pak, inside, _ = source.upper().partition(".PK3:")
    return not inside, pak
