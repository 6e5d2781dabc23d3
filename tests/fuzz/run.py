"""Runs of properties: bounded and repeatable, or by chance until a time is over."""

from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings

from fuzz.properties import Property
from skancf.showing import in_full

PROFILE: dict[str, Any] = {
    "database": None, "deadline": None, "print_blob": False, "report_multiple_bugs": False,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large],
}  # fmt: skip


class Failure(AssertionError):
    """The smallest example found, and the error; ``script`` is Python that repeats it."""

    def __init__(self, name: str, example: Any, error: BaseException) -> None:
        self.name, self.example, self.error = name, example, error
        super().__init__(f"{name}: {error}\n{self.script}")

    @property
    def script(self) -> str:
        return SCRIPT.format(name=self.name, error=str(self.error).splitlines()[0], example=in_full(self.example))


SCRIPT = """# {error}
# Run with PYTHONPATH=tests.
from fuzz.statement import *

PROPERTIES[{name!r}].holds(
    {example}
)
"""


def run(name: str, of: Property, examples: int | None = None, chance: int | None = None, shrink: bool = True) -> None:
    """Failure unless the property holds: always the same examples, or those of a seed."""
    last: list[Any] = []

    def holds(example: Any) -> None:
        last[:] = [example]
        of.holds(example)

    phases = [Phase.generate, Phase.shrink] if shrink else [Phase.generate]
    options = {**PROFILE, "phases": phases, "derandomize": chance is None}
    test = settings(max_examples=examples or of.examples, **options)(given(of.given)(holds))
    if chance is not None:
        test = seed(chance)(test)
    try:
        test()
    except Exception as error:
        # Hypothesis runs the smallest failing example last.
        raise Failure(name, last[0] if last else None, error) from error


def keep(failure: Failure, folder: Path, number: int) -> Path:
    """The failure's script in a file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{failure.name.replace(' ', '_')}_{number}.py"
    path.write_text(failure.script)
    return path
