"""From the text of .shader scripts to records.

A script is a row of entries, each a name and a body in braces. The body holds general
directives, one a line, and stages: braces again, with directives of their own.

    textures/sfx/flame            // a comment
    {
        surfaceparm trans
        cull none
        {
            map textures/sfx/flame.tga
            blendFunc add
        }
    }

The words are cut as in ioquake3's ``COM_Compress`` and ``COM_ParseExt``
(``code/qcommon/q_shared.c``). What the engine is strict about is forgiven where the meaning is
plain: braces may touch a word, a quote left open ends with its line, and where the engine
would drop a whole file, only the entry at fault is lost.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from followspot.assets.shader_script import MAX_QUOTED, ShaderScript, Stage, normalised_name
from followspot.assets.shader_values import Directive
from followspot.errors import AssetError

MAX_SCRIPT_BYTES = 4 << 20
"""Largest script that is read; the largest of OpenArena's has 120 kB."""

# Whatever is no token separates tokens: spaces, control characters and, as in the engine,
# every byte above 127, among them a UTF-8 byte order mark. A lone carriage return ends a line.
_TOKEN = re.compile(
    r"""
      \r\n? | \n                                  # end of line
    | //[^\r\n]* | /\*.*?(?:\*/|\Z)               # comments, also in the middle of a word
    | "[^"\r\n]*"?                                # quoted word
    | [{}]
    | (?: [!-.0-z|~\x7f] | /(?![/*]) )+           # word
    """,
    re.VERBOSE | re.DOTALL,
)
_LINE_END = re.compile(r"\r\n?|\n")


class ReadsScripts(Protocol):
    """What `load_scripts` asks of an archive."""

    def names(self, prefix: str, suffix: str) -> list[str]:
        """List the files whose names begin and end so."""

    def read(self, name: str) -> bytes:
        """Read a file's bytes, or raise `AssetError`."""

    def source(self, name: str) -> str:
        """Say where a file lies, for records and errors."""


@dataclass(frozen=True, slots=True)
class ParseResult:
    """What a script holds, and what is wrong with it.

    Args:
        shaders: In the order of the file; a name may occur twice.
        problems: Entries that are lost, then arguments that the engine does not know.
    """

    shaders: tuple[ShaderScript, ...]
    problems: tuple[AssetError, ...]


def load_scripts(
    archive: ReadsScripts,
) -> tuple[dict[str, ShaderScript], tuple[AssetError, ...]]:
    """Parse every ``scripts/*.shader`` of an archive.

    Of several entries with one name the engine's choice holds, which is not the one of files:
    it joins all scripts, the first pak's in front (``ScanAndLoadShaderFiles``), and the first
    entry counts. So an entry of an earlier pak wins over one in a differently named script of
    a later pak; loose files come last. The scripts of one pak are joined from the last to the
    first; in the pak's own order in the engine, by name here.

    Returns:
        The entries by their `ShaderScript.name`, to be asked with `lookup_name`; and what is
        wrong in any of the files. An unreadable file is one problem, the others are kept.
    """
    scripts: dict[str, ShaderScript] = {}
    problems: list[AssetError] = []
    names = sorted(archive.names("scripts/", ".shader"), reverse=True)
    for name in sorted(names, key=lambda name: _joining_order(archive.source(name))):
        try:
            data = archive.read(name)
            if len(data) > MAX_SCRIPT_BYTES:
                expected = f"a script of at most {MAX_SCRIPT_BYTES} bytes"
                raise AssetError(archive.source(name), expected=expected, found=f"{len(data)}")
        except AssetError as error:
            problems.append(error)
            continue
        result = parse(data.decode("latin-1"), archive.source(name))
        problems += result.problems
        for shader in result.shaders:
            scripts.setdefault(shader.name, shader)
    return scripts, tuple(problems)


def _joining_order(source: str) -> tuple[bool, str]:
    """Sort key of a script's full name: paks in the order of their names, then loose files."""
    pak, inside, _ = source.upper().partition(".PK3:")
    return not inside, pak


