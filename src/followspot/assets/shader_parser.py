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

A level needs a hundred entries of the thousands that there are. So a script is read in two
steps: `find_entries` only matches braces and takes the names; the words of a body are cut when
`Entry.read` is asked for them.

The words are cut as in ioquake3's ``COM_Compress`` and ``COM_ParseExt``
(``code/qcommon/q_shared.c``). What the engine is strict about is forgiven where the meaning is
plain: braces may touch a word, a quote left open ends with its line, and where the engine
would drop a whole file, only the entry at fault is lost.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from followspot.assets.shader_script import (
    MAX_QUOTED,
    ShaderScript,
    Stage,
    normalised_name,
)
from followspot.assets.shader_values import Directive
from followspot.errors import AssetError

# Whatever is no token separates tokens: spaces, control characters and, as in the engine,
# every byte above 127, among them a UTF-8 byte order mark.
_COMMENT = r"//[^\n]*+ | /\*.*?(?:\*/|\Z)"  # also in the middle of a word
_QUOTED = r'"[^"\n]*+"?'
_WORD = r"(?: [!-.0-z|~\x7f]++ | /(?![/*]) )++"
_TOKEN = re.compile(rf"\n | {_COMMENT} | {_QUOTED} | [{{}}] | {_WORD}", re.VERBOSE | re.DOTALL)
_UP_TO_BRACE = re.compile(
    rf"(?: [^!-\x7f]++ | {_COMMENT} | {_QUOTED} | {_WORD} )*+", re.VERBOSE | re.DOTALL
)


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry whose braces match, at most two deep, and whose words are still to be cut.

    Args:
        name: Lower case, with forward slashes.
        source: The file.
        line: Line of the name.
        body: The text between the braces.
        body_line: Line of the opening brace.
    """

    name: str
    source: str
    line: int
    body: str
    body_line: int

    def read(self) -> ShaderScript:
        """Cut the body into directives and stages."""
        general: list[Directive] = []
        stages: list[Stage] = []
        directives, stage_line = general, 0
        for line, statement in _statements(self.body, self.body_line):
            if statement == "{":
                directives, stage_line = [], line
            elif statement == "}":
                stages.append(Stage(tuple(directives), stage_line))
                directives = general
            else:
                directives.append(Directive(statement[0].lower(), tuple(statement[1:]), line))
        return ShaderScript(self.name, self.source, self.line, tuple(general), tuple(stages))


def find_entries(text: str, source: str) -> tuple[list[Entry], list[AssetError]]:
    """Find a script's entries, whatever its text, in time linear in its length.

    An entry is lost, with one problem, where its name or a brace is missing, where braces nest
    deeper than stages, or where the text ends or the next entry begins inside it. An entry is
    seen to begin inside another by a line that holds only a word with a slash in it, followed
    by a brace; so an unclosed entry also takes with it such entries as have no slash.

    Args:
        text: The script, bytes decoded as Latin-1.
        source: The file's name for records and errors.

    Returns:
        The entries in the order of the file, where a name may occur twice; and what is wrong
        with the entries that are lost.
    """
    text = text.replace("\r\n", "\n").replace("\r", "\n")  # a lone one ends a line, too
    finder = _Finder(text, source)
    start, line = 0, 1
    while True:
        end = _end_of_words(text, start)
        words = text[start:end]
        finder.words(line, words)
        line += words.count("\n")
        if end == len(text):
            finder.end()
            return finder.entries, finder.problems
        start = end + 1
        if text[end] == "{":
            finder.open(line, start)
        else:
            finder.close(line, end)


def _end_of_words(text: str, start: int) -> int:
    """Where the next brace stands that is one, not part of a comment or quote; or the end."""
    match = _UP_TO_BRACE.match(text, start)
    assert match  # it matches the empty text, too
    return match.end()


def _statements(text: str, line: int) -> Iterator[tuple[int, list[str] | str]]:
    """Yield each brace, as a string, and the words between braces and line ends, as a list.

    Args:
        text: Part of a script, its lines ended by line feeds.
        line: The one on which it begins.
    """
    start = line
    words: list[str] = []
    for token in _TOKEN.findall(text):
        first = token[0]
        if first in "\n{}":
            if words:
                yield start, words
                words = []
            if first == "\n":
                line += 1
            else:
                yield line, first
        elif token.startswith(("//", "/*")):
            line += token.count("\n")
        elif word := token.strip('"') if first == '"' else token:
            if not words:
                start = line
            words.append(word)
    if words:
        yield start, words


class _Finder:
    """Matches braces; depth 0 is outside, 1 an entry, 2 a stage."""

    def __init__(self, text: str, source: str) -> None:
        self.text = text
        self.source = source
        self.entries: list[Entry] = []
        self.problems: list[AssetError] = []
        self.depth = 0
        self.lost = False  # the text up to the next entry is given up, and a problem says why
        self.name = ""  # of the open entry; at depth 0, of the one whose brace is awaited
        self.name_line = 0
        self.start = 0  # of the open entry's body
        self.start_line = 0
        self.last_words = 0, ""  # since the last brace inside an entry, with their line

    def words(self, line: int, text: str) -> None:
        """Take in what stands between two braces."""
        if self.depth:
            self.last_words = line, text
            return
        for at, words in _statements(text, line):
            if self.name:
                self.lose(at, f"'{{' after the name {self.name}", words[0])
            elif len(words) > 1:
                self.lose(at, f"'{{' after the name {words[0]}", words[1])
            self.name = words[0] if len(words) == 1 else ""
            self.name_line = at

    def open(self, line: int, start: int) -> None:
        """Take in an opening brace, behind which a body may start."""
        if self.depth == 0:
            if self.name:
                self.begin_entry(line, start)
                return
            self.lose(line, "a name before the brace", "'{'")
        elif entry := self.name_inside():
            at, name = entry
            self.lose(self.name_line, f"'}}' at the end of {self.name}", f"{name} on line {at}")
            self.name, self.name_line = name, at
            self.begin_entry(line, start)
            return
        elif self.depth > 1:
            self.lose(line, f"no braces inside the stages of {self.name}", "'{'")
        self.depth += 1

    def name_inside(self) -> tuple[int, str] | None:
        """The line and name of an entry that begins inside the open one, if one does."""
        line, text = self.last_words
        if "/" not in text and "\\" not in text:
            return None
        statements = list(_statements(text, line))
        if not statements:  # only comments
            return None
        at, words = statements[-1]
        is_name = len(words) == 1 and "/" in normalised_name(words[0])
        return (at, words[0].lower()) if is_name else None

    def begin_entry(self, line: int, start: int) -> None:
        self.depth = 1
        self.lost = False
        self.start, self.start_line = start, line

    def close(self, line: int, end: int) -> None:
        """Take in a closing brace, before which a body may end."""
        if self.depth == 0:
            self.lose(line, "the name of an entry", "'}'")
            self.name = ""
            return
        self.depth -= 1
        if self.depth == 0:
            if not self.lost:
                name, body = normalised_name(self.name), self.text[self.start : end]
                entry = Entry(name, self.source, self.name_line, body, self.start_line)
                self.entries.append(entry)
            self.name = ""

    def end(self) -> None:
        """Take in the end of the file."""
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
