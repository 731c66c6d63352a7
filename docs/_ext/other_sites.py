"""Check of the links of the site to other sites, by Sphinx's linkcheck.

    python docs/_ext/other_sites.py docs build/docs-links

Links to the site itself are checked by `links.py`. The exit status is 1 if another site reports
that a page does not exist. Sites that cannot be reached, or that reject programs, are listed and
are no error: without a network the check passes.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

_GONE = (
    "404",
    "410",
    "Not Found",
    "Gone",
    "Anchor",
)  # answers of a site for a missing page


def sorted_out(links: Iterable[Mapping[str, str]]) -> tuple[list[str], list[str], int]:
    """Sort results of linkcheck into dead links, links that could not be checked, and a count of
    good ones.
    """
    broken = {}
    unknown = {}
    good = set()
    for link in links:
        line = (
            f"{link['filename']}:{link['lineno']}: {link['uri']}: {link['info'] or link['status']}"
        )
        if link["status"] in ("working", "redirected"):
            good.add(link["uri"])
        elif link["status"] == "broken" and any(word in link["info"] for word in _GONE):
            broken.setdefault(link["uri"], line)
        elif link["status"] in ("broken", "timeout", "rate-limited"):
            unknown.setdefault(link["uri"], line)
    return list(broken.values()), list(unknown.values()), len(good)


def main(source: str, output: str) -> int:
    """Run linkcheck, print its findings, and return the exit status."""
    found = Path(output, "output.json")
    found.unlink(missing_ok=True)
    options = [
        "-D",
        "nb_execution_mode=off",
        "-D",
        "linkcheck_timeout=15",
        "-D",
        "linkcheck_retries=2",
    ]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-Q", "-b", "linkcheck", *options, source, output],
        check=False,
    )
    if not found.is_file():
        print(f"linkcheck wrote no {found}: exit status {done.returncode}")
        return 1
    broken, unknown, good = sorted_out(
        map(json.loads, found.read_text(encoding="utf-8").splitlines())
    )
    print("\n".join([*broken, *(f"not checked: {line}" for line in unknown)]))
    print(
        f"links to other sites: {good} good, {len(broken)} lead nowhere, {len(unknown)} could not be checked"
    )
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2]))