def parse(text: str, source: str) -> ParseResult:
    """Parse a script, whatever its text, in time linear in its length.

    An entry is lost, with one problem, where its name or a brace is missing, where braces nest
    deeper than stages, or where the text ends or the next entry begins inside it. An entry is
    seen to begin inside another by a line that holds only a word with a slash in it, followed
    by a brace; so an unclosed entry also takes with it such entries as have no slash.

    Args:
        text: The script, bytes decoded as Latin-1.
        source: The file's name for records and errors.
    """
    parser = _Parser(source)
    for line, statement in _statements(text):
        if isinstance(statement, list):
            parser.words(line, statement)
        elif statement == "{":
            parser.open(line)
        else:
            parser.close(line)
    parser.end()
    for shader in parser.shaders:
        parser.problems += shader.problems
    return ParseResult(tuple(parser.shaders), tuple(parser.problems))


def _statements(text: str) -> Iterator[tuple[int, list[str] | str]]:
    """Yield each brace, as a string, and the words between braces and line ends, as a list."""
    line = start = 1
    words: list[str] = []
    for match in _TOKEN.finditer(text):
        token = match.group()
        first = token[0]
        if first in "\r\n{}":
            if words:
                yield start, words
                words = []
            if first in "{}":
                yield line, first
            else:
                line += 1
        elif token.startswith(("//", "/*")):
            line += len(_LINE_END.findall(token))
        elif word := token.strip('"') if first == '"' else token:
            if not words:
                start = line
            words.append(word)
    if words:
        yield start, words


class _Parser:
    """Builds entries statement by statement; depth 0 is outside, 1 an entry, 2 a stage."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.shaders: list[ShaderScript] = []
        self.problems: list[AssetError] = []
        self.depth = 0
        self.lost = False  # the text up to the next entry is given up, and a problem says why
        self.name = ""  # of the open entry; at depth 0, of the one whose brace is awaited
        self.name_line = 0
        self.directives: list[Directive] = []
        self.stages: list[Stage] = []
        self.stage_line = 0
        self.stage_directives: list[Directive] = []
        self.last: Directive | None = None  # unless a brace came since

    def words(self, line: int, words: list[str]) -> None:
        if self.depth == 0:
            if self.name:
                self.lose(line, f"'{{' after the name {self.name}", words[0])
            elif len(words) > 1:
                self.lose(line, f"'{{' after the name {words[0]}", words[1])
            self.name = words[0] if len(words) == 1 else ""
            self.name_line = line
            return
        self.last = Directive(words[0].lower(), tuple(words[1:]), line)
        if self.depth == 1:
            self.directives.append(self.last)
        elif self.depth == 2:
            self.stage_directives.append(self.last)

    def open(self, line: int) -> None:
        last, self.last = self.last, None
        if self.depth == 0:
            if self.name:
                self.begin_entry()
                return
            self.lose(line, "a name before the brace", "'{'")
        elif last and not last.args and "/" in normalised_name(last.name):
            self.lose(
                self.name_line,
                f"'}}' at the end of {self.name}",
                f"{last.name} on line {last.line}",
            )
            self.name, self.name_line = last.name, last.line
            self.begin_entry()
            return
        elif self.depth == 1:
            self.stage_line = line
            self.stage_directives = []
        else:
            self.lose(line, f"no braces inside the stages of {self.name}", "'{'")
        self.depth += 1

    def begin_entry(self) -> None:
        self.depth = 1
        self.lost = False
        self.directives = []
        self.stages = []

    def close(self, line: int) -> None:
        self.last = None
        if self.depth == 0:
            self.lose(line, "the name of an entry", "'}'")
            self.name = ""
            return
        self.depth -= 1
        if self.depth == 1:
            self.stages.append(Stage(tuple(self.stage_directives), self.stage_line))
        elif self.depth == 0:
            if not self.lost:
                self.shaders.append(
                    ShaderScript(
                        normalised_name(self.name),
                        self.source,
                        self.name_line,
                        tuple(self.directives),
                        tuple(self.stages),
                    )
                )
            self.name = ""

    def end(self) -> None:
        if self.depth:
            self.lose(self.name_line, f"'}}' at the end of {self.name}", "the end of the file")
        elif self.name:
            self.lose(self.name_line, f"'{{' after the name {self.name}", "the end of the file")

    def lose(self, line: int, expected: str, found: str) -> None:
        if not self.lost:
            self.problems.append(
                AssetError(
                    self.source,
                    place=f"line {line}",
                    expected=expected[:MAX_QUOTED],
                    found=found[:MAX_QUOTED],
                )
            )
        self.lost = True
