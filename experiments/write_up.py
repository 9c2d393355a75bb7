"""Make the write-up of all findings as a PDF of four pages.

python -m experiments write_up [FILE]      build/write-up.pdf by default

`write-up.md` is the text; its numbers are bound to their files as `bound.py` tells.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import matplotlib
from fpdf import FPDF, FontFace, TextStyle
from markdown_it import MarkdownIt
from PIL import Image

HERE = Path(__file__).resolve().parent
TEXT, PDF = HERE / "write-up.md", HERE.parent / "build" / "write-up.pdf"
FONTS = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
SIZE, MARGIN = 9.0, 19.0  # of the text [pt], of the page [mm]
GREY = (70, 70, 70)
WIDE = 1.6  # width over height from which a figure is as wide as the text


def as_html(text: str, folder: Path = HERE) -> str:
    """Return Markdown as HTML for a page: figures as wide as the text, links without targets."""
    text = re.sub("<!--.*?-->", "", text)  # places of numbers
    html = MarkdownIt().enable("table").render(text)
    html = re.sub(r'<a href="[^"]*">(.*?)</a>', r"\1", html)
    html = re.sub(r"<p><img src=\"(\S+?)\" alt=\"(.*?)\" ?/?></p>", _figure(folder), html)
    html = html.replace("<table>", '<table border="0" width="100%" cellpadding="2">')
    return re.sub(r"</?t(?:head|body)>", "", html)


def _figure(folder: Path) -> Callable[[re.Match[str]], str]:
    def shown(match: re.Match[str]) -> str:
        file, words = folder / match[1], match[2]
        with Image.open(file) as picture:
            wide = 480 if picture.width > WIDE * picture.height else 300  # [px]
        return (
            f'<center><img src="{file.as_posix()}" width="{wide}"></center>'
            f'<p><font color="#464646">{words}</font></p>'
        )

    return shown


def write_pdf(html: str, file: Path) -> int:
    """Write pages with the numbers below them; return how many there are."""
    pdf = Pages(format="A4")
    pdf.set_creation_date(datetime.fromtimestamp(0, UTC))  # the same bytes every time
    for style, name in (("", ""), ("B", "-Bold"), ("I", "-Italic"), ("BI", "-BoldItalic")):
        pdf.add_font("serif", style, FONTS / f"DejaVuSerif{name}.ttf")
    pdf.add_font("mono", "", FONTS / "DejaVuSansMono.ttf")
    pdf.set_margins(MARGIN, MARGIN, MARGIN)
    pdf.set_auto_page_break(True, MARGIN)
    pdf.set_font("serif", size=SIZE)
    pdf.add_page()
    pdf.write_html(
        html,
        table_line_separators=True,
        tag_styles={
            "h1": TextStyle("serif", "B", 15, color=0, b_margin=2),
            "h2": TextStyle("serif", "B", 11, color=0, t_margin=3, b_margin=1),
            "code": FontFace("mono", "", SIZE - 1, color=0),
            "a": FontFace("serif", "", SIZE, color=0),
        },
    )
    file.parent.mkdir(parents=True, exist_ok=True)
    pdf.output(str(file))
    return int(pdf.page_no())


class Pages(FPDF):
    """Pages with their numbers."""

    def footer(self) -> None:
        """Write the number of the page below it."""
        self.set_y(-MARGIN + 5.0)
        self.set_font("serif", size=SIZE - 1)
        self.set_text_color(*GREY)
        self.cell(0, 4, str(self.page_no()), align="C")


def main() -> None:
    """Write the pages."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", nargs="?", type=Path, default=PDF)
    file = parser.parse_args().file
    try:
        pages = write_pdf(as_html(TEXT.read_text("utf-8")), file)
    except OSError as error:
        parser.error(str(error))
    print(f"{file}: {pages} pages")


if __name__ == "__main__":
    main()
