"""Formulae in the page, which browsers set without any script."""

from latex2mathml.converter import convert


def formula(latex: str, *, display: bool = False) -> str:
    """LaTeX mathematics as a MathML element.

    Args:
        latex: As between dollar signs.
        display: Whether it stands on a line of its own.
    """
    return convert(latex, display="block" if display else "inline")
