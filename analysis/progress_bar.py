"""Progress bars: on a terminal, or in a notebook as a widget (as text if ipywidgets is missing)."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tqdm import tqdm


def in_notebook() -> bool:
    """Return True if this process is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and "IPKernelApp" in shell.config


def progress_bar(shown: bool, **options: Any) -> tqdm:
    """Make a bar, silent unless it is wanted and there is a terminal or a notebook to show it in.

    Parameters
    ----------
    shown
        True if a bar is wanted.
    options
        Options of tqdm.
    """
    if shown and in_notebook():
        from tqdm.auto import (
            tqdm as bar_of_notebooks,
        )  # loads asyncio, which the command line does not need

        return bar_of_notebooks(**options)
    from tqdm import tqdm  # not at the top: most commands show no progress bar

    return tqdm(disable=None if shown and sys.stderr is not None else True, **options)
