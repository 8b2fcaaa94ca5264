"""Tables of words: their contents, and additions by others."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cfmpm.registry import table
from cfmpm.registry.table import Registry, load


def test_words_keep_their_order() -> None:
    words = Registry("law", {"b": 1, "a": 2})
    assert list(words) == ["b", "a"]
    assert dict(words) == {"b": 1, "a": 2}


def test_a_word_is_added_before_the_first_look() -> None:
    words = Registry("law", {"a": 1})
    words.add("c", 3)
    assert words["c"] == 3
    with pytest.raises(RuntimeError, match="law d: add it before"):
        words.add("d", 4)


def test_a_word_is_not_replaced() -> None:
    words = Registry("law", {"a": 1})
    with pytest.raises(ValueError, match="law a: this name is already in use"):
        words.add("a", 2)


def test_another_package_adds_a_word(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "far_law.py").write_text("ENTRY = 7\n")
    facts = tmp_path / "far_law-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: far-law\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[cfmpm.laws]\nfar = far_law:ENTRY\n")
    monkeypatch.syspath_prepend(tmp_path)
    table._points.cache_clear()
    assert list(Registry("law", {"a": 1})) == ["a", "far"]
    assert Registry("law", {"a": 1})["far"] == 7
    assert list(Registry("solver", {"a": 1})) == ["a"]
    table._points.cache_clear()


def test_code_is_loaded_by_its_place() -> None:
    assert load("math:sqrt") is math.sqrt
