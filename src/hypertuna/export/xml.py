"""XML elements of exported robots: numbers in full precision, comments line by line."""

from collections import Counter
from collections.abc import Iterable
from typing import Any
from xml.etree import ElementTree

from hypertuna.description.robot import Robot
from hypertuna.errors import InputError, shown

Element = ElementTree.Element


def add(parent: Element, tag: str, content: Any = None, **attributes: Any) -> Element:
    """Add an element with attributes, and a text if given, to a parent; return the element."""
    element = ElementTree.SubElement(parent, tag, {name: written(value) for name, value in attributes.items()})
    element.text = None if content is None else written(content)
    return element


def written(value: Any) -> str:
    """Return a word, a truth value, a number or a sequence of numbers as text."""
    if isinstance(value, str):
        return value
    if isinstance(value, Iterable):
        return " ".join(map(written, value))
    if isinstance(value, bool):
        return str(value).lower()
    number = float(value)
    return f"{int(number)}" if number.is_integer() else repr(number)


def comment(lines: Iterable[str]) -> Any:
    """Return a comment element with these lines."""
    return ElementTree.Comment("\n" + "".join(f"    {line.replace('--', '- -')}\n" for line in lines) + "  ")


def notes(facts: Iterable[str], lost: Iterable[str]) -> Any:
    """Return the comment at the head of a file: facts about the model, and the parts of the robot that it lacks."""
    return comment([*facts, "Not in this file:", *(f"- {sentence}" for sentence in lost)])


def check_names(robot: Robot, parts: Iterable[Element], *, alike: bool) -> None:
    """Check that no two parts with the same tag, or with any tag if `alike`, share a name; "world" is taken, too."""
    named = [("" if alike else part.tag, name) for part in parts if (name := part.get("name"))]
    counts = Counter([*named, ("" if alike else "body", "world")])
    for (_, name), times in counts.items():
        if times > 1:
            key = "links.name" if name in robot.links.name else "joints.name"
            rule, fix = "must be no name of the file's own parts", "give it another name"
            raise InputError(rule, file=robot.file or None, key=key, value=shown(name), fix=fix)


def document(root: Element) -> str:
    """Return the text of an XML file from its root element."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
