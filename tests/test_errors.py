"""Errors as a user sees them."""

import pytest

from followspot.errors import AssetError, UsageError, asked_by


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("a\nb", r"a\nb"),
        ("a\r\x1b[31mb\x7f", r"a\r\x1b[31mb\x7f"),
        ("a\u2028b\u202eb", r"a\u2028b\u202eb"),
        ("a\udcffb", r"a\udcffb"),
        ("Köln 城", "Köln 城"),
        ("", "''"),
    ],
)
def test_names_of_others_stay_on_one_line(name: str, shown: str) -> None:
    error = AssetError(name, expected="a level", found="none")
    assert str(error) == f"{shown}: expected a level, found none"
    assert str(UsageError(f"{name} is none")) == f"{shown if name else ''} is none"


@pytest.mark.parametrize(
    ("place", "shown"),
    [
        ("", "models[0].file: a.md3"),
        ("byte 3", "models[0].file: a.md3: byte 3"),
        ("file", "models[0].file: a.md3"),
        ("skin", "models[0].skin: a.md3"),
    ],
)
def test_where_an_asset_was_asked_for(place: str, shown: str) -> None:
    with (
        pytest.raises(AssetError) as caught,
        asked_by("x.toml", "models[0].file", skin="models[0].skin"),
    ):
        raise AssetError("a.md3", place=place, expected="b", found="c")
    assert str(caught.value) == f"x.toml: {shown}: expected b, found c"
