"""The page of commands, made of the parser."""

from __future__ import annotations

import argparse
import re

from granwave.analysis.exports.export import FORMATS
from granwave.analysis.films import QUANTITIES, VIEWS
from granwave.workflows.cli.parser import make_parser


def test_no_description_begins_with_an_accepted_value():
    """The page makes a sentence of it: a word that must be typed would get a capital."""
    accepted = {*FORMATS, *QUANTITIES, *VIEWS}
    (verbs,) = (action for action in make_parser()._actions if isinstance(action, argparse._SubParsersAction))
    for name, verb in verbs.choices.items():
        for action in verb._actions:
            first = re.split(r"[ ,;:(]", action.help or "")[0]
            words = accepted | set(map(str, action.choices or ()))
            assert first and first not in words and not first.startswith((".", "-")), f"granwave {name}: {action.help}"
