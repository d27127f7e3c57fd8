"""The strict reader: YAML 1.2 core schema, line of each key, and what it refuses."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml import YAML

from aerosim.errors import InputError
from aerosim.scenario.reader import BYTES_MAX, parse, plain, read

Refused = Callable[[str | bytes], str]


# YAML 1.2.2, section 10.3.2 (core schema): the examples of its table, and words that YAML 1.1 reads otherwise
@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("null", None),
        ("~", None),
        ("", None),
        ("true", True),
        ("False", False),
        ("0", 0),
        ("-19", -19),
        ("+7", 7),
        ("010", 10),
        ("0.", 0.0),
        (".5", 0.5),
        ("-0.0", 0.0),
        ("+12e03", 12000.0),
        ("-2E+05", -200000.0),
        ("1e-3", 0.001),
        ("off", "off"),
        ("yes", "yes"),
        ("No", "No"),
        ("1:30", "1:30"),
        ("1_000", "1_000"),
        ("2026-11-24", "2026-11-24"),
        ("1e", "1e"),
        (".", "."),
    ],
)
def test_scalars_follow_the_core_schema(text: str, value: object) -> None:
    assert plain(text) == value
    assert type(plain(text)) is type(value)


def test_infinities_and_nan_are_numbers_of_yaml() -> None:
    assert plain("-.inf") == float("-inf")
    assert plain(".nan") != plain(".nan")


def test_quotes_keep_a_word_a_word() -> None:
    assert parse("a: \"1\"\nb: 1\nc: 'null'", "x")[0] == {"a": "1", "b": 1, "c": "null"}


def test_every_key_knows_its_line(good: str) -> None:
    _, lines = parse(good, "x")
    assert lines["terrain.source"] == 3
    assert lines["air.wind.from_deg"] == 5
    assert lines["flight.lines.0.end_deg"] == 11
    assert lines["flight.lines.0.end_deg.1"] == 11


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers(-(10**9), 10**9) | st.text("abc xyz_-#'\"", max_size=8),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text("abc", min_size=1), inner, max_size=3),
        max_leaves=12,
    )
)
def test_values_are_those_of_another_reader(value: object) -> None:
    from io import StringIO

    stream = StringIO()
    YAML(typ="safe", pure=True).dump({"top": value}, stream)
    read_back = parse(stream.getvalue(), "x")[0]

    def with_lists(each: object) -> object:
        if isinstance(each, dict):
            return {key: with_lists(inner) for key, inner in each.items()}
        return [with_lists(inner) for inner in each] if isinstance(each, tuple) else each

    assert with_lists(read_back) == {"top": value}


@given(st.text(max_size=60) | st.text("[]{}:,-?!&*|>#%@'\"\\ \n\tabc1", max_size=60))
def test_no_text_does_worse_than_an_input_error(text: str) -> None:
    with suppress(InputError):  # anything else fails
        parse(text, "x")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("name: a\nname: b\n", "try.yaml:2: name: key is given twice (first in line 1)"),
        ("air:\n  wind: 1\n  wind: 2\n", "try.yaml:3: air.wind: key is given twice (first in line 2)"),
        ("a: &x 1\n", "try.yaml:1: a: anchors and aliases are not read (write the value out)"),
        ("a: 1\nb: *x\n", "try.yaml:2: b: anchors and aliases are not read (write the value out)"),
        ("a: !!int 3\n", "try.yaml:1: a: tag tag:yaml.org,2002:int is not read (plain values)"),
        (
            "a: !python/object:os.system x\n",
            "try.yaml:1: a: tag !python/object:os.system is not read (plain values)",
        ),
        ("a: 1\n---\nb: 2\n", "try.yaml:2: more than one document (one document, no second ---)"),
        ("%YAML 1.1\n---\na: 1\n", "try.yaml:2: directives are not read (no line that starts with %)"),
        ("- a\n", "try.yaml:1: is no scenario (KEY: VALUE at the top level)"),
        ("just words\n", "try.yaml:1: is no scenario (KEY: VALUE at the top level)"),
        ("{[1]: 2}\n", "try.yaml:1: key is not a word (KEY: VALUE)"),
    ],
)
def test_what_is_not_plain_yaml_is_refused(refused: Refused, text: str, line: str) -> None:
    assert refused(text) == line


@pytest.mark.parametrize("text", ["", "\n\n", "# only a remark\n", "---\n", "null\n"])
def test_an_empty_file_is_refused(refused: Refused, text: str) -> None:
    assert refused(text).startswith("try.yaml: is empty (a scenario; `aerosim new NAME`")


@pytest.mark.parametrize(
    "data", [b"\x89PNG\r\n\x1a\n\0\0", bytes(range(256)), b"name: \xff\xfe", b"a: \x01", b"a\0b"]
)
def test_a_binary_file_is_refused(refused: Refused, data: bytes) -> None:
    assert refused(data) == "try.yaml: is not a text file (YAML, UTF-8)"


def test_broken_syntax_names_its_line(refused: Refused, good: str) -> None:
    assert refused(good + "zzz: [1, 2\nmore: 3\n").startswith("try.yaml:13: is no YAML: ")
    assert refused("a:\tb\n\tc: d\n").startswith("try.yaml:1: is no YAML: ")


def test_bombs_are_refused_at_once(refused: Refused) -> None:
    laughs = "a: &a [x, x]\n" + "".join(
        f"{c}: &{c} [*{p}, *{p}]\n" for p, c in zip("abcdefgh", "bcdefghi", strict=True)
    )
    started = time.perf_counter()
    assert "anchors and aliases" in refused(laughs)
    assert "nested too deeply (at most 12 levels)" in refused("a: " + "[" * 100000)
    assert "nested too deeply" in refused("a: " + "{a: " * 50000)
    assert "too many values (at most 20000)" in refused("a: [" + "1," * 100000 + "]")
    assert "too large for a scenario (at most 256 KiB)" in refused("#" * (BYTES_MAX + 1))
    assert time.perf_counter() - started < 10


def test_what_cannot_be_read_says_why(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^shown: cannot be read: No such file or directory$"):
        read(tmp_path / "none.yaml", "shown")
