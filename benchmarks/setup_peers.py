"""Installs the programs that skancf is compared with, each in an environment of its own below ``benchmarks/peers``;
those of ``packages.txt`` into the system.

    python -m benchmarks.setup_peers [NAME ...]

A folder says what its program needs: ``requirements.txt`` for pip, ``packages.txt`` for Debian's apt. One that cannot be
installed is named with the reason, and the comparison then shows it as not installed.
"""

import argparse
import shutil
import subprocess
import sys
import venv
from pathlib import Path

PEERS = Path(__file__).resolve().parent / "peers"
READY = "ready"
"""File in an environment whose program is installed."""


def ready(name: str) -> Path | None:
    """The interpreter of a program's environment; None where the program is not installed."""
    environment = PEERS / name / ".venv"
    return environment / "bin" / "python" if (environment / READY).exists() else None


def listed(file: Path) -> list[str]:
    lines = (line.split("#")[0].strip() for line in file.read_text(encoding="utf-8").splitlines()) if file.exists() else ()
    return [line for line in lines if line]


def install(folder: Path) -> str:
    """What became of it, in a line."""
    environment = folder / ".venv"
    (environment / READY).unlink(missing_ok=True)
    venv.create(environment, with_pip=True, clear=not (environment / "bin" / "python").exists())
    pip = [str(environment / "bin" / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "numpy", *listed(folder / "requirements.txt")], check=True, stdout=subprocess.DEVNULL)
    packages = listed(folder / "packages.txt")
    if packages:
        if shutil.which("apt-get") is None:
            raise SystemExit(f"it needs the Debian packages {packages}, and there is no apt-get: install them by hand")
        subprocess.run(["apt-get", "update", "-qq"], check=False, stdout=subprocess.DEVNULL)
        subprocess.run(["apt-get", "install", "-qq", "-y", *packages], check=True, stdout=subprocess.DEVNULL)
    (environment / READY).touch()
    return "ready"


def main() -> int:
    names = sorted(folder.name for folder in PEERS.iterdir() if folder.is_dir())
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[[], *names])
    failed = 0
    for name in parser.parse_args().names or names:
        print(f"{name}: ...", end=" ", flush=True)
        try:
            print(install(PEERS / name), flush=True)
        except (subprocess.CalledProcessError, SystemExit) as error:
            failed += 1
            print(f"not installed: {error}"[:200], flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
