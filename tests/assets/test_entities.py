import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.assets.entities import entity_flags, entity_vector, parse_entities
from followspot.errors import AssetError


def test_entities_in_order_with_values_as_written() -> None:
    text = '{\n"classname" "worldspawn"\n"message" "C:\\\\A  {b} // c"\n}\n{\n}\n{"a""1" "b" ""}\n'
    assert parse_entities(text, "a.bsp") == (
        {"classname": "worldspawn", "message": "C:\\\\A  {b} // c"},
        {},
        {"a": "1", "b": ""},
    )


def test_keys_are_lower_case_and_the_last_of_equal_ones_counts() -> None:
    assert parse_entities('{ "Key" "One" "kEY" "Two" }', "a.bsp") == ({"key": "Two"},)


def test_comments_and_bare_words() -> None:
    text = '// first "\n{ /* { */ origin "1 2 3" // rest }\n angle 90/*word*/ }// end\n/* open'
    assert parse_entities(text, "a.bsp") == ({"origin": "1 2 3", "angle": "90/*word*/"},)


def test_nothing_is_no_entities() -> None:
    assert parse_entities(" \n\t", "a.bsp") == ()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{\n"a" "1"\n', "entities line 3: expected }, found the end of the text"),
        ('{\n"a" "1"\n{', "entities line 3: expected a key or }, found {"),
        ("{}\n}", "entities line 2: expected {, found }"),
        ('\n"a" "1"', 'entities line 2: expected {, found "a"'),
        ('{\n"a"\n}', "entities line 3: expected a value for key 'a', found }"),
        ('{ "a" {', "entities line 1: expected a value for key 'a', found {"),
        ('{\n"a" "1\n}\n', 'entities line 2: expected a closing quote, found none after "1'),
    ],
)
def test_bad_text_is_told_with_its_line(text: str, message: str) -> None:
    with pytest.raises(AssetError) as error:
        parse_entities(text, "a.bsp")
    assert str(error.value) == f"a.bsp: {message}"


@given(st.text(alphabet='{}"/* \nab\\', max_size=60))
def test_any_text_parses_or_is_an_asset_error(text: str) -> None:
    try:
        parse_entities(text, "a.bsp")
    except AssetError as error:
        assert error.place.startswith("entities line ")


names = st.text(st.characters(max_codepoint=255, exclude_characters='"\0'), max_size=8)


@given(st.lists(st.dictionaries(names.map(str.lower), names, max_size=4), max_size=4))
def test_what_is_written_is_read(entities: list[dict[str, str]]) -> None:
    text = "".join(
        "{" + "".join(f'"{key}" "{value}"\n' for key, value in entity.items()) + "}"
        for entity in entities
    )
    assert parse_entities(text, "a.bsp") == tuple(entities)


@pytest.mark.parametrize("unit", ["/*", '"', "/", "{ a b } ", "a" * 50])
def test_long_hostile_text_ends(unit: str) -> None:
    """Linear time: with quadratic time this would take minutes."""
    with contextlib.suppress(AssetError):
        parse_entities(unit * (1_000_000 // len(unit)), "a.bsp")


@pytest.mark.parametrize("text", ["", "1 2", "1 2 3 4", "a b c", "1 2 inf", "nan 0 0"])
def test_malformed_vectors_are_none(text: str) -> None:
    assert entity_vector({"origin": text}, "origin") is None
    assert entity_vector({}, "origin") is None


@pytest.mark.parametrize(
    ("text", "flags"),
    [("1", 1), (" 1", 1), ("1 ", 1), ("2049x", 2049), ("-1", -1), ("", 0), ("x1", 0), ("²", 0)],
)
def test_flags_are_read_as_the_game_reads_them(text: str, flags: int) -> None:
    assert entity_flags({"spawnflags": text}) == flags


def test_flags_of_any_length_are_taken() -> None:
    assert entity_flags({}) == 0
    assert entity_flags({"spawnflags": "9" * 5000}) == 99999999


def test_vectors() -> None:
    vector = entity_vector({"origin": " 1  -2.5 3e2 "}, "origin")
    assert vector is not None and vector.tolist() == [1, -2.5, 300]
