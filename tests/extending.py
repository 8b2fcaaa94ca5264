"""Code blocks of docs/extending.md by section."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/extending.md").read_text("utf-8")


def section(title: str) -> str:
    """The text below a heading."""
    (found,) = re.findall(rf"^## {title}\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)
    return found


def blocks(text: str, language: str) -> list[str]:
    """The code blocks of a text, without the indentation of their list."""
    found = re.findall(rf"^( *)```{language}\n(.*?)^\1```$", text, re.MULTILINE | re.DOTALL)
    return [re.sub(f"^{indent}", "", block, flags=re.MULTILINE) for indent, block in found]


def new_files(text: str) -> dict[str, str]:
    """The files that a text adds, by the path in their first line."""
    found = [*blocks(text, "python"), *blocks(text, "yaml")]
    return {block.split("\n", 1)[0].removeprefix("# "): block.split("\n", 1)[1] for block in found}
