"""Where commands print. What users and files say stands there as it is: never markup."""

from rich.console import Console
from rich.status import Status
from rich.text import Text


def open_console(*, on_stderr: bool = False) -> Console:
    """A console that takes no text for markup, in tables neither; styles are given apart."""
    return Console(stderr=on_stderr, markup=False, emoji=False, highlight=False)


def working(console: Console, text: str) -> Status:
    """A sign that something goes on, to be used as a context."""
    return console.status(Text(text))  # a plain string would be taken for markup
