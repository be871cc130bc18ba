"""The entities of a Quake III level: ``{ "key" "value" ... }``, again and again.

Strings know no escapes and may run over lines. Words without quotes and comments of both C kinds
are taken, as the engine's own tokenizer takes them (`COM_Parse` in ioquake3's `q_shared.c`).
"""

import re

from followspot.errors import AssetError

_TOKEN = re.compile(
    r"""(?P<comment> //[^\n]* | /\*.*?(?:\*/|\Z) )
      | (?P<brace> [{}] )
      | "(?P<string> [^"]* )"
      | (?P<open_string> "[^\n]* )
      | (?P<word> [^\s{}"]+ )""",
    re.VERBOSE | re.DOTALL,
)


def parse_entities(text: str, source: str) -> tuple[dict[str, str], ...]:
    """Parse the text of a level's entities.

    Args:
        text: The lump, up to its NUL.
        source: The file's name for errors.

    Returns:
        One dict an entity, in file order: keys in lower case, since the engine compares them so;
        values as written. Of equal keys the last one counts.

    Raises:
        AssetError: A brace, a value or a closing quote is missing; with the line.
    """
    entities: list[dict[str, str]] = []
    entity: dict[str, str] | None = None
    key: str | None = None

    def error(position: int, expected: str, found: str) -> AssetError:
        line = text.count("\n", 0, position) + 1
        return AssetError(source, place=f"entities line {line}", expected=expected, found=found)

    for match in _TOKEN.finditer(text):
        token, start = match[0], match.start()
        if match["comment"] is not None:
            continue
        if match["open_string"] is not None:
            raise error(start, "a closing quote", f"none after {token[:40]}")
        word = match["word"] if match["string"] is None else match["string"]
        if entity is None:
            if token != "{":
                raise error(start, "{", token[:40])
            entity = {}
        elif key is None:
            if word is not None:
                key = word.lower()
            elif token == "}":
                entities.append(entity)
                entity = None
            else:
                raise error(start, "a key or }", token)
        elif word is not None:
            entity[key] = word
            key = None
        else:
            raise error(start, f"a value for key {key[:40]!r}", token)
    if entity is not None:
        raise error(len(text), "}", "the end of the text")
    return tuple(entities)
