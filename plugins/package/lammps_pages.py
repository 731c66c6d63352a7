"""Manual pages in the format of LAMMPS's documentation, reStructuredText, from our pages in
Markdown.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from pathlib import Path

from markdown_it import MarkdownIt
from markdown_it.tree import SyntaxTreeNode
from mdit_py_plugins.dollarmath import dollarmath_plugin
from other_commands import MARK, other_commands

_UNDERLINES = {"h1": "=", "h2": '"', "h3": "^"}
_MEMBER = re.compile(
    r"(?m)^This (?P<kind>\w+) is part of the granwave plugin \(\[loading\]\(README\.md#loading\)\)"
    r"(?P<end>\.|, and)(?=\s)"
)
_PACKAGE = (
    r"This \g<kind> is part of the GRANWAVE package. It is only enabled if LAMMPS was built with that package. See the "
    "[Build package](Build_package.md) page for more info."
)
# pages of LAMMPS whose names do not follow from those of the commands
_OTHER_PAGES = {
    "pair_style gran/hertz/history": "pair_gran",
    "dump local": "dump",
    "timestep": "timestep",
}
_COMMAND = re.compile(r"(pair_style|compute|fix) (\S+)$|(minimize)$")
_LAMMPS_SITE = re.compile(r"https://docs\.lammps\.org/(\w+)\.html$")


def _page_of(command: str) -> str | None:
    """Name of LAMMPS's page of a command; None if it is none."""
    if command in _OTHER_PAGES:
        return _OTHER_PAGES[command]
    found = _COMMAND.match(command)
    return found and re.sub(r"[ /]", "_", command.replace("pair_style", "pair"))


def _escape(text: str) -> str:
    return re.sub(r"([\\*`|]|(?<=\w)_(?!\w))", r"\\\1", text)


def _join(parts: list[str]) -> str:
    """Parts of a line, those with markup apart from letters next to them by an escaped space."""
    line = ""
    for part in parts:
        opens = re.match(r"[*`:]", part) and re.search(r"[^\s'\"(\[{<\-/:]\Z", line)
        closes = re.search(r"(?<!\\)[*`]_?\Z", line) and re.match(r"[^\s'\")\]}>\-/:.,;!?\\]", part)
        if opens or closes:
            line += r"\ "
        line += part
    return line


def slug(title: str) -> str:
    """Anchor of a heading, as links of the Markdown pages have it."""
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")


def _label(page: str, anchor: str) -> str:
    return f"{page}_{anchor}".replace("-", "_")


