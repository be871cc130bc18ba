"""GPU time by pass, from timer queries made once."""

from contextlib import AbstractContextManager
from typing import cast

import moderngl


class PassTimers:
    """One timer query a pass; may not be nested.

    Args:
        context: Where the queries live.
        names: Of the passes.
    """

    def __init__(self, context: moderngl.Context, names: tuple[str, ...]) -> None:
        self._queries = {name: context.query(time=True) for name in names}

    def __call__(self, name: str) -> AbstractContextManager[object]:
        """Time what is drawn inside the ``with`` block."""
        return cast("AbstractContextManager[object]", self._queries[name])

    def read_ms(self) -> dict[str, float]:
        """Milliseconds by pass in the last frame; waits for the GPU."""
        return {name: query.elapsed / 1e6 for name, query in self._queries.items()}
