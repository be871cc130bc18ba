"""Where commands print. What users and files say stands there as it is: never markup."""

import json
import sys
from typing import Any

import msgspec
from rich.console import Console
from rich.status import Status
from rich.text import Text


def open_console(*, on_stderr: bool = False) -> Console:
    """A console that takes no text for markup, in tables neither; styles are given apart."""
    return Console(stderr=on_stderr, markup=False, emoji=False, highlight=False)


def working(console: Console, text: str) -> Status:
    """A sign that something goes on, to be used as a context."""
    return console.status(Text(text))  # a plain string would be taken for markup


def as_json(value: Any) -> bytes:
    """A record as JSON for people and programs; names that are no text have it escaped."""
    try:
        encoded = msgspec.json.encode(value)
    except UnicodeEncodeError:
        encoded = msgspec.json.encode(_as_text(msgspec.to_builtins(value)))
    return msgspec.json.format(encoded)


def _as_text(value: Any) -> Any:
    """Plain values; what UTF-8 cannot hold stands in names as Python would write it."""
    if isinstance(value, str):
        return value.encode(errors="backslashreplace").decode()
    if isinstance(value, dict):
        return {_as_text(key): _as_text(each) for key, each in value.items()}
    return [_as_text(each) for each in value] if isinstance(value, list | tuple) else value


def print_json(value: Any) -> None:
    """Print a record as JSON, in whatever encoding is wanted there."""
    text = as_json(value).decode()
    try:
        text.encode(getattr(sys.stdout, "encoding", None) or "utf-8")
    except UnicodeEncodeError:
        text = json.dumps(json.loads(text), indent=2)
    print(text)
