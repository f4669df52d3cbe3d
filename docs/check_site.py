"""Check a built website: every link leads somewhere, and nothing is fetched from the network.

`python docs/check_site.py docs/_build` prints what is wrong and ends with 1, or prints nothing.
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

FETCHED = {"img": "src", "script": "src", "link": "href", "iframe": "src", "source": "src", "image": "href"}
NAMES = ("canonical", "author", "license", "search", "index", "next", "prev")  # relations that fetch nothing


class Page(HTMLParser):
    """Identifiers, links and fetched files of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.identifiers: set[str] = set()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        self.identifiers |= {values[name] for name in ("id", "name") if name in values}
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
        if tag in FETCHED and FETCHED[tag] in values and values.get("rel") not in NAMES:
            self.fetched.append(values[FETCHED[tag]])


def faults(site: Path) -> list[str]:
    """Return what is wrong, a line each."""
    pages = {path: Page(path.read_text(errors="replace")) for path in sorted(site.rglob("*.html"))}
    found = []
    for path, page in pages.items():
        name = path.relative_to(site)
        found += [f"{name}: fetches {url}" for url in page.fetched if urlsplit(url).netloc]
        for url in (*page.links, *page.fetched):
            parts = urlsplit(url)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                found.append(f"{name}: no file {url}")
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].identifiers:
                found.append(f"{name}: no place {url}")
    return sorted(set(found))


if __name__ == "__main__":
    wrong = faults(Path(sys.argv[1]).resolve())
    print("\n".join(wrong), end="\n" if wrong else "")
    sys.exit(bool(wrong))
