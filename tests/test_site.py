"""The checks of the built site find faults that are there."""

import importlib.util
import shutil
from pathlib import Path
from types import ModuleType

import pytest

DOCS = Path(__file__).resolve().parent.parent / "docs"
GOOD = """<html data-theme="light"><head><link rel="icon" href="data:,"></head>
<body><article class="bd-article"><h1 id="top">Title</h1>{}</article></body></html>"""
FAULTS = {
    "px wide": '<div style="width: 2000px">wide</div>',
    "small text": '<p style="font-size: 9px">tiny</p>',
    "no alternative text": '<img src="data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA=">',
    "cut off": f'<div style="overflow: hidden"><pre style="width: 300px">{"x" * 900}</pre></div>',
    "contrast": '<p style="color: #bbb; background: #fff">pale</p>',
    "console": "<script>throw new Error('no')</script>",
    "asks another machine": '<img alt="far" src="http://example.invalid/x.png">',
}


def check_site() -> ModuleType:
    spec = importlib.util.spec_from_file_location("check_site", DOCS / "check_site.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


site = check_site()


def test_links_that_lead_nowhere_are_found(tmp_path):
    (tmp_path / "a.html").write_text(
        GOOD.format('<a href="b.html#top">b</a><a href="b.html#no">b</a><a href="c.html">c</a>')
    )
    (tmp_path / "b.html").write_text(GOOD.format('<script src="https://cdn.example/x.js"></script><a href="#top">up</a>'))
    found = list(site.broken_links(tmp_path, ["a.html", "b.html"]))
    assert found == ["a.html: no anchor b.html#no", "a.html: no file c.html", "b.html: loads https://cdn.example/x.js"]


def test_pages_of_older_builds_are_left_alone(tmp_path):
    for name in ("index", "a", "old"):
        (tmp_path / f"{name}.html").write_text(GOOD.format(name))
    assert site.pages_of(tmp_path) == ["a.html", "index.html", "old.html"]
    (tmp_path / "searchindex.js").write_text('Search.setIndex({"docnames":["a","index"],"filenames":["a.rst"]})')
    assert site.pages_of(tmp_path) == ["a.html", "index.html"]


def test_a_browser_finds_each_fault_and_none_on_a_good_page(tmp_path):
    if not (shutil.which("chromium") and shutil.which("chromedriver")):
        pytest.skip("chromium and chromedriver are not installed")
    pages = {"good": '<p>Words.</p><div style="overflow-x: auto"><pre>code</pre></div>', **FAULTS}
    for k, body in enumerate(pages.values()):
        (tmp_path / f"{k}.html").write_text(GOOD.format(body))
    driver, address = site.browser(str(tmp_path / "profile")), site.serve(tmp_path)
    try:
        found = {name: site.audit(driver, address, f"{k}.html") for k, name in enumerate(pages)}
    finally:
        driver.quit()
    assert not found.pop("good")
    for name, told in found.items():
        assert any(name in line for line in told), (name, told)
