"""Folder of the files of a search."""

from __future__ import annotations

import pytest
import tomli_w

from tests.extensions.design.chain_search import CHAIN, TABLES


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("design")
    (found / "chain.toml").write_text(CHAIN)
    (found / "beads.toml").write_text(tomli_w.dumps(TABLES))
    return found
