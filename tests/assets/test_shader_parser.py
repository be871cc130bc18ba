"""The grammar of shader scripts: records with their lines, and texts that are malformed."""

import re
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shader_fixtures import ParseResult, parse

from followspot.assets.archive import Archive
from followspot.assets.shader_script import ShaderScript, Stage
from followspot.assets.shader_values import (
    Directive,
)

BASEOA = Path("/usr/share/games/openarena/baseoa")


def parse_good(text: str) -> tuple[ShaderScript, ...]:
    result = parse(text, "a.shader")
    assert result.problems == ()
    return result.shaders


def found(result: ParseResult) -> tuple[list[str], list[tuple[str, str, str]]]:
    """Names of the entries, and (place, expected, found) of the problems."""
    for problem in result.problems:
        assert problem.source == "a.shader"
    return (
        [shader.name for shader in result.shaders],
        [(problem.place, problem.expected, problem.found) for problem in result.problems],
    )


def test_an_entry_keeps_every_directive_with_its_line() -> None:
    text = (
        "// flames\n"
        "Textures\\SFX/Flame\n"
        "{\n"
        "\tsurfaceParm trans\t// see-through\n"
        "\n"
        "\tcull none\n"
        "\t{\n"
        "\t\tanimMap 10 textures/sfx/Flame1.tga textures/sfx/Flame2.tga\n"
        "\t\tblendFunc GL_ONE GL_ONE\n"
        "\t}\n"
        "}\n"
        "b {}\n"
    )
    frames = ("10", "textures/sfx/Flame1.tga", "textures/sfx/Flame2.tga")
    assert parse_good(text) == (
        ShaderScript(
            name="textures/sfx/flame",
            source="a.shader",
            line=2,
            directives=(
                Directive("surfaceparm", ("trans",), 4),
                Directive("cull", ("none",), 6),
            ),
            stages=(
                Stage(
                    directives=(
                        Directive("animmap", frames, 8),
                        Directive("blendfunc", ("GL_ONE", "GL_ONE"), 9),
                    ),
                    line=7,
                ),
            ),
        ),
        ShaderScript(name="b", source="a.shader", line=12, directives=(), stages=()),
    )


@pytest.mark.parametrize(
    "text",
    [
        "x\n{\nnopicmip\n{\nmap a.tga\n}\n}",
        "x{\nnopicmip{map a.tga}}",
        "x { nopicmip { map a.tga } }",
        "x\r\n{\r\n\tnopicmip\r\n\t{\r\n\t\tmap\ta.tga\r\n\t}\r\n}\r\n",
        "x\r{\rnopicmip\r{\rmap a.tga\r}\r}\r",
        "x\r\r\n{\n\rnopicmip\n{ \r\nmap a.tga\r}\n\n}",
        "// x {\nx // {\n{ // }\nnopicmip // }\n{//\nmap a.tga//b\n}//\n}//",
        "/* x\n{ */x/*\n*/{/**/nopicmip/* } */\n{map/* */a.tga/*}*/}/*\n*/}/* open",
        '"x"\n{\nnopicmip\n{\n"map" "a.tga\n}\n}',
        '"x" "" {\n"nopicmip" ""\n{\n"" map "a.tga"\n}\n}',
        "\xef\xbb\xbfx\0{\x01\nnopicmip\x80\n\xa0{\x85map a.tga\xff}\n}\x1a",
    ],
)
def test_one_entry_in_many_spellings(text: str) -> None:
    (shader,) = parse_good(text)
    assert shader.name == "x"
    assert [(item.name, item.args) for item in shader.directives] == [("nopicmip", ())]
    (only,) = shader.stages
    assert [(item.name, item.args) for item in only.directives] == [("map", ("a.tga",))]


def test_every_kind_of_line_end_counts_once() -> None:
    (shader,) = parse_good("\n\r\r\n/*\n\r\n\r*/ x { a\rb /*\n*/ c\nd\n}")
    assert shader.line == 7
    assert [str(item) for item in shader.directives] == ["a", "b c", "d"]
    assert [item.line for item in shader.directives] == [7, 8, 10]


def test_a_quote_keeps_braces_spaces_and_slashes_and_ends_with_its_line() -> None:
    (shader,) = parse_good('x {\na "b {c} // d"e\nf "g /* }\nh }')
    assert [item.args for item in shader.directives] == [("b {c} // d", "e"), ("g /* }",), ()]


def test_a_single_slash_is_part_of_a_word() -> None:
    (shader,) = parse_good("/a/b/ { map /c / d/ }")
    assert shader.name == "/a/b/"
    assert shader.directives[0].args == ("/c", "/", "d/")


