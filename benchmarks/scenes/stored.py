"""Reference series that ``python -m benchmarks.references`` has stored beside this file."""

import json
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "series"


def read(name: str) -> dict[str, Any]:
    """``times``, ``values`` by quantity, and ``uncertainty``."""
    return dict(json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8")))
