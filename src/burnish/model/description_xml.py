"""A description file as plain elements and numbers, read so that no file can cost much time or memory."""

from __future__ import annotations

import re
import stat
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

import numpy as np

from burnish.core import Array
from burnish.errors import DescriptionError

MAX_BYTES = 10 * 2**20
"""Largest file that is opened [B]. A description without its meshes has some 10 kB; 10 MiB take half a second."""
MAX_ELEMENTS = 10_000
MAX_ATTRIBUTES = 100_000
MAX_ATTRIBUTE_CHARACTERS = 4 * 2**20
MAX_DEPTH = 100
MAX_NUMBER = 1e12
"""Largest number in SI units that anything about an arm can have; what is beyond is a slip, and may overflow."""
TRIANGLE_TOLERANCE = 1e-6
"""By how much, of the largest principal moment, the triangle inequality may fail: numbers printed to six digits."""

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NOT_FINITE = re.compile(r"(?<![\w./])[+-]?(nan|inf|infinity)(?![\w./])", re.ASCII | re.IGNORECASE)
_NAMES = frozenset(
    "name link joint body body1 body2 geom site mesh material texture filename file class childclass type model parent "
    "child version meshdir texturedir assetdir package uri xmlns tendon target refsite cranksite slidersite".split()
)
"""Attributes that hold names, in which "inf" is a name."""


@dataclass
class Element:
    """One XML element with its place in the file."""

    tag: str
    attributes: Mapping[str, str]
    line: int
    children: list[Element] = field(default_factory=list)

    def all(self, *tags: str) -> list[Element]:
        """Its children of these tags."""
        return [child for child in self.children if child.tag in tags]

    def only(self, tag: str) -> Element | None:
        """Its one child of this tag, or None; more than one is refused."""
        found = self.all(tag)
        if len(found) > 1:
            raise fault(found[1], f"a second <{tag}> in one <{self.tag}>", "one", "delete one of them")
        return found[0] if found else None

    def need(self, tag: str) -> Element:
        """Its one child of this tag, which must be there."""
        child = self.only(tag)
        if child is None:
            raise fault(self, f"no <{tag}> in <{self.tag}>", "one", "add it")
        return child

    def walk(self) -> Iterator[Element]:
        """Itself and all below."""
        pending = [self]
        while pending:
            element = pending.pop()
            yield element
            pending.extend(reversed(element.children))

    def text(self, attribute: str) -> str:
        """A name that must be there and not empty."""
        value = self.attributes.get(attribute, "")
        if not value.strip():
            raise fault(self, f"no '{attribute}' in <{self.tag}>", "a name", "add it")
        return value

    def numbers(self, attribute: str, *sizes: int) -> Array | None:
        """Numbers of an attribute, or None without it.

        Args:
            attribute: its name.
            sizes: how many numbers there may be.
        """
        value = self.attributes.get(attribute)
        if value is None:
            return None
        tokens = value.split(maxsplit=max(sizes) + 1) if len(value) < 4096 else []
        if len(tokens) not in sizes:
            expected = f"{' or '.join(map(str, sizes))} numbers"
        elif not all(len(token) <= 64 and _NUMBER.fullmatch(token) for token in tokens):
            expected = "finite numbers with a decimal point, separated by blanks"
        elif max(abs(float(token)) for token in tokens) > MAX_NUMBER:
            expected = f"numbers of at most {MAX_NUMBER:g} in SI units"
        else:
            return np.array([float(token) for token in tokens])
        raise fault(self, f"{attribute}={quoted(value)} in <{self.tag}>", expected, "mend it")

    def number(self, attribute: str) -> float | None:
        """One number of an attribute, or None without it."""
        values = self.numbers(attribute, 1)
        return None if values is None else float(values[0])

    def required(self, attribute: str, *sizes: int) -> Array:
        """Numbers of an attribute that must be there."""
        values = self.numbers(attribute, *sizes)
        if values is None:
            raise fault(self, f"no '{attribute}' in <{self.tag}>", "it to be given", "add it")
        return values


def fault(element: Element, found: str, expected: str, remedy: str) -> DescriptionError:
    """The refusal of an element, in one line."""
    return DescriptionError(f"line {element.line}: found {found}; expected {expected}: {remedy}")


def quoted(text: str) -> str:
    """A name from the file, safe to print: on one line, at most 60 characters, no control characters."""
    return ascii(text if len(text) <= 60 else text[:57] + "...")