@pytest.mark.parametrize(
    ("text", "names", "problems"),
    [
        ("x", [], [("line 1", "'{' after the name x", "the end of the file")]),
        ("\nx {\n{\n}\n", [], [("line 2", "'}' at the end of x", "the end of the file")]),
        ("x y\n{ }\nz {}", ["z"], [("line 1", "'{' after the name x", "y")]),
        ("x\ny\n{ }\nz {}", ["y", "z"], [("line 2", "'{' after the name x", "y")]),
        ("oh dear me\noh\ndear\nz {}", ["z"], [("line 1", "'{' after the name oh", "dear")]),
        ("{ a { b } }\nz {}", ["z"], [("line 1", "a name before the brace", "'{'")]),
        ("x {}\n}\n}\nz {}", ["x", "z"], [("line 2", "the name of an entry", "'}'")]),
        ("x\n}\nz {}", ["z"], [("line 2", "the name of an entry", "'}'")]),
        (
            "x {\n{\n{{\n}}\n} a\n}\nz {}",
            ["z"],
            [("line 3", "no braces inside the stages of x", "'{'")],
        ),
        (
            "x {\n}\n{\n}\nz {}\n}",
            ["x", "z"],
            [
                ("line 3", "a name before the brace", "'{'"),
                ("line 6", "the name of an entry", "'}'"),
            ],
        ),
    ],
)
def test_a_malformed_entry_is_lost_with_one_problem(
    text: str, names: list[str], problems: list[tuple[str, str, str]]
) -> None:
    assert found(parse(text, "a.shader")) == (names, problems)


@pytest.mark.parametrize("unclosed", ["cull none", "{ map c", "{\nmap c\n}", "{ { {", ""])
@pytest.mark.parametrize("beginning", ["t/b\n{", "T\\b{", '\t"t/b" // !\r\n{'])
def test_an_entry_that_begins_inside_an_unclosed_one_is_kept(unclosed: str, beginning: str) -> None:
    names, problems = found(parse(f"a {{\n{unclosed}\n\n{beginning}\n}}\nc {{}}", "a.shader"))
    assert names == ["t/b", "c"]
    assert len(problems) == 1


def test_an_unclosed_entry_tells_where_it_and_the_next_begin() -> None:
    text = "\na\n{\n{\nmap c\n}\n\nt/b\n{\n{\nmap d\n}\n}\n"
    result = parse(text, "a.shader")
    assert found(result)[1] == [("line 2", "'}' at the end of a", "t/b on line 8")]
    assert str(result.problems[0]) == (
        "a.shader: line 2: expected '}' at the end of a, found t/b on line 8"
    )
    stages = (Stage((Directive("map", ("d",), 11),), 10),)
    assert result.shaders == (ShaderScript("t/b", "a.shader", 8, (), stages),)


def test_an_image_name_before_a_brace_begins_no_entry() -> None:
    (shader,) = parse_good("x {\nqer_editorimage t/b\n{\n map t/c\n} }")
    assert len(shader.stages) == 1


def test_a_slashless_entry_inside_an_unclosed_one_is_lost_with_it() -> None:
    text = "a\n{\n{\nmap c\n}\nb\n{\n{\nmap d\n}\n}\nt/e\n{\n}\n"
    names, problems = found(parse(text, "a.shader"))
    assert names == ["t/e"]
    assert [place for place, _, _ in problems] == ["line 8"]


