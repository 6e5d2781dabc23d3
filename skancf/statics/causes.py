"""Why an equilibrium was not reached, and the way out."""
from skancf.assembly.constrain import free_rigid_motions
from skancf.errors import InputError
from skancf.statics.newton import System


def hold_rigid_motions(system: System) -> None:
    """InputError where a rigid motion is free; of models of other nodes than four vectors nothing is known."""
    free = free_rigid_motions(system.undeformed, system.constraints) if system.pattern.block == 12 else []
    if free:
        raise InputError(f"no equilibrium: the supports leave free {', '.join(free)}; add supports that hold them")
