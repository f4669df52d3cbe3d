"""Check a built website: links and anchors, files from the network, texts of pictures, links of plain words in types.

`python docs/check_site.py docs/_build` prints what is wrong and ends with 1, or prints nothing.
"""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Element -> attribute whose address the browser fetches.
FETCHED = {"img": "src", "script": "src", "link": "href", "iframe": "src", "source": "src", "image": "href"}
# Words of types that name no class and get no link; values of `rel` with which a link fetches nothing.
PLAIN = ("shape", "points", "name", "time", "units", "kind", "value", "path")
# Values of rel whose link is no file that the page loads
NAMES = ("canonical", "author", "license", "search", "index", "next", "prev")


class Page(HTMLParser):
    """Identifiers, links, fetched files and faults of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.identifiers: set[str] = set()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.faults: list[str] = []
        self.text = ""  # text since the last link began
        self.reference = False  # whether that link leads to the Python reference
        self.linked = False  # whether it is still open
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        self.identifiers |= {values[name] for name in ("id", "name") if name in values}
        self.linked |= tag == "a"
        if tag == "a" and "href" in values:
            self.links.append(values["href"])
            self.text, self.reference = "", "reference" in values.get("class", "").split()
        if tag in FETCHED and FETCHED[tag] in values and values.get("rel") not in NAMES:
            self.fetched.append(values[FETCHED[tag]])
        if tag == "img" and not values.get("alt"):
            self.faults.append(f"no text for {values.get('src')}")
        elif tag == "img" and not self.linked and values.get("class") != "fish" and "_static/" not in values["src"]:
            self.faults.append(f"no link to {values.get('src')}, to see it in full size")
        if tag == "pre" and "tabindex" not in values:
            self.faults.append("code that no key can scroll")
        style = f"{values.get('style', '')} {values.get('srcset', '')}"
        self.fetched += re.findall(r"https?://[^\s)'\"]+", style)

    def handle_data(self, data: str) -> None:
        self.text += data

    def handle_endtag(self, tag: str) -> None:
        if tag == "a" and self.reference and self.text in PLAIN:
            self.faults.append(f"a link of the word {self.text}")
        self.reference = self.reference and tag != "a"
        self.linked = self.linked and tag != "a"


def faults(site: Path) -> list[str]:
    """Return what is wrong, a line each."""
    pages = {path: Page(path.read_text(errors="replace")) for path in sorted(site.rglob("*.html"))}
    found = []
    for path, page in pages.items():
        name = path.relative_to(site)
        found += [f"{name}: fetches {url}" for url in page.fetched if urlsplit(url).netloc]
        found += [f"{name}: {fault}" for fault in page.faults]
        for url in (*page.links, *page.fetched):
            parts = urlsplit(url)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                found.append(f"{name}: no file {url}")
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].identifiers:
                found.append(f"{name}: no place {url}")
    for path in site.rglob("*.css"):
        urls = re.findall(r"""url\(\s*["']?(https?:[^"')]+)|@import\s+["'](https?:[^"']+)""", path.read_text())
        found += [f"{path.relative_to(site)}: fetches {first or second}" for first, second in urls]
    return sorted(set(found))


if __name__ == "__main__":
    wrong = faults(Path(sys.argv[1]).resolve())
    print("\n".join(wrong), end="\n" if wrong else "")
    sys.exit(bool(wrong))
