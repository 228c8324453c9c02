"""Follows every link of a built site that does not leave it, to its file and its anchor.

    check_links.py SITE

Ends with 1 and the list of what leads nowhere, if anything does.
"""

from __future__ import annotations

import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    """Links and anchors of a page."""

    def __init__(self, path: pathlib.Path) -> None:
        super().__init__()
        self.links: list[tuple[int, str]] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Notes what a tag leads to, and the anchor that it is."""
        for key, value in attributes:
            if key in ("href", "src") and value is not None:
                self.links.append((self.getpos()[0], value))
            elif key == "id" or (key == "name" and tag == "a"):
                self.anchors.add(value or "")


def wrong(site: pathlib.Path, pages: dict[pathlib.Path, Page], page: pathlib.Path, link: str) -> str | None:
    """What is wrong with a link, if anything is."""
    parts = urllib.parse.urlsplit(link)
    if parts.scheme or parts.netloc:
        return None
    path = urllib.parse.unquote(parts.path)
    target = (site / path.lstrip("/") if path.startswith("/") else page.parent / path).resolve() if path else page
    if target.is_dir():
        target /= "index.html"
    if not target.is_relative_to(site):
        return "leads out of the site"
    if not target.is_file():
        return "there is no such file"
    anchor = urllib.parse.unquote(parts.fragment)
    if anchor and target in pages and anchor not in pages[target].anchors:
        return "the page has no such anchor"
    return None


def main() -> int:
    """Follows them."""
    site = pathlib.Path(sys.argv[1]).resolve()
    pages = {path: Page(path) for path in sorted(site.rglob("*.html"))}
    n_links, n_wrong = 0, 0
    for path, page in pages.items():
        for line, link in page.links:
            n_links += 1
            if reason := wrong(site, pages, path, link):
                n_wrong += 1
                print(f"error: {path.relative_to(site)}:{line}: {link}: {reason}", file=sys.stderr)
    if not pages:
        print(f"error: {site} has no page", file=sys.stderr)
        return 1
    print(f"{n_links} links of {len(pages)} pages, {n_wrong} lead nowhere", flush=True)
    return 1 if n_wrong else 0


if __name__ == "__main__":
    sys.exit(main())