def read(path: str | Path) -> Element:
    """The root element of a file.

    Raises:
        DescriptionError: if the file is missing, empty, no text, too large, too deep, or not well-formed XML, or if
            it has a DOCTYPE, which could define entities that grow without end.
    """
    root: list[Element] = []
    stack: list[Element] = []
    spent = [0, 0]
    parser = expat.ParserCreate("UTF-8")

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, parser.CurrentLineNumber)
        spent[0] += 1
        spent[1] += sum(map(len, attributes.values()))
        if spent[0] > MAX_ELEMENTS or spent[1] > MAX_ATTRIBUTE_CHARACTERS or len(stack) >= MAX_DEPTH:
            raise DescriptionError(
                f"line {element.line}: found more than {MAX_ELEMENTS} elements, {MAX_DEPTH} levels or "
                f"{MAX_ATTRIBUTE_CHARACTERS >> 20} MiB of attributes; expected an arm: keep meshes in other files"
            )
        (stack[-1].children if stack else root).append(element)
        stack.append(element)

    def doctype(*_: object) -> None:
        raise DescriptionError(
            f"line {parser.CurrentLineNumber}: found a DOCTYPE; expected none, as it can define entities: delete it"
        )

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: stack.pop()
    parser.StartDoctypeDeclHandler = doctype
    data = _bytes(path)
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        reason = expat.errors.messages[error.code]
        raise DescriptionError(f"line {error.lineno}: found {reason}; expected well-formed XML: mend it") from None
    _refuse_not_finite(root[0], data)
    return root[0]


def check_inertia(element: Element, who: str, mass: float, tensor: Array) -> None:
    """Refuse what no body can have: a mass that is not positive, or an impossible inertia about its centre.

    Args:
        element: where it stands.
        who: whose it is, for the message.
        mass: mass [kg].
        tensor: inertia about the centre of mass [kg·m²], (3, 3), symmetric.
    """
    if mass <= 0.0:
        raise fault(element, f"mass {mass:g} kg of {who}", "more than 0", "weigh it, or leave out its <inertial>")
    a, b, c = np.linalg.eigvalsh(tensor)
    moments = f"principal moments of inertia {a:.4g}, {b:.4g}, {c:.4g} kg m^2 of {who}"
    if a <= 1e-12 * max(c, 0.0):
        raise fault(element, moments, "all of them above 0", "mend its <inertial>")
    if c > a + b + TRIANGLE_TOLERANCE * c:
        raise fault(element, moments, "the largest to be at most the sum of the others", "mend its <inertial>")


def _bytes(path: str | Path) -> bytes:
    """What is in a regular file of a permitted size that holds text and may be an arm."""
    try:
        file = Path(path)
        status = file.stat()
        if not stat.S_ISREG(status.st_mode):
            raise DescriptionError("found no regular file; expected a URDF or MJCF file: give its path")
        if status.st_size > MAX_BYTES:
            raise DescriptionError(
                f"found {status.st_size / 2**20:.0f} MiB; expected at most {MAX_BYTES >> 20}: "
                "keep meshes in files of their own"
            )
        with file.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise DescriptionError(
            f"found no file to read ({reason}); expected a URDF or MJCF file: give its path"
        ) from None
    if not data.strip():
        raise DescriptionError("found an empty file; expected a URDF or MJCF file: give another path")
    if b"\0" in data:
        raise DescriptionError("found a binary or UTF-16 file; expected URDF or MJCF text: save it as UTF-8")
    if data.count(b"<") > 4 * MAX_ELEMENTS or data.count(b"=") > MAX_ATTRIBUTES:
        raise DescriptionError(
            f"found more than {MAX_ELEMENTS} elements or {MAX_ATTRIBUTES} attributes; expected an arm: thin it out"
        )
    return data


def _refuse_not_finite(root: Element, data: bytes) -> None:
    """Refuse NaN and infinity wherever a number may stand, known to us or not."""
    lowered = data.lower()
    if b"nan" not in lowered and b"inf" not in lowered:
        return
    for element in root.walk():
        for name, value in element.attributes.items():
            if name not in _NAMES and _NOT_FINITE.search(value):
                raise fault(element, f"{name}={quoted(value)} in <{element.tag}>", "finite numbers", "mend it")
