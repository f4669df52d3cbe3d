"""The page of the ledger, drawn once."""

from pathlib import Path

import pytest

from hypertuna.paper.page import write_ledger
from hypertuna.paper.reproduce import Ledger, ledger_sections
from hypertuna.reports.html import Section


@pytest.fixture(scope="session")
def sections(ledger: Ledger) -> list[Section]:
    return ledger_sections(ledger)


@pytest.fixture(scope="session")
def folder(ledger: Ledger, sections: list[Section], tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hypertuna.paper.page.ledger_sections", lambda _: sections)  # drawn once
        return write_ledger(ledger, tmp_path_factory.mktemp("paper") / "demo").parent
