"""Whole scripts read at once, which levels never do."""

from typing import NamedTuple

from followspot.assets.shader_parser import find_entries
from followspot.assets.shader_script import ShaderScript
from followspot.errors import AssetError


class ParseResult(NamedTuple):
    """What a script holds, and what is wrong: lost entries, then arguments in the others."""

    shaders: tuple[ShaderScript, ...]
    problems: tuple[AssetError, ...]


def parse(text: str, source: str) -> ParseResult:
    entries, lost = find_entries(text, source)
    shaders = tuple(entry.read() for entry in entries)
    wrong = [problem for shader in shaders for problem in shader.problems]
    return ParseResult(shaders, (*lost, *wrong))
