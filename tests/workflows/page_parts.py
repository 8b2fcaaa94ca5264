"""What pages are made from in tests: pictures, films, measured times, and text as it is read."""

from __future__ import annotations

import html.parser
import re
from pathlib import Path
from typing import Self

from PIL import Image, ImageDraw

# Names of variables and words of a status, as cf_norm and arrived_hole; g_c is a symbol, and files
# have their names.
_PROGRAM_WORD = re.compile(r"\b[A-Za-z]{2,}_\w+\b(?!\.(?:yaml|nc|html)\b)")


def program_words(text: str) -> list[str]:
    """Words in a text that no reader of the paper knows."""
    return _PROGRAM_WORD.findall(text)


def write_picture(path: Path, size: tuple[int, int] = (1600, 900)) -> None:
    """Write a figure with a line in it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    image = Image.new("RGB", size, "white")
    ImageDraw.Draw(image).line((20, 20, size[0] - 20, size[1] - 20), fill="#0072B2", width=9)
    image.save(path)


def write_moving(path: Path, size: tuple[int, int] = (400, 300)) -> None:
    """Write a film of a growing bar, as GIF or PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    frames = []
    for k in range(8):
        frames.append(Image.new("P", size, 0))
        frames[-1].putpalette([255, 255, 255, 0, 114, 178])
        ImageDraw.Draw(frames[-1]).rectangle((20, 100, 60 + 40 * k, 200), fill=1)
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=100, loop=0)


def write_time(path: Path, seconds: float) -> None:
    """Write what Snakemake measures of a job."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"s\th:m:s\tmax_rss\n{seconds}\t0:00:01\t100.0\n", encoding="utf-8")


class Page(html.parser.HTMLParser):
    """Text of a page as it is read, its pictures, links and places.

    Attributes
    ----------
    text : str
    pictures : list of str
        Their texts.
    links, places : list of str
        Addresses, and what stands at ``id``.
    """

    def __init__(self, text: str) -> None:
        super().__init__()
        self.pictures, self.links, self.places, self._parts = [], [], [], []
        self._hidden = 0
        self.feed(text)
        self.text = " ".join("".join(self._parts).split())

    @classmethod
    def of_file(cls, path: Path) -> Self:
        """The page in a file."""
        return cls(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs) -> None:
        found = dict(attrs)
        self._hidden += tag in ("style", "title")
        if tag == "img":
            self.pictures.append(found["alt"])
        if "href" in found:
            self.links.append(found["href"])
        if "id" in found:
            self.places.append(found["id"])
        if tag in ("td", "th", "p", "li", "h1", "h2", "h3"):
            self._parts.append(" ")

    def handle_endtag(self, tag: str) -> None:
        self._hidden -= tag in ("style", "title")

    def handle_data(self, data: str) -> None:
        if not self._hidden:
            self._parts.append(data)
