"""Pieces of the results page."""

from typing import Any


def title(text: str, mark: str) -> str:
    return f"\n{text}\n{mark * len(text)}\n\n"


def table(header: list[str], rows: list[list[str]], caption: str = "") -> str:
    """A list-table."""
    lines = [f".. list-table:: {caption}".rstrip(), "   :header-rows: 1", "   :class: numbers", ""]
    for row in [header, *rows]:
        lines += [f"   {'*' if k == 0 else ' '} - {cell}" for k, cell in enumerate(row)]
    return "\n".join(lines) + "\n\n"


def chart(file: str, alt: str) -> str:
    """A picture that keeps its size on a phone and scrolls there."""
    return f".. container:: wide-chart\n\n   .. image:: {file}\n      :alt: {alt}\n\n"


def number(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.3g}"


def machine(stored: dict[str, Any]) -> str:
    """What the numbers depend on, as text."""
    facts = stored["machine"]
    programs = [f"{name}: {version}" for name, version in stored.get("versions", {}).items()]
    packages = ", ".join(f"{name} {version}" for name, version in facts["versions"].items() if version)
    text = (f"{facts['processor']}, {facts['cores']} cores, {facts['memory_gb']} GB, {facts['system']}, "
            f"Python {facts['python']}; {packages}.")  # fmt: skip
    return text + (f" Programs: {'; '.join(programs)}." if programs else "")


def literal(text: str) -> str:
    """What a program said, on one line and as it is."""
    return "``" + " ".join(text.replace("`", "'").split()) + "``" if text.strip() else ""
