"""Commands about the package: built-in studies, keys, speed and help; each returns the exit status."""

from __future__ import annotations

import argparse
import dataclasses
import json
import shutil
import sys
import textwrap

from granwave.lammps_inputs.directories import refuse_other_file
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import replace_text
from granwave.lammps_inputs.streams import is_terminal
from granwave.workflows import library
from granwave.workflows.cli.terminal import BOLD, coloured, print_json

_USUAL_WIDTH = 120  # characters of a line where there is no terminal


def cases(options: argparse.Namespace) -> int:
    """Execute ``granwave cases``."""
    wanted = [word.lower() for word in options.words]
    found = [
        entry
        for entry in library.entries()
        if all(word in f"{entry.name} {entry.title}".lower() for word in wanted)
    ]
    if not found:
        raise InputError(
            f"{' '.join(options.words)}: no built-in case or scan contains these words; "
            "granwave cases lists all"
        )
    if options.json:
        print_json([entry._asdict() for entry in found])
        return 0
    name_width = max(len(entry.name) for entry in found)
    on_terminal = is_terminal(sys.stdout)
    most = shutil.get_terminal_size().columns if on_terminal else sys.maxsize
    width = (most if on_terminal else _USUAL_WIDTH) - 2
    briefly = not (options.all or wanted)
    for group in dict.fromkeys(entry.group for entry in found):
        print(coloured(f"{group}:", BOLD, sys.stdout))
        here = [entry for entry in found if entry.group == group]
        lines = [f"{entry.kind}  {entry.name:{name_width}}  {entry.title}" for entry in here]
        if briefly:
            names = "  ".join(entry.name for entry in here)
            wrapped = textwrap.wrap(names, width, break_on_hyphens=False, break_long_words=False)
            lines = [f"  {line}" for line in wrapped]
        print("\n".join(line if len(line) <= most else f"{line[: most - 1]}…" for line in lines))
    if briefly:
        print(
            "granwave cases WORD describes the cases and scans with this word, --all describes "
            "all; granwave show NAME prints a file"
        )
    return 0


def show(options: argparse.Namespace) -> int:
    """Execute ``granwave show``."""
    sys.stdout.write(library.text(options.name))
    return 0


def keys(options: argparse.Namespace) -> int:
    """Execute ``granwave keys``."""
    from granwave.workflows.cli.keys.json_schema import schema_of
    from granwave.workflows.cli.keys.reference import as_text, find, overview, tables
    from granwave.workflows.cli.tables.quantity_texts import is_quantity, quantity_text

    if options.schema:
        print(json.dumps(schema_of(options.schema), indent=1))
        return 0
    name = " ".join(options.table)
    if is_quantity(name) and not options.json:
        print(quantity_text(name))
        return 0
    found = find(*options.table) if options.table else None
    if options.json:
        print_json([dataclasses.asdict(one) for one in found or tables()])
    else:
        print(overview() if found is None else "\n\n\n".join(map(as_text, found)))
    return 0


def quantities(options: argparse.Namespace) -> int:
    """Execute ``granwave quantities``."""
    from granwave.workflows.cli.tables.quantity_texts import all_quantities, quantity_text

    texts = [quantity_text(name) for name in options.names]
    print("\n\n".join(texts) or all_quantities())
    return 0


def bench(options: argparse.Namespace) -> int:
    """Execute ``granwave bench``."""
    from granwave.workflows.bench import bench as run_bench
    from granwave.workflows.bench_lists import compare_lists

    if options.json and not options.json.absolute().parent.is_dir():
        raise InputError(
            f"--json {options.json}: no such directory: {options.json.absolute().parent}"
        )
    if options.json:
        refuse_other_file(options.json, rb'"triad_GB_per_s"')
    results = run_bench(options.parts, options.repeats, {"lists": compare_lists})
    if options.json:
        replace_text(options.json, json.dumps(results, indent=2) + "\n")
    return 0


def show_help(options: argparse.Namespace) -> int:
    """Execute ``granwave help``."""
    print(options.parsers[options.name].format_help(), end="")
    return 0
