"""Tables of the effect of other LAMMPS commands on the styles, for the manual, from the rows of the
tests.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

MARK = "<!-- other_commands -->"  # marker in the manual page where the results are inserted


def other_commands(manual: Path) -> str:
    """Return the tables of a folder's ``other_commands.toml``, in Markdown."""
    text = []
    for section in tomllib.loads((manual / "other_commands.toml").read_text(encoding="utf-8"))[
        "section"
    ]:
        text += [f"## {section['title']}", "", "| command | effect |", "|---|---|"]
        for row in section["row"]:
            refused = (
                [f"**Refused**: `{row['message'].replace('.*', '...')}`."]
                if "message" in row
                else []
            )
            text.append(
                f"| {row['command']} | {' '.join([*refused, row.get('answer', '')]).strip()} |"
            )
        text.append("")
    return "\n".join(text)
