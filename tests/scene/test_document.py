"""Unreadable files, invalid YAML, and places of keys."""

from __future__ import annotations

import contextlib
import tracemalloc
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scene_texts import refused

from cfmpm.errors import SceneError
from cfmpm.scene import load_scene, parse_override
from cfmpm.scene.document import dotted, parse_key, parse_yaml

SYNTAX = [
    ("a: [1, 2\n", 2, "not valid YAML: while parsing a flow sequence"),
    ("a: {b: 1\nc: 2\n", 2, "not valid YAML"),
    ("a: b: c\n", 1, "not valid YAML: mapping values are not allowed"),
    ("a:\n\t- 1\n", 2, "not valid YAML: a tab; indent with spaces"),
    ("mesh:\n\tsize: 1\n", 2, "not valid YAML: a tab; indent with spaces"),
    ("a: *b\n", 1, "not valid YAML: found undefined alias"),
    ("a: 1\n---\nb: 2\n", 2, "not valid YAML: expected a single document"),
    ("a: !!python/object x\n", 1, "not valid YAML: could not determine a constructor"),
    ("a: 1\nb: \x00\n", 2, "not valid YAML: a character that is not text"),
    ("a: \x07\n", 1, "not valid YAML: a character that is not text"),
    ("a: 1\nb: 2\na: 3\n", 3, "given twice"),
    ("a:\n  b: 1\n  b: 1\n", 3, "given twice"),
    ("a: &x [*x]\n", 1, "contains itself"),
    ("a: &x {b: *x}\n", 1, "contains itself"),
    ("? [1, 2]\n: 3\n", 1, "a key must be a word"),
    ("a: {{b: 1}: 2}\n", 1, "a key must be a word"),
    ("a: " + "9" * 5000 + "\n", 1, "cannot be read; put text in quotes"),
    ("a: 2024-13-45\n", 1, "cannot be read; put text in quotes"),
    ("[" * 1500, None, "nested too deeply"),
    ("{a: " * 1500, None, "nested too deeply"),
    ("", None, "the file is empty"),
    ("# only a comment\n", None, "the file is empty"),
    ("null\n", None, "the file is empty"),
    ("- a\n- b\n", 1, 'must be a mapping with keys such as name and material; got ["a", "b"]'),
    ("just words\n", 1, 'must be a mapping with keys such as name and material; got "just words"'),
]


@pytest.mark.parametrize(("text", "line", "fragment"), SYNTAX)
def test_refused(text: str, line: int | None, fragment: str, tmp_path: Path) -> None:
    (problem,) = refused(text, tmp_path)
    assert problem.line == line
    assert fragment in problem.reason


def test_repeated_keys_are_all_named(tmp_path: Path) -> None:
    problems = refused("a: 1\na: 2\nb: {c: 1, c: 2}\n", tmp_path)
    assert [(p.key, p.line, p.column) for p in problems] == [("a", 2, 1), ("b.c", 3, 11)]


def test_aliases_of_aliases_end(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("cfmpm.scene.document.MOST_VALUES", 1000)
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 7)]
    problems = refused("\n".join(lines), tmp_path)
    assert "more than 1000 values" in problems[0].reason


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "latin.yaml").write_bytes("name: x\n# Höhe\n".encode("latin-1"))
    (tmp_path / "binary.yaml").write_bytes(b"\x89HDF\r\n\x1a\n\xff\xfe")
    for path, fragment in [
        (tmp_path / "none.yaml", "none.yaml: no such file"),
        (tmp_path / "none" / "a.yaml", "a.yaml: no such file"),
        (tmp_path, "is a folder, not a scene file"),
        (tmp_path / "latin.yaml", "latin.yaml:2: not text in UTF-8"),
        (tmp_path / "binary.yaml", "binary.yaml:1: not text in UTF-8"),
        (tmp_path / "latin.yaml" / "a.yaml", "cannot be read: Not a directory"),
        (tmp_path / ("x" * 300), "cannot be read: File name too long"),
        ("a\0b", "cannot be read: embedded null byte"),
    ]:
        with pytest.raises(SceneError) as caught:
            load_scene(path)
        assert len(caught.value.problems) == 1
        assert fragment in str(caught.value)


def test_byte_order_mark_and_windows_line_ends() -> None:
    document = parse_yaml("a: 1\r\nb: [2, 3]\r\n", "f")
    assert document.data == {"a": 1, "b": [2, 3]}
    assert document.places["b", 1].line == 2


def test_byte_order_mark_is_skipped(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_bytes(b"\xef\xbb\xbfnam: x\n")
    with pytest.raises(SceneError, match=r"scene.yaml:1:1: nam: unknown key; did you mean name"):
        load_scene(tmp_path / "scene.yaml")


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("mesh.size=2", "mesh.size", 2),
        ("material.E=210e3", "material.E", 210e3),
        ("loads[0].traction=[0, 5]", "loads[0].traction", [0, 5]),
        ("mesh.grading=uniform", "mesh.grading", "uniform"),
        ("description=a=b", "description", "a=b"),
        (" name = x ", "name", "x"),
        ("description=", "description", None),
    ],
)
def test_parse_override(text: str, key: str, value: object) -> None:
    assert parse_override(text) == (key, value)


@pytest.mark.parametrize("text", ["mesh.size", "=3", "", " =1", "a=[1", "a={b: 1, b: 2}"])
def test_parse_override_refused(text: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_override(text)
    assert caught.value.problems[0].file.startswith("override")


keys = st.lists(
    st.text(st.characters(exclude_characters=".[]", codec="utf-8"), min_size=1)
    | st.integers(0, 999),
    min_size=1,
).filter(lambda key: isinstance(key[0], str))


@given(keys.map(tuple))
def test_keys_round_trip(key: tuple[str | int, ...]) -> None:
    # A word of digits in front of brackets is still a word, as brackets mark every index.
    assert parse_key(dotted(key)) == key


@given(st.text(max_size=60))
def test_any_text_is_yaml_or_refused(text: str) -> None:
    with contextlib.suppress(SceneError):
        parse_yaml(text, "f")


def test_what_snakemake_takes_for_code_is_refused(tmp_path: Path) -> None:
    (problem,) = refused("name: x\n__use_yte__: true\n", tmp_path)
    assert (problem.key, problem.line) == ("__use_yte__", 2)
    assert "run values of the file as code" in problem.reason


@pytest.mark.parametrize("levels", [5, 12])
def test_aliases_are_counted_before_they_are_expanded(tmp_path: Path, levels: int) -> None:
    """800 bytes that expand to up to 1e13 values."""
    lines = ["a0: &a0 [" + "1, " * 10 + "]"]
    lines += [f"a{i}: &a{i} [" + f"*a{i - 1}, " * 10 + "]" for i in range(1, levels + 1)]
    tracemalloc.start()
    try:
        problems = refused("\n".join(lines), tmp_path)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert [problem.reason for problem in problems] == ["more than 100000 values"]
    assert problems[0].key == "a4"
    assert most < 5e6
