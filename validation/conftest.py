"""Validation skips what its extra is missing for, as the tests do."""

from extras import pytest_runtest_setup as pytest_runtest_setup
