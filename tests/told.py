"""Files of tests, and what their readers say is wrong with them."""

from __future__ import annotations

import pytest

import hypertuna as ht


def write(path, *lines):
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def told(call, *arguments, **options):
    """What a call says is wrong, in one line."""
    with pytest.raises(ht.InputError) as error:
        call(*arguments, **options)
    sentence = str(error.value)
    assert "\n" not in sentence
    return sentence


def tried(call, *arguments):
    """What a call returns, or says is wrong."""
    try:
        return call(*arguments), ""
    except ht.InputError as error:
        return None, str(error)
