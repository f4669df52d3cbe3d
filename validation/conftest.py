"""Validation skips what its extra is missing for, and collects tests alone, as the tests do."""

from extras import pytest_collect_file as pytest_collect_file
from extras import pytest_collection_modifyitems as pytest_collection_modifyitems
from extras import pytest_runtest_setup as pytest_runtest_setup
