"""Progress bars on terminals, in logs and in notebooks."""

from __future__ import annotations

import sys
import types
import warnings

import pytest

from granwave.analysis.progress_bar import in_notebook, progress_bar


@pytest.fixture
def ipython(monkeypatch):
    """Stand-in for IPython, whose configuration tells what runs in it."""
    module, shell = types.ModuleType("IPython"), types.SimpleNamespace(config={})
    module.get_ipython = lambda: shell
    monkeypatch.setitem(sys.modules, "IPython", module)
    return shell


def test_no_terminal_no_bar():
    assert not in_notebook()
    assert progress_bar(True, total=2).disable and progress_bar(False, total=2).disable


def test_a_notebook_has_a_bar_without_a_terminal(ipython):
    assert not in_notebook()  # IPython at a terminal
    ipython.config["IPKernelApp"] = {}
    assert in_notebook()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of tqdm, that ipywidgets are missing
        bar = progress_bar(True, total=2, leave=False)
    assert not bar.disable
    bar.close()
    assert progress_bar(False, total=2).disable


def test_outside_of_ipython_nothing_is_a_notebook(ipython):
    sys.modules["IPython"].get_ipython = lambda: None
    assert not in_notebook()
