"""State of a search or design whose runs a tank makes: a journal from which it resumes after any interruption."""

from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from hypertuna.description.provenance import journal_header
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.io.checkpoint import Journal, read_header
from hypertuna.io.files import Closing


class TankState(Closing):
    """A search or design whose runs a tank makes. Its journal holds the whole state, so that it goes on when reopened.

    A new one needs its options; a journal already holds them.
    """

    kind: ClassVar[str]  # kind of the journal
    names: ClassVar[frozenset[str]]  # names of the options
    command: ClassVar[str]  # command whose first call starts it
    example: ClassVar[str]  # options of such a first call, shown in an error
    ignored: ClassVar[tuple[str, ...]] = ("isa",)  # parts of a journal's header that may change when it is reopened

    def __init__(self, path: str | Path | None, options: Mapping[str, Any] | None = None) -> None:
        options = self._options_of(path) if options is None else options
        header = journal_header(self.kind, self._begin(path, options), options)
        compared = {name: value for name, value in header.items() if name not in self.ignored}
        self._journal = Journal(path, compared, measured=True)
        try:
            for k, record in enumerate(self._journal.records):
                self._replay(record, f"{path}:{k + 2}")
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._journal.close()

    @abstractmethod
    def _begin(self, path: str | Path | None, options: Mapping[str, Any]) -> Robot:
        """Set up from the options; return the robot."""

    @abstractmethod
    def _replay(self, record: Mapping[str, Any], place: str) -> None:
        """Take the measurements in a record of the journal as if they were made now."""

    @classmethod
    def _options_of(cls, path: str | Path | None) -> dict[str, Any]:
        """Return the options that a journal holds."""
        if path is None or not Path(path).exists():
            fix = f"start one, for example `hypertuna {cls.command} --state {path} {cls.example}`"
            raise InputError("does not exist", file=str(path), fix=fix)
        header = read_header(path)
        options: dict[str, Any] = header.get("options", {})
        if header.get("kind") != cls.kind:
            rule = f"must be the state of `hypertuna {cls.command}`"
            raise InputError(rule, file=str(path), value=str(header.get("kind")), fix="give another file")
        if not cls.names <= options.keys():
            rule, fix = "does not hold the options of its first call", "use the version of hypertuna that started it"
            raise InputError(rule, file=f"{path}:1", fix=fix)
        return options
