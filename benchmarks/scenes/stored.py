"""Reference values that ``python -m benchmarks.references`` has stored in the folder ``references``."""

import json
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "references"


def read(name: str) -> dict[str, Any]:
    """Values by quantity for ``thin``, perhaps for ``thick``, the relative ``uncertainty``, perhaps ``times``."""
    file = FOLDER / f"{name}.json"
    return dict(json.loads(file.read_text(encoding="utf-8")))


def references(name: str, quantity: str) -> dict[str, Any]:
    """What :class:`Quantity` takes: ``reference`` and ``uncertainty`` by theory."""
    found = read(name)
    theories = [theory for theory in ("thin", "thick") if theory in found]
    doubt = found["uncertainty"]
    return {
        "reference": {theory: _frozen(found[theory][quantity]) for theory in theories},
        "uncertainty": {theory: doubt[theory] if isinstance(doubt, dict) else doubt for theory in theories},
    }


def _frozen(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
