"""The built site in a real browser: every page on a desktop and on a phone, light and dark, its links, and the search.

From the folder of the repository, after ``make docs``, in some minutes:

    .venv/bin/python docs/check_site.py [FOLDER OF THE SITE] [PAGE ...]

It prints what is wrong, page by page, and ends with 1 where anything is. Debian's packages chromium and chromium-driver are
needed; without them it says so and ends with 0. Nothing is loaded from other machines, which is one of the checks.
"""

import functools
import json
import re
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import quote_plus, unquote, urldefrag, urljoin, urlsplit

DOCS = Path(__file__).resolve().parent
WIDTHS = (1400, 400)
QUERIES = {
    "hole": "howto/plate_with_hole",
    "gmsh": "howto/gmsh",
    "stress along a line": "howto/stress_along_a_line",
    "pandas": "howto/csv_and_pandas",
    "csv": "howto/csv_and_pandas",
    "animation": "howto/animation",
    "many thicknesses": "howto/many_thicknesses",
    "symmetric half": "howto/symmetric_half",
    "pressure": "howto/pressure",
    "prestress": "howto/prestress",
    "buckling": "howto/buckling",
    "modes": "howto/modes",
    "restart": "howto/restart",
    "notebook": "howto/notebook",
    "own energy": "howto/own_energy",
    "laminate": "howto/laminate",
    "thermal": "howto/thermal",
    "zones": "howto/zones",
    "rubber": "howto/rubber",
    "own surface": "howto/own_surface",
    "compare meshes": "howto/compare_meshes",
    "error bar": "howto/error_bar",
    "own load": "howto/own_load",
    "damping": "howto/damping",
    "moving load": "howto/moving_load",
    "calculix": "howto/check_with_calculix",
    "logging": "howto/logging_and_progress",
}
"""What is typed, and the page that must be among the first three hits."""

AUDIT = """
const dark = arguments[0], found = [];
const say = (what, element) => found.push(`${what}: <${element.tagName.toLowerCase()} class="${element.className}"> `
    + (element.textContent || element.getAttribute('src') || '').trim().slice(0, 50));
const article = document.querySelector('.bd-article') || document.body;
const seen = element => element.getClientRects().length > 0;

if (!dark) {
    const root = document.documentElement;
    if (root.scrollWidth > root.clientWidth + 1) found.push(`${root.scrollWidth} px wide on ${root.clientWidth}`);
    for (const element of article.querySelectorAll('p, li, dd, td'))
        if (seen(element) && parseFloat(getComputedStyle(element).fontSize) < 13.9) say('small text', element);
    for (const element of article.querySelectorAll('pre'))
        if (seen(element) && parseFloat(getComputedStyle(element).fontSize) < 11.9) say('small code', element);
    for (const image of document.querySelectorAll('img')) {
        if (!image.complete || image.naturalWidth === 0) { if (seen(image)) say('an image that is not there', image); }
        if (!image.alt && !image.closest('.sphx-glr-thumbcontainer')) say('no alternative text', image);
    }
    for (const element of article.querySelectorAll('pre, table, img, svg, dt.sig')) {
        if (!seen(element)) continue;
        const right = element.getBoundingClientRect().left + Math.max(element.scrollWidth || 0, element.clientWidth || 0);
        for (let box = element; box; box = box.parentElement) {
            const flow = getComputedStyle(box).overflowX, edge = box.getBoundingClientRect().right;
            if (right <= edge + 2 && box !== element) continue;
            if (right > edge + 2 && (flow === 'auto' || flow === 'scroll')) break;
            if (right > edge + 2 && (flow === 'hidden' || flow === 'clip')) { say('cut off', element); break; }
        }
    }
}

const channels = text => (text.match(/[\\d.]+/g) || []).map(Number);
const linear = c => { c /= 255; return c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
const luminance = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
const behind = new Map();
const background = element => {
    if (!element) return [255, 255, 255];
    if (!behind.has(element)) {
        const [r, g, b, a = 1] = channels(getComputedStyle(element).backgroundColor);
        const below = a < 1 ? background(element.parentElement) : [r, g, b];
        behind.set(element, a < 1 ? [r, g, b].map((c, k) => a * c + (1 - a) * below[k]) : below);
    }
    return behind.get(element);
};
const told = new Set(), texts = document.createTreeWalker(article, NodeFilter.SHOW_TEXT);
while (texts.nextNode()) {
    const element = texts.currentNode.parentElement;
    if (!texts.currentNode.data.trim() || told.has(element) || !seen(element)) continue;
    told.add(element);
    if (element.closest('svg, mjx-container, script, style, .headerlink, .search-button__kbd-shortcut')) continue;
    const style = getComputedStyle(element), size = parseFloat(style.fontSize);
    if (style.visibility === 'hidden' || style.opacity === '0') continue;
    const over = background(element), [r, g, b, a = 1] = channels(style.color);
    const text = [r, g, b].map((c, k) => a * c + (1 - a) * over[k]);
    const [low, high] = [luminance(text), luminance(over)].sort((x, y) => x - y);
    const large = size >= 24 || (size >= 18.6 && parseInt(style.fontWeight) >= 700), ratio = (high + 0.05) / (low + 0.05);
    if (ratio < (large ? 3 : 4.5)) say(`contrast ${ratio.toFixed(1)}${dark ? ' in the dark' : ''}`, element);
}
return [...new Set(found)].slice(0, 12);
"""