@pytest.mark.parametrize(
    "piece",
    [*'{}"/\r\na\xff', '" ', "/*", "//", "a ", "a/b{", "a\n", "x}", "{a", "a{}"],
)
def test_long_runs_of_anything_end_in_reasonable_time(piece: str) -> None:
    parse(piece * (100_000 // len(piece)), "a.shader")


def test_a_problem_quotes_no_more_than_a_line() -> None:
    result = parse("a" * 1000 + " " + "b" * 1000 + "\nx { cull " + "c" * 1000 + "}", "a.shader")
    assert len(result.problems) == 2
    assert max(len(str(problem)) for problem in result.problems) < 300


_TEXTS = st.one_of(
    st.text(max_size=80),
    st.lists(
        st.sampled_from(
            [
                *("{", "}", '"', "\n", "\r", "\t", "//", "/*", "*/", "t/a", "$lightmap", "gl_one"),
                *("cull", "skyparms", "q3map_sun", "sort", "map", "animmap", "blendfunc"),
                *("tcmod", "turb", "stretch", "rotate", "rgbgen", "alphagen", "wave", "sin"),
                *("0.5", "-", "1e400", "fogparms", "(", ")", "(1"),
            ]
        ),
        max_size=60,
    ).map(" ".join),
    st.binary(max_size=80).map(lambda data: data.decode("latin-1")),
)


@settings(deadline=None)
@given(_TEXTS)
def test_no_text_raises_and_lines_lie_in_the_text(text: str) -> None:
    result = parse(text, "a.shader")
    lines = 1 + text.replace("\r\n", "\n").replace("\r", "\n").count("\n")
    for problem in result.problems:
        assert 1 <= int(problem.place.removeprefix("line ")) <= lines
    for shader in result.shaders:
        parts: list[ShaderScript | Stage] = [shader, *shader.stages]
        for part in parts:
            for name in dir(part):
                getattr(part, name)
            for directive in part.directives:
                assert part.line <= directive.line <= lines


_NAMES = st.text("abcxyz_0123456789/.-", min_size=1, max_size=12).filter(lambda s: "//" not in s)
_WORDS = st.text("abcXYZ09_$*().-+\\", min_size=1, max_size=8)
_QUOTED = st.text("ab {}/*'\t\x00\xe9", min_size=1, max_size=8)
_DIRECTIVES = st.tuples(
    st.sampled_from(["surfaceparm", "nomipmaps", "qer_trans", "depthfunc", "q3map_lightimage"]),
    st.lists(_WORDS | _QUOTED, max_size=4),
)
_STAGES = st.lists(_DIRECTIVES, max_size=4)
_ENTRIES = st.lists(
    st.tuples(_NAMES, st.lists(_DIRECTIVES, max_size=4), st.lists(_STAGES, max_size=3)), max_size=4
)


class _Printer:
    """Prints entries in any legal style, and notes on which lines things come to stand."""

    def __init__(self, data: st.DataObject) -> None:
        self.draw = data.draw
        self.line_end = data.draw(st.sampled_from(["\n", "\r\n", "\r"]))
        self.text = ""
        self.line = 1

    def put(self, text: str) -> int:
        """Print a text without line ends, give its line."""
        self.text += text
        return self.line

    def gap(self, breaks: bool) -> None:
        """Print what may stand between words; one that breaks the line where asked to."""
        comments = ["", " ", "\t", " /* } */ ", "/*{*/"]
        self.put(self.draw(st.sampled_from(comments)))
        for _ in range(self.draw(st.integers(0, 2)) if breaks else 0):
            self.put(self.draw(st.sampled_from(["", " // { x", "//"])))
            self.text += self.line_end
            self.line += 1
            self.put(self.draw(st.sampled_from(["", "\t", "  "])))

    def end_line(self) -> None:
        self.text += self.line_end
        self.line += 1

    def word(self, word: str) -> int:
        bare = re.fullmatch(r"[A-Za-z0-9_$*().+\\-]+", word) and self.draw(st.booleans())
        return self.put(word if bare else f'"{word}"')

    def directive(self, name: str, args: Sequence[str]) -> Directive:
        line = self.word(self.draw(st.sampled_from([name, name.upper()])))
        for arg in args:
            self.put(" ")
            self.gap(breaks=False)
            self.word(arg)
        self.end_line()
        self.gap(breaks=True)
        return Directive(name, tuple(args), line)

    def brace(self, brace: str) -> int:
        self.gap(breaks=True)
        line = self.put(brace)
        self.gap(breaks=True)
        return line


@settings(deadline=None)
@given(st.data())
def test_printed_entries_parse_to_what_was_printed(data: st.DataObject) -> None:
    printer = _Printer(data)
    expected = []
    for name, directives, stages in data.draw(_ENTRIES):
        line = printer.put(f'"{name}"' if data.draw(st.booleans()) else name)
        printer.put(" ")
        printer.brace("{")
        general = [printer.directive(*item) for item in directives]
        layers = []
        for items in stages:
            stage_line = printer.brace("{")
            layers.append(Stage(tuple([printer.directive(*item) for item in items]), stage_line))
            printer.brace("}")
        printer.brace("}")
        expected.append(ShaderScript(name, "a.shader", line, tuple(general), tuple(layers)))
    assert parse_good(printer.text) == tuple(expected)


@pytest.mark.openarena
def test_every_openarena_script_parses() -> None:
    """Each pak by itself, so that files which later paks replace are read too."""
    entries: dict[str, int] = {}
    problems: list[tuple[str, str, str]] = []
    for pak in sorted(BASEOA.glob("*.pk3")):
        with Archive.open([pak]) as archive:
            for name in archive.names("scripts/", ".shader"):
                result = parse(archive.read(name).decode("latin-1"), archive.source(name))
                entries[pak.name] = entries.get(pak.name, 0) + len(result.shaders)
                problems += [(item.source, item.place, item.found) for item in result.problems]
    known = {
        "pak2-players.pk3": 178,
        "pak5-TA.pk3": 51,
        "pak6-patch085.pk3": 807,
        "pak6-patch088.pk3": 1061,
        "z_oacmp-volume1-v3.pk3": 268,
    }
    assert known.items() <= entries.items()
    # The second factor may not be this one: the engine warns and takes GL_ONE.
    blend = "'blendfunc gl_dst_color gl_one_minus_dst_color'"
    assert problems == [
        ("pak6-patch085.pk3:scripts/hotmenu.shader", "line 42", blend),
        ("pak6-patch085.pk3:scripts/oanew.shader", "line 431", blend),
        ("pak6-patch088.pk3:scripts/hotmenu.shader", "line 43", blend),
        # It takes no wave's name; the engine takes that for 0.
        *(
            ("z_oacmp-volume1-v3.pk3:scripts/akom_teleporter.shader", f"line {line}", f"'{turb}'")
            for line, turb in [
                (46, "tcmod turb sin .0 .0 .0 .0"),
                (80, "tcmod turb sin 0 0 0 0"),
                (89, "tcmod turb sin 0 0 0 0"),
            ]
        ),
    ]
