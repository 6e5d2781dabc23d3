"""Is the thin theory enough? What it leaves out, measured by what it knows."""

from skancf.thinness.forces import BILINEAR, shear_forces
from skancf.thinness.form import Fields, ShearForm, share_of
from skancf.thinness.moments import moment_rates
from skancf.thinness.rim import Rim, rim_of
from skancf.thinness.validity import warn_if_mass_is_off
from skancf.thinness.vibration import first_share, product_of, rotary_inertia, with_shear

__all__ = [
    "BILINEAR", "Fields", "Rim", "ShearForm", "first_share", "moment_rates",
    "product_of", "rim_of", "rotary_inertia", "share_of", "shear_forces", "warn_if_mass_is_off",
    "with_shear",
]  # fmt: skip
