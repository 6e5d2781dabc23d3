"""Laws of rubber: elastic at any stretch, with an energy."""

from skancf.materials.hyperelastic.neo_hooke import NeoHooke

__all__ = ["NeoHooke"]
