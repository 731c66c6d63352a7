"""Parts of the site that are generated from the tables of the code, so that they always agree with
it.

Marks of pages are replaced by the parts of `reference_parts.py`, together with the plain Markdown that
is kept below them. The manual pages of the LAMMPS styles are copied from plugins/doc.
"""

from __future__ import annotations

import json
from pathlib import Path

from pygments.lexers.special import TextLexer
from reference_parts import MANUAL, MARK, part_of
from sphinx.application import Sphinx

from granwave.workflows.cli.keys.json_schema import schema_of
from granwave.workflows.file_kinds import file_kinds

#: Entries of the index of manual pages, by page.
ENTRIES = {
    "pair_gran_hysteretic": (
        "LAMMPS pair style", "pair_coeff of the elastoplastic law", "LAMMPS input script",
        "pair style of the contact law",
    ),
    "fix_wall_gran_hysteretic": ("walls in LAMMPS", "moving wall"),
    "compute_gran_hysteretic_local": ("dump of contacts", "compute of contact forces"),
    "compute_gran_hysteretic_energy": ("thermo output of energies",),
}  # fmt: skip


def with_entries(text: str, page: str) -> str:
    """Return a manual page with its entries of the index below its title."""
    if page not in ENTRIES:
        return text
    title, _, rest = text.partition("\n")
    entries = ", ".join(f"! {entry}" for entry in ENTRIES[page])
    return f"{title}\n\n```{{index}} {entries}\n```\n{rest}"


def fill_in(_: Sphinx, __: str, source: list[str]) -> None:
    """Replace the marks of a page by the parts that they name."""

    source[0] = MARK.sub(part_of, source[0])


def copy_manual(app: Sphinx) -> None:
    """Copy the manual pages of the styles into the site's sources, where git ignores them."""
    folder = Path(app.srcdir) / "reference" / "styles"
    folder.mkdir(exist_ok=True)
    pages = {
        path: folder / path.name.replace("README", "index") for path in sorted(MANUAL.glob("*.md"))
    }
    for old in set(folder.glob("*.md")) - set(pages.values()):
        old.unlink()
    names = [page.stem for page in pages.values() if page.stem != "index"]
    for path, page in pages.items():
        text = path.read_text(encoding="utf-8").replace("(README.md", "(index.md")
        text = with_entries(text, page.stem)
        if page.stem == "index":
            text += "\n".join(["\n```{toctree}", ":hidden:", "", *names, "```\n"])
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def write_schemas(app: Sphinx, error: Exception | None) -> None:
    """Write the JSON Schemas of files that users write, for editors, into ``schemas`` of the site."""
    if error is None and app.builder.name == "html":
        folder = Path(app.outdir) / "schemas"
        folder.mkdir(exist_ok=True)
        for kind in file_kinds():
            text = json.dumps(schema_of(kind.name), indent=1) + "\n"
            (folder / f"{kind.name}.schema.json").write_text(text, encoding="utf-8")


class LammpsLexer(TextLexer):
    """Plain text for input scripts of LAMMPS, which Pygments does not know."""

    name = "LAMMPS"
    aliases = ("LAMMPS", "lammps")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.add_lexer("LAMMPS", LammpsLexer)
    app.connect("builder-inited", copy_manual)
    app.connect("source-read", fill_in)
    app.connect("build-finished", write_schemas)
    return {"parallel_read_safe": True}
