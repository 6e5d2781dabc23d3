"""Compiled kernels are kept between processes, one for each set of types."""

import json
import os
import subprocess
import sys

import pytest

# Statics, dynamics by both kinds of rules, and a mass matrix: the kernels that most runs need.
RUN = """
import json, sys
import numba
import skancf as sk
strip = sk.Problem(
    sk.Rectangle(2.0, 1.0), 0.1, sk.Isotropic(1e6, 0.3, 1e3), supports=[sk.Clamp("left")],
    loads=[sk.EdgeLoad("right", (0.0, 0.0, 1.0))],
)
system = strip.on(sk.meshes.uniform(strip.surface, 2, 1), THEORY)
sk.solve(system).unwrap()
sk.simulate(system, 0.02, dt=0.01, progress=False)
sk.simulate(system, 0.02, dt=0.01, rule=sk.EnergyMomentum(), progress=False)

kernels = {}
for module in [module for name, module in sys.modules.items() if name.startswith("skancf.")]:
    for value in vars(module).values():
        if isinstance(value, numba.core.dispatcher.Dispatcher) and value.signatures:
            hits, misses = (sum(counts.values()) for counts in (value.stats.cache_hits, value.stats.cache_misses))
            kernels[f"{value.py_func.__module__}.{value.__name__}"] = hits, misses, len(value.signatures)
print(json.dumps(kernels))
"""
FORCES = {
    "kirchhoff": ("kirchhoff.kernels", "kirchhoff.between_kernel.force_between"),
    "full": ("full.residual_kernel", "full.tangent_kernel.tangent"),
}


def kernels_used(theory: str) -> dict[str, list[int]]:
    """Loaded, compiled and all signatures of each compiled function that a fresh process calls."""
    environment = {**os.environ, "SKANCF_THREADS": "1"}
    code = [sys.executable, "-c", RUN.replace("THEORY", repr(theory))]
    shown = subprocess.run(code, capture_output=True, text=True, env=environment, check=True)
    return json.loads(shown.stdout)


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_a_second_process_compiles_nothing(theory):
    kernels_used(theory)  # compiles what is not there yet
    used = kernels_used(theory)
    assert all(misses == 0 and hits == signatures for hits, misses, signatures in used.values()), used
    # Types of arguments do not differ between callers: each is compiled, and loaded, once.
    assert all(signatures == 1 for _, _, signatures in used.values()), used
    names = " ".join(used)
    for wanted in (*FORCES[theory], "kernels.gather.mass", "linear.kernels.multiply"):
        assert wanted in names, (wanted, names)
