"""Report as PDF: the HTML page as a browser would print it, by PlutoPrint, which needs no browser."""

from __future__ import annotations

import io
from pathlib import Path
from urllib.parse import quote

import matplotlib as mpl

from granwave.analysis.document.model import Report
from granwave.analysis.reports.writers.html_page import html_page
from granwave.lammps_inputs.errors import InputError

_FONTS = {"normal": "DejaVuSans.ttf", "bold": "DejaVuSans-Bold.ttf"}  # come with matplotlib
_MARK = b"% report of granwave\n"  # after the end of the PDF, where readers skip it
_ADDRESS = "granwave:/"  # of the page, and of the fonts as it asks for them


def pdf_file(report: Report) -> bytes:
    """Return the PDF; it has no date, so that equal reports give equal bytes.

    It ends with a comment by which granwave knows it again.

    Raises
    ------
    InputError
        PlutoPrint is not installed.
    """
    try:
        import plutoprint
    except ImportError as error:
        raise InputError(
            f"PDF: needs PlutoPrint, which cannot be loaded ({error}); install it, pip install plutoprint, or write "
            ".html and print that from a browser"
        ) from None

    class OwnFiles(plutoprint.ResourceFetcher):
        """Pictures in the page, and its fonts: neither files nor the network, whatever a text says."""

        def fetch_url(self, url: str) -> plutoprint.ResourceData:
            if url.startswith("data:"):
                return plutoprint.default_resource_fetcher.fetch_url(url)
            name = url.removeprefix(_ADDRESS)
            if name not in _FONTS.values():
                raise _refuse(url)
            return plutoprint.ResourceData((_font_folder() / name).read_bytes(), "font/ttf")

    book = plutoprint.Book(plutoprint.PAGE_SIZE_A4.landscape(), media=plutoprint.MEDIA_TYPE_PRINT)
    book.custom_resource_fetcher = OwnFiles()
    book.load_html(html_page(report, paper=True), user_style=_font_faces(), base_url=_ADDRESS)
    for key, value in (
        (plutoprint.PDF_METADATA_TITLE, report.title),
        (plutoprint.PDF_METADATA_AUTHOR, "granwave"),
        (plutoprint.PDF_METADATA_CREATION_DATE, "2000-01-01T00:00:00Z"),
    ):
        book.set_metadata(key, value)
    stream = io.BytesIO()
    book.write_to_pdf_stream(stream)
    return stream.getvalue().rstrip() + b"\n" + _MARK


def _refuse(url: str) -> ValueError:
    return ValueError(f"{url}: not of this page")


def _font_folder() -> Path:
    return Path(mpl.get_data_path()) / "fonts" / "ttf"


def _font_faces() -> str:
    """Return the style by which text has the same letters everywhere, also where no font is installed."""
    faces = (
        f'@font-face {{ font-family: "Granwave Sans"; font-weight: {weight}; src: url("{_ADDRESS}{quote(name)}"); }}'
        for weight, name in _FONTS.items()
    )
    return "\n".join([*faces, 'body { font-family: "Granwave Sans" !important; }'])
