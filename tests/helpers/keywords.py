"""Comparison of the options of a command with the keywords of its Python function."""

from __future__ import annotations

import argparse
import inspect

import granwave as gw
from granwave.workflows.cli.parser import commands


def check_keywords(name: str, *own: str) -> None:
    """Assert that the options of a command are keywords of its function, with the same defaults.

    Parameters
    ----------
    own
        Options that exist only on the command line, apart from options that change keys or print
        JSON.
    """
    (command,) = (command for command in commands() if command.name == name)
    parser = argparse.ArgumentParser()
    actions = [
        parser.add_argument(*option.names, **option.settings) for option in command.each_option()
    ]
    keywords = inspect.signature(getattr(gw, name)).parameters
    for action in actions:
        if action.option_strings and action.dest not in ("overrides", "json", *own):
            assert action.dest in keywords, action.dest
            default = keywords[action.dest].default
            same = action.dest == "figures" or action.required or default == action.default
            assert same, f"{action.dest}: {default}, {action.default}"
