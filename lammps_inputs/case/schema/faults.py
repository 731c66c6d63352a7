"""Faults of values, and of all keys of a file."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from granwave.lammps_inputs.case.hints import Usual, impossible, unusual
from granwave.lammps_inputs.errors import InputError, InputFault, Mismatch, fault_of
from granwave.lammps_inputs.message_words import show

_LOG = logging.getLogger("granwave")


class ValidationError(Exception):
    """Error of a value that is not valid for its key.

    Parameters
    ----------
    expected
        Valid values, in words.
    key, found
        Key inside of the value, a table, and the value there; empty if the value itself is invalid.
    """

    def __init__(self, expected: str, key: str = "", found: Any = None) -> None:
        super().__init__(expected)
        self.expected = expected
        self.key = key
        self.found = found

    def below(self, name: str, value: Any) -> ValidationError:
        """Return the error as an error of the table that contains the value."""
        found = self.found if self.key else value
        return ValidationError(self.expected, ".".join(filter(None, (name, self.key))), found)


def refuse_if(wrong: object, expected: str) -> None:
    """Raise `ValidationError` with the ``expected`` value if a value is invalid."""
    if wrong:
        raise ValidationError(expected)


@dataclasses.dataclass
class ErrorList:
    """Faults of one file.

    Attributes
    ----------
    source
        Name of the file, as shown to the user.
    overridden
        Dotted keys that were changed by the caller; their faults are none of the file.
    vocabulary
        All dotted keys, for suggestions.
    items
        The faults.
    notes
        Warnings: values that are valid but probably not meant.
    """

    source: str
    overridden: Collection[str] = ()
    vocabulary: Sequence[str] = ()
    items: list[InputFault] = dataclasses.field(default_factory=list)
    notes: list[str] = dataclasses.field(default_factory=list)

    @property
    def lines(self) -> list[str]:
        """The faults as text, one line each."""
        return [str(item) for item in self.items]

    def add(self, key: str, what: str | Mismatch) -> None:
        """Add a fault of the dotted ``key``: a sentence, or the found and expected values."""
        top_down = [key.rsplit(".", n)[0] for n in range(key.count(".") + 1)]
        # a changed kind decides which keys its table needs
        kind = f"{key.rpartition('.')[0]}.kind"
        changed = any(name in self.overridden for name in (*top_down, kind))
        if isinstance(what, Mismatch):
            parts = (what.found, what.expected, what.remedy)
            what = Mismatch(*(" ".join(part.split()) for part in parts))
        else:
            what = " ".join(what.split())
        source = "" if changed else self.source
        self.items.append(fault_of(what, source=source, key=key, changed=changed))

    def add_wrong(self, key: str, value: Any, error: ValidationError) -> None:
        """Add the fault of an invalid value of a key, or of a value in it."""
        inner = f"{key}.{error.key}" if error.key else key
        found = error.found if error.key else value
        self.add(inner, Mismatch(show(found), error.expected))

    def add_unknown(self, key: str, message: str) -> None:
        """Add the fault of an unknown key; if a change of the case made this table, name the key of
        the change.
        """
        inner = (name for name in self.overridden if name.startswith(f"{key}."))
        self.add(next(inner, key), message)

    def check(self, *rows: tuple[object, str, str | Mismatch]) -> None:
        """Add the faults of rows whose first entry is true: condition, key and fault."""
        for wrong, key, what in rows:
            if wrong:
                self.add(key, what)

    def check_first(self, *rows: tuple[object, str, str | Mismatch]) -> bool:
        """Add the fault of the first row whose first entry is true; True if there is none."""
        for wrong, key, what in rows:
            if wrong:
                self.add(key, what)
                return False
        return True

    def check_names(self, entries: Mapping[str, Any]) -> None:
        """Add a fault for each entry of an array of tables, by key, that has the name of an earlier
        one.
        """
        earlier: set[str] = set()
        for key, entry in entries.items():
            if entry.name in earlier:
                self.add(f"{key}.name", Mismatch(f"{show(entry.name)} twice", "a unique name"))
            earlier.add(entry.name)

    def check_size(self, key: str, value: Any, unit: str | Usual | None, shown: str) -> None:
        """Add a fault if a value is impossible in its unit, a note if it is unusual."""
        if expected := impossible(value, unit_name(unit)):
            self.add(key, Mismatch(shown, expected))
        elif isinstance(unit, Usual) and (odd := unusual(value, unit)):
            self.notes.append(f"{key}: {odd}")

    def extend(self, items: Iterable[InputFault]) -> None:
        """Add faults that another reader found."""
        self.items.extend(items)

    def report(self, name: str) -> None:
        """Log the notes as warnings that name the case; raise InputError if there are faults."""
        for note in self.notes:
            _LOG.warning("%s: %s", name, note)
        self.notes.clear()
        if self.items:
            raise InputError(self.items)


def unit_name(unit: str | Usual | None) -> str:
    """Return the name of a unit; empty if there is none."""
    return unit.unit if isinstance(unit, Usual) else unit or ""
