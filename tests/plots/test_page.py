"""The web page: plain HTML with relative links, and the numbers on it."""

from __future__ import annotations

from html.parser import HTMLParser

from matplotlib.figure import Figure

from gcm_learn.plots.reports.page import PageTable, Picture, Section, picture_of, render


class Links(HTMLParser):
    """Collects what a page refers to, and checks that tags are balanced."""

    VOID = ("meta", "img", "br")

    def __init__(self):
        super().__init__()
        self.images, self.anchors, self.ids, self.open = [], [], [], []

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        if tag not in self.VOID:
            self.open.append(tag)
        if tag == "img":
            self.images.append(attrs["src"])
        if tag == "a":
            self.anchors.append(attrs["href"])
        if "id" in attrs:
            self.ids.append(attrs["id"])

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def read(page):
    links = Links()
    links.feed(page)
    assert not links.open
    return links


def test_page_is_balanced_escaped_and_linked():
    pictures = [Picture("a.png", 'say "a"', 300), Picture("b.png", "b", 400)]
    section = Section(
        "one", "A < B", ["1 & 2", "run `a < b`"], [PageTable(("x",), [["<b>"]])], pictures
    )
    page = render(
        "T", ["first", "rest"], Picture("o.gif", "o", 200), [("#fff", "white")], [section]
    )
    links = read(page)
    assert links.images == ["o.gif", "a.png", "b.png"]
    assert page.index("first") < page.index("o.gif") < page.index("rest")
    assert "run <code>a &lt; b</code>" in page
    assert links.anchors == ["#one"] and links.ids == ["one", "large"]
    assert "A &lt; B" in page and "1 &amp; 2" in page and "<td>&lt;b&gt;</td>" in page
    assert "http" not in page


def test_words_may_lead_to_other_pages():
    section = Section("beside", "Beside", ["See [a <page>](memory/index.html) of `code`."])
    text = render("title", [], Picture("a.png", "alt", "words"), [], [section])
    assert '<a href="memory/index.html">a &lt;page&gt;</a> of <code>code</code>' in text


def test_pictures_are_enlarged_by_click_and_by_keyboard(tmp_path, browser):
    tall = picture_of(Figure(figsize=(14, 3)), tmp_path / "wide.png", "A wide figure")
    text = render("Title", ["Lead"], tall, (), [], back="../index.html")
    (tmp_path / "page.html").write_text(text, "utf-8")
    page = browser.new_page(viewport={"width": 400, "height": 800})
    page.goto((tmp_path / "page.html").as_uri())
    assert page.get_by_role("link", name="All results").get_attribute("href") == "../index.html"
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    small = page.get_by_role("img").first.bounding_box()["width"]
    for act in (lambda one: one.click(), lambda one: one.press("Enter")):
        act(page.get_by_title("Enlarge"))
        assert page.locator("#large img").bounding_box()["width"] > 2 * small
        page.keyboard.press("Escape")
        assert not page.locator("#large").evaluate("dialog => dialog.open")
    page.close()
