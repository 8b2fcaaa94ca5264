"""The report of Snakemake and the overview, as a reader clicks through them."""

from __future__ import annotations

import json
from pathlib import Path

from headless_chromium import Browser

from workflows.overview.page import VERDICTS

# Where the report has its menu, lists the results of a section, shows one, and describes it.
MENU, ROWS, CAPTION = "#app li a", "#app table tbody tr", "#app nav .prose"
SHOWN = "#app iframe, #app .h-screen.grow img"


def walk_through_report(browser: Browser, report: Path) -> dict[str, list[str]]:
    """Open all sections and results.

    Returns
    -------
    dict of str to list of str
        The names of the results by section. What is blank, missing, without a caption or only
        offered to be saved fails; films are seen to move.
    """
    browser.open(report)
    for page in ("Workflow", "Statistics", "About"):
        _choose(browser, page)
        assert browser.shows_something("#app"), page
    return {
        section: _section(browser, section) for section in browser.value("Object.keys(categories)")
    }


def walk_through_overview(browser: Browser, page: Path) -> None:
    """Follow all links to places on the page, look at all images, and open each in full size."""
    browser.open(page)
    # All verdicts are on the first screen.
    heads = "[...document.querySelectorAll('#verdict h3')]"
    assert browser.value(f"{heads}.length") == len(VERDICTS)
    assert browser.value(f"{heads}.every(one => one.getBoundingClientRect().bottom < innerHeight)")
    assert browser.value(
        "(([contents, first]) => contents.right < first.left)"
        "(['nav', '#verdict'].map(one => document.querySelector(one).getBoundingClientRect()))"
    ), "the contents lie on the first screen's text"
    links = browser.value(
        "[...document.querySelectorAll('a')].map(one => one.getAttribute('href'))"
    )
    places = dict.fromkeys(link for link in links if link.startswith("#"))
    assert len(places) > 10
    for place in places:
        browser.value(f"document.querySelector('a[href=\"{place}\"]').click()")
        assert browser.value(
            f"(seen => seen.top < innerHeight && seen.bottom > 0)"
            f"(document.getElementById({place[1:]!r}).getBoundingClientRect())"
        ), f"{place} is not led to"
    opened = []
    for k in range(browser.value("document.images.length")):
        browser.value(f"document.images[{k}].id = 'image-{k}'")
        name = browser.value(f"document.images[{k}].alt")
        assert browser.shows_something(f"#image-{k}"), f"{name} is blank"
        if name.startswith("Film"):
            assert browser.moves(f"#image-{k}"), f"{name} stands still"
        opened.append(browser.value(f"document.images[{k}].closest('a').getAttribute('href')"))
    for file in opened:
        browser.open(page.parent / file)
        assert browser.value("document.images[0].naturalWidth") > 0, f"{file} does not open"
    assert not browser.errors


def _section(browser: Browser, section: str) -> list[str]:
    names = _listed(browser, section)
    told = browser.value(f"Object.values(categories[{json.dumps(section)}]).flat().length")
    # Results of one name are listed as one.
    assert len(names) == told, f"{section}: {told} results, listed are {names}"
    for k, name in enumerate(names):
        look = f"document.querySelectorAll({ROWS!r})[{k}].querySelectorAll('a')[0]"
        assert not browser.value(f"{look}.hasAttribute('download')"), f"only to be saved: {name}"
        browser.value(f"{look}.click()")
        browser.wait(f"document.querySelector({SHOWN!r}) !== null")
        browser.wait("[...document.images].every(one => one.complete && one.naturalWidth > 0)")
        assert browser.shows_something(SHOWN), f"{section}: {name} is blank"
        if name.startswith("Film"):
            assert browser.moves(SHOWN), f"{section}: {name} stands still"
    for k in range(len(names)):
        _listed(browser, section)
        browser.value(f"document.querySelectorAll({ROWS!r})[{k}].querySelectorAll('a')[1].click()")
        browser.wait(f"document.querySelector({CAPTION!r})?.innerText.length > 20")
    assert not browser.errors, f"{section}: {browser.errors}"
    return names


def _listed(browser: Browser, section: str) -> list[str]:
    """The names that a section lists."""
    _choose(browser, section)
    assert not browser.errors, f"{section}: {browser.errors}"
    browser.wait(f"document.querySelectorAll({ROWS!r}).length > 0")
    return browser.value(
        f"[...document.querySelectorAll({ROWS!r})].map(row => row.innerText.trim())"
    )


def _choose(browser: Browser, entry: str) -> None:
    """Click on the house of the report, then on an entry of its menu."""
    browser.value("document.querySelector('#app nav ol a').click()")
    found = (
        f"[...document.querySelectorAll({MENU!r})]"
        f".find(one => one.innerText.trim() === {json.dumps(entry)})"
    )
    browser.wait(f"{found} !== undefined")
    browser.value(f"{found}.click()")
