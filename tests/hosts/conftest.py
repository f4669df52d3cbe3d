"""What the tests of hosts share: the page's code and the core in WebAssembly, both in Node.js."""

from collections.abc import Iterator

import pytest

from host_library import Host, InNode, Native
from studio_code import Page


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    """The page's own code, where bodies are changed and samples are summed up."""
    page = Page()
    yield page
    page.close()


@pytest.fixture(scope="module")
def core() -> Iterator[InNode]:
    """The core in WebAssembly."""
    core = InNode()
    yield core
    core.close()


@pytest.fixture(scope="module", params=[Native, InNode], ids=["native", "wasm"])
def host(request: pytest.FixtureRequest) -> Iterator[Host]:
    """Where the core runs."""
    host: Native | InNode = request.param()
    yield host
    host.close()
