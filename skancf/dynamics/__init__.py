"""Motion: rules of integration, step control, the loop, and what it leaves behind."""

from skancf.dynamics.checkpoint import Checkpoint, read_motion
from skancf.dynamics.energy_momentum import EnergyMomentum
from skancf.dynamics.generalized_alpha import GeneralizedAlpha
from skancf.dynamics.initial import RigidVelocity
from skancf.dynamics.ledger import Ledger, MeshEvent
from skancf.dynamics.midpoint import ImplicitMidpoint
from skancf.dynamics.motion import Motion
from skancf.dynamics.named_state import HasState
from skancf.dynamics.simulate import simulate
from skancf.dynamics.spectrum import Spectrum, spectrum
from skancf.dynamics.steps import EnergyBalance, FixedStep, LocalError, NewtonCount
from skancf.dynamics.trapezoidal import Trapezoidal

__all__ = [
    "Checkpoint",
    "EnergyBalance",
    "EnergyMomentum",
    "FixedStep",
    "GeneralizedAlpha",
    "HasState",
    "ImplicitMidpoint",
    "Ledger",
    "LocalError",
    "MeshEvent",
    "Motion",
    "NewtonCount",
    "RigidVelocity",
    "Spectrum",
    "Trapezoidal",
    "read_motion",
    "simulate",
    "spectrum",
]
