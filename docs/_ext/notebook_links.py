"""A link on the page of each notebook, from which it can be saved and run in Jupyter."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

FOLDER = "notebooks"


def with_link(body: str, name: str) -> str:
    """Return the page of a notebook with a link to its file below the title."""
    link = (
        f'<a class="reference download internal" download="" href="../_downloads/{name}">{name}</a>'
    )
    text = "with <code>jupyter lab</code> (<code>pip install jupyterlab</code>)"
    return body.replace("</h1>", f"</h1>\n<p>Download {link} and run it {text}.</p>", 1)


def _add_link(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    if page.startswith(f"{FOLDER}/") and "body" in context:
        context["body"] = with_link(context["body"], f"{page.removeprefix(f'{FOLDER}/')}.ipynb")


def _copy(app: Sphinx, error: Exception | None) -> None:
    if error is not None or app.builder.format != "html":
        return
    downloads = Path(app.outdir) / "_downloads"
    downloads.mkdir(exist_ok=True)
    for notebook in sorted((Path(app.srcdir) / FOLDER).glob("*.ipynb")):
        shutil.copyfile(notebook, downloads / notebook.name)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("html-page-context", _add_link)
    app.connect("build-finished", _copy)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