class _Page:
    def __init__(self, name: str, text: str, labels: set[str]) -> None:
        self.name = name
        self.labels = labels
        self.section = ""
        text = _MEMBER.sub(lambda m: m.expand(_PACKAGE) + (" It" if m["end"] != "." else ""), text)
        text = re.sub(r"`plugins/(?:laws|kernels)/(\w+)\.h`", r"`src/GRANWAVE/granwave_\1.h`", text)
        markdown = MarkdownIt("commonmark").enable("table").use(dollarmath_plugin)
        self.root = SyntaxTreeNode(markdown.parse(text))

    def __str__(self) -> str:
        return "\n".join(self.blocks(self.root)).rstrip() + "\n"

    def blocks(self, parent: SyntaxTreeNode) -> Iterator[str]:
        for node in parent.children:
            yield getattr(self, "block_" + node.type)(node)

    def inline(self, node: SyntaxTreeNode) -> str:
        return _join([getattr(self, "inline_" + child.type)(child) for child in node.children])

    def block_heading(self, node: SyntaxTreeNode) -> str:
        title = self.plain(node)
        lines = []
        if node.tag == "h1":
            lines = [f".. index:: {title.removesuffix(' command')}", ""]
        elif node.tag == "h2":
            self.section = title
            if re.match("Mixing|Restart", title):
                lines = ["----------", ""]
        if (label := _label(self.name, slug(title))) in self.labels:
            lines += [f".. _{label}:", ""]
        title = _escape(title)
        return "\n".join([*lines, title, _UNDERLINES[node.tag] * len(title), ""])

    def block_paragraph(self, node: SyntaxTreeNode) -> str:
        return "\n".join(self.inline(child) for child in node.children) + "\n"

    def block_fence(self, node: SyntaxTreeNode) -> str:
        return f".. code-block:: {node.info or 'none'}\n\n{textwrap.indent(node.content, '   ')}"

    def block_code_block(self, node: SyntaxTreeNode) -> str:
        if self.section != "Syntax":
            return f".. code-block:: none\n\n{textwrap.indent(node.content, '   ')}"
        words = re.sub(
            r"(?m)^(\s*)(\w+(?: or \w+)?)(?= (?:args|values?|keyword)\b)", r"\1<\2>", node.content
        )
        text = re.sub("<(.*?)>", r"*\1*", _escape(words))
        return f".. parsed-literal::\n\n{textwrap.indent(text, '   ')}"

    def block_math_block(self, node: SyntaxTreeNode) -> str:
        # split cannot be nested, and Sphinx sets formulas of several lines in a split of its own
        formula = node.content.strip().replace("{split}", "{aligned}")
        lines = [f"   {line.strip()}" for line in formula.splitlines()]
        return "\n".join([".. math::", "", *lines, ""])

    def block_bullet_list(self, node: SyntaxTreeNode) -> str:
        items = []
        for item in node.children:
            text = textwrap.indent("\n".join(self.blocks(item)).rstrip(), "  ")
            items.append("*" + text[1:])
        wide = any(len(item.children) > 1 for item in node.children)
        return ("\n\n" if wide else "\n").join(items) + "\n"

    def block_table(self, node: SyntaxTreeNode) -> str:
        lines = [".. list-table::", "   :header-rows: 1", ""]
        for part in node.children:
            for row in part.children:
                for n, cell in enumerate(row.children):
                    text = "\n".join(self.inline(child) for child in cell.children)
                    lines.append((("   * - " if n == 0 else "     - ") + text).rstrip())
        return "\n".join(lines) + "\n"

    def inline_text(self, node: SyntaxTreeNode) -> str:
        return _escape(node.content)

    def inline_softbreak(self, node: SyntaxTreeNode) -> str:
        return "\n"

    def inline_code_inline(self, node: SyntaxTreeNode) -> str:
        page = _page_of(node.content) if self.section == "Related commands" else None
        return f":doc:`{node.content} <{page}>`" if page else f"``{node.content}``"

    def inline_math_inline(self, node: SyntaxTreeNode) -> str:
        return f":math:`{node.content}`"

    def inline_em(self, node: SyntaxTreeNode) -> str:
        return f"*{_escape(self.plain(node))}*"

    def inline_strong(self, node: SyntaxTreeNode) -> str:
        return f"**{_escape(self.plain(node))}**"

    def inline_link(self, node: SyntaxTreeNode) -> str:
        text = _escape(self.plain(node).replace("\n", " "))
        target = str(node.attrs["href"])
        if found := _LAMMPS_SITE.match(target):
            return f":doc:`{text} <{found[1]}>`"
        if "://" in target:
            return f"`{text} <{target}>`_"
        if target.startswith("../"):  # pages of the site that LAMMPS's manual has not
            return f"{text} of granwave's manual"
        page, _, anchor = target.partition("#")
        page = page.removesuffix(".md") or self.name
        return f":ref:`{text} <{_label(page, anchor)}>`" if anchor else f":doc:`{text} <{page}>`"

    def plain(self, node: SyntaxTreeNode) -> str:
        return "".join(
            "\n" if one.type == "softbreak" else one.content
            for one in node.walk()
            if not one.children
        )


def lammps_pages(folder: Path) -> dict[str, str]:
    """Pages of a folder, without its README, by name: in LAMMPS's format and layout."""
    texts = {
        path.stem: path.read_text(encoding="utf-8").replace(MARK, other_commands(folder))
        for path in sorted(folder.glob("*.md"))
        if path.stem != "README"
    }
    labels = {
        _label(target or page, anchor)
        for page, text in texts.items()
        for target, anchor in re.findall(r"\]\((?:(\w+)\.md)?#([\w-]+)\)", text)
    }
    return {page: str(_Page(page, text, labels)) for page, text in texts.items()}
