"""What msgspec has against a document, in words for whoever wrote that document."""

import datetime
import re
from typing import Any

import msgspec

_WORDS = {
    "array": "a list",
    "bool": "true or false",
    "float": "a number",
    "int": "a whole number",
    "object": "a table",
    "str": "text",
}


def taken_apart(error: msgspec.ValidationError) -> tuple[str, str]:
    """What it says, and the path that it says it of: ``lights[0].power``."""
    text, _, path = str(error).partition(" - at ")
    return text, path.strip("`").removeprefix("$").removeprefix(".")


def in_words(text: str) -> str:
    """Names of types, in msgspec's backquotes, as what a person would write there.

    None is not among them: TOML has no word for it.
    """

    def words(match: re.Match[str]) -> str:
        kinds = [kind for kind in match[1].split(" | ") if kind != "null"]
        return " or ".join(map(_WORDS.__getitem__, kinds)) if {*kinds} <= {*_WORDS} else match[0]

    return re.sub(r"`([a-z]+(?: \| [a-z]+)*)`", words, text)


def missing_key(text: str) -> str | None:
    """The key that is said not to be there, if it is that."""
    match = re.match(r"Object missing required field `(.*)`", text)
    return match[1] if match else None


def at(value: Any, path: str) -> Any:
    """The part of a document that a path leads to.

    Raises:
        KeyError, IndexError, TypeError: it leads nowhere.
    """
    for name, index in re.findall(r"([^.\[\]]+)|\[(\d+)\]", path):
        value = value[int(index)] if index else value[name]
    return value


def shown_at(value: Any, path: str) -> str:
    """What a path leads to, for a message."""
    try:
        return shown(at(value, path))
    except (KeyError, IndexError, TypeError):
        return "nothing"


def shown(value: object) -> str:
    """A value nearly as its document has it, on one line and not too long."""
    text = " ".join(_written(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def _written(value: object) -> str:
    match value:
        case bool():
            return str(value).lower()
        case list():
            return f"[{', '.join(map(_written, value))}]"
        case dict():
            return f"{{{', '.join(f'{key} = {_written(inner)}' for key, inner in value.items())}}}"
        case datetime.date() | datetime.time():
            return value.isoformat()
        case None:
            return "null"
    return repr(value)
