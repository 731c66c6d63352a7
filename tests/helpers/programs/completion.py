"""Completion of a command line, as a shell asks for it."""

from __future__ import annotations

from argcomplete.finders import CompletionFinder
from argcomplete.lexers import split_line

from granwave.workflows.cli.completion import with_completers
from granwave.workflows.cli.parser import make_parser


def completed(line: str) -> list[str]:
    """Return what a line is completed by; a shell cuts what stands before "=" itself."""
    quote, prefix, _, words, _ = split_line(line)
    finder = CompletionFinder(with_completers(make_parser()), always_complete_options=False)
    return [word.strip() for word in finder._get_completions(words, prefix, quote, None)]