SETTLED = """
const done = arguments[arguments.length - 1];
const ready = window.MathJax && MathJax.startup && MathJax.startup.promise ? MathJax.startup.promise : Promise.resolve();
ready.then(() => requestAnimationFrame(() => done(true)));
"""


class Links(HTMLParser):
    """Anchors of a page, where it points, and what it loads."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag in ("img", "script", "source", "video", "iframe") and given.get("src"):
            self.loads.append(given["src"])
        if tag == "link" and given.get("rel") in ("stylesheet", "icon", "preload"):
            self.loads.append(given.get("href", ""))


def broken_links(site: Path, pages: list[str]) -> Iterator[str]:
    """Links inside the site that lead nowhere, and what would be loaded from outside."""
    read = {page: Links((site / page).read_text(encoding="utf-8")) for page in pages}
    for page, found in read.items():
        yield from (f"{page}: loads {url}" for url in found.loads if urlsplit(url).netloc)
        for link in [*found.links, *found.loads]:
            if urlsplit(link).scheme or urlsplit(link).netloc:
                continue
            path, anchor = urldefrag(urljoin("/" + page, link))
            target = unquote(urlsplit(path).path).lstrip("/")
            if target in read:
                if anchor and unquote(anchor) not in read[target].anchors:
                    yield f"{page}: no anchor {link}"
            elif not (site / target).exists():
                yield f"{page}: no file {link}"


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_: Any) -> None:
        """Nothing."""


def serve(site: Path) -> str:
    """The address of a server of the site, in a thread of this process."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(site)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{server.server_address[1]}/"


