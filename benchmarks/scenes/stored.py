"""Reference values that ``python -m benchmarks.references`` has stored in the folder ``references``."""

import json
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "references"


def read(name: str) -> dict[str, Any]:
    """Values by quantity for ``thin``, perhaps for ``thick``, the relative ``uncertainty``, perhaps ``times``."""
    file = FOLDER / f"{name}.json"
    return dict(json.loads(file.read_text(encoding="utf-8")))


def references(name: str, quantity: str, small: float | None = None, doubt: float = 0.0) -> dict[str, Any]:
    """What :class:`Quantity` takes: ``reference`` and ``uncertainty`` by theory, that of small strains too, if any."""
    found = read(name)
    theories = [theory for theory in ("thin", "thick") if theory in found]
    reference = {theory: _frozen(found[theory][quantity]) for theory in theories}
    uncertainty = dict.fromkeys(theories, found["uncertainty"])
    if small is not None:
        reference["small"], uncertainty["small"] = small, doubt
    return {"reference": reference, "uncertainty": uncertainty}


def _frozen(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
