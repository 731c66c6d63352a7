"""Pages of the documents, including the README, as blocks of code that tests run, load or read."""

from __future__ import annotations

import dataclasses
import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path
from types import ModuleType

from tests.conftest import PLAIN

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
_BLOCK = re.compile(r"^```(?:\{code-block\} )?(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_OPTION = re.compile(r"\A(?::(\w+): (.*)\n)*\n?")


@dataclasses.dataclass(frozen=True)
class Block:
    """A block of code of a page.

    Attributes
    ----------
    language
        ``shell``: commands that `make validate` runs; ``bash``: commands that it does not, as they
        take long or need another machine; ``python``, ``toml``, ``text``.
    caption
        Name of the file under which it is saved, from the option ``caption`` or a first comment;
        empty for none.
    output
        True if it shows lines that the preceding commands print.
    """

    language: str
    text: str
    caption: str = ""
    output: bool = False

    @property
    def commands(self) -> list[list[str]]:
        """Words of the granwave commands of a block of commands."""
        lines = self.text.splitlines() if self.language in ("shell", "bash") else []
        words = [shlex.split(line, comments=True) for line in lines]
        return [line[1:] for line in words if line[:1] == ["granwave"]]


def pages() -> list[Path]:
    """Return the README and the handwritten pages."""
    generated = ("docs/reference/styles", "docs/gallery/studies")
    found = sorted((ROOT / "docs").rglob("*.md"))
    return [
        README,
        *(page for page in found if page.parent.relative_to(ROOT).as_posix() not in generated),
    ]


def blocks(page: Path) -> list[Block]:
    """Return the blocks of code of a page, in order."""
    found = []
    for language, body in _BLOCK.findall(page.read_text(encoding="utf-8")):
        head = _OPTION.match(body)
        options = dict(re.findall(r"^:(\w+): (.*)$", head[0], re.MULTILINE)) if head else {}
        text = body[head.end() :] if options and head else body
        caption = options.get("caption", "") or next(
            iter(re.findall(r"\A# (\S+\.toml)$", text, re.MULTILINE)), ""
        )
        found.append(Block(language, text, caption, options.get("class") == "output"))
    return found


def name_of(page: Path) -> str:
    """Return the path of a page below the root, for the names of tests."""
    return page.relative_to(ROOT).as_posix()


def write_files(page: Path, folder: Path) -> None:
    """Write the files of a page (blocks with a caption) into a folder; LAMMPS scripts are run
    there.
    """
    for block in blocks(page):
        if block.caption:
            (folder / block.caption).write_text(block.text, encoding="utf-8")
        if block.caption and block.caption.endswith(".in"):
            lmp = Path(sys.prefix) / "bin" / "lmp"
            command = [str(lmp), "-in", block.caption, "-log", "none", "-screen", "none"]
            subprocess.run(command, cwd=folder, check=True, env=PLAIN)


def extension(name: str) -> ModuleType:
    """Load a module of the site's extensions."""
    specification = importlib.util.spec_from_file_location(
        name, ROOT / "docs" / "_ext" / f"{name}.py"
    )
    assert specification and specification.loader
    module = sys.modules[name] = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module