def browser(profile: str) -> Any:
    """Debian's chromium without a window, and without its own traffic."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    for option in (
        "headless", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run", "disable-background-networking",
        "disable-component-update", "disable-sync", f"user-data-dir={profile}",
    ):  # fmt: skip
        options.add_argument(f"--{option}")
    options.binary_location = shutil.which("chromium") or ""
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
    driver.set_page_load_timeout(60)
    driver.set_script_timeout(60)
    return driver


def resize(driver: Any, width: int) -> None:
    screen = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)


def logged(driver: Any, address: str) -> Iterator[str]:
    """Errors on the console, and requests to other machines, since the last call."""
    yield from (f"console: {entry['message'][:200]}" for entry in driver.get_log("browser") if entry["level"] == "SEVERE")
    for entry in driver.get_log("performance"):
        message = entry["message"]
        if '"Network.requestWillBeSent"' in message:
            url = json.loads(message)["message"]["params"]["request"]["url"]
            if not url.startswith((address, "data:", "blob:", "about:", "chrome:")):
                yield f"asks another machine: {url}"


def audit(driver: Any, address: str, page: str) -> list[str]:
    """What is wrong with a page."""
    resize(driver, WIDTHS[0])
    driver.get(address + page)
    driver.execute_async_script(SETTLED)
    found = []
    for width in WIDTHS:
        resize(driver, width)
        driver.execute_script("document.documentElement.dataset.theme = 'light'")
        found += [f"{width} px: {problem}" for problem in driver.execute_script(AUDIT, False)]
    driver.execute_script("document.documentElement.dataset.theme = 'dark'")
    found += driver.execute_script(AUDIT, True)
    return found + list(logged(driver, address))


def hits(driver: Any, address: str, query: str) -> list[tuple[str, str]]:
    """The first three hits, each with its snippet."""
    driver.get(f"{address}search.html?q={quote_plus(query)}")
    for _ in range(100):
        time.sleep(0.1)
        shown = driver.execute_script(
            "return [...document.querySelectorAll('#search-results .search > li')].slice(0, 3).map(hit => "
            "[hit.querySelector('a').href, (hit.querySelector('p.context, span') || {}).textContent || ''])"
        )
        if len(shown) == 3 and all(snippet for _, snippet in shown):
            break
    return [(urldefrag(url)[0].removeprefix(address).partition("?")[0].removesuffix(".html"), text) for url, text in shown]


def search(driver: Any, address: str, pages: list[str]) -> Iterator[str]:
    """Queries that do not lead to their page, among those pages that there are."""
    resize(driver, WIDTHS[0])
    for query, wanted in QUERIES.items():
        found = hits(driver, address, query)
        if not found or not all(text.strip() for _, text in found):
            yield f"search for {query!r}: no hits, or hits without a snippet: {found}"
        elif len({page for page, _ in found}) < len(found):
            yield f"search for {query!r}: a page is shown twice: {[page for page, _ in found]}"
        elif f"{wanted}.html" in pages and wanted not in [page for page, _ in found]:
            yield f"search for {query!r}: {wanted} is not among {[page for page, _ in found]}"


def pages_of(site: Path) -> list[str]:
    """Pages of the last build, by its index for the search; pages of older builds lie between them."""
    files = sorted(str(path.relative_to(site)) for path in site.rglob("*.html") if "_static" not in path.parts)
    index = site / "searchindex.js"
    named = re.search(r'"?docnames"?:(\[.*?\])', index.read_text(encoding="utf-8")) if index.is_file() else None
    built = {*json.loads(named[1]), "index", "genindex", "search"} if named else None
    return [file for file in files if built is None or file.removesuffix(".html") in built]


def main() -> int:
    if not (shutil.which("chromium") and shutil.which("chromedriver")):
        print("skipped: chromium and chromedriver are not installed (Debian: apt-get install chromium chromium-driver)")
        return 0
    site = Path(sys.argv[1] if len(sys.argv) > 1 else DOCS / "_build" / "html").resolve()
    pages = pages_of(site)
    if not pages:
        print(f"no pages in {site}: run make docs first")
        return 1
    started, wrong = time.monotonic(), list(broken_links(site, pages))
    print(*wrong, sep="\n", end="\n" if wrong else "")
    with tempfile.TemporaryDirectory() as profile:
        driver, address = browser(profile), serve(site)
        try:
            for page in sys.argv[2:] or pages:
                problems = [f"{page}: {problem}" for problem in audit(driver, address, page)]
                print(*problems, sep="\n", end="\n" if problems else "", flush=True)
                wrong += problems
            missed = [] if sys.argv[2:] else list(search(driver, address, pages))
            print(*missed, sep="\n", end="\n" if missed else "")
        finally:
            driver.quit()
    seconds = time.monotonic() - started
    print(f"{len(pages)} pages at {' and '.join(map(str, WIDTHS))} px, {len(QUERIES)} queries: "
          f"{len(wrong) + len(missed)} faults ({seconds:.0f} s)")  # fmt: skip
    return int(bool(wrong or missed))


if __name__ == "__main__":
    sys.exit(main())
