"""XML elements of exported robots: numbers in full, comments in lines."""

from collections.abc import Iterable
from typing import Any
from xml.etree import ElementTree

Element = ElementTree.Element


def add(parent: Element, tag: str, content: Any = None, **attributes: Any) -> Element:
    """Add an element with attributes and maybe a content."""
    element = ElementTree.SubElement(parent, tag, {name: written(value) for name, value in attributes.items()})
    element.text = None if content is None else written(content)
    return element


def written(value: Any) -> str:
    """Write a word, a truth, a number or numbers."""
    if isinstance(value, str):
        return value
    if isinstance(value, Iterable):
        return " ".join(map(written, value))
    if isinstance(value, bool):
        return str(value).lower()
    number = float(value)
    return f"{int(number)}" if number.is_integer() else repr(number)


def comment(lines: Iterable[str]) -> Any:
    """Return a comment of lines."""
    return ElementTree.Comment("\n" + "".join(f"    {line.replace('--', '- -')}\n" for line in lines) + "  ")


def notes(facts: Iterable[str], lost: Iterable[str]) -> Any:
    """Return the comment at the head of a file: the model, and what of the robot it lacks."""
    return comment([*facts, "Not in this file:", *(f"- {sentence}" for sentence in lost)])


def document(root: Element) -> str:
    """Return a file's content."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
