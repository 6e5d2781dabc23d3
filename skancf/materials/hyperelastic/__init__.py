"""Laws of rubber: elastic at any stretch, with an energy."""

from skancf.materials.hyperelastic.gent import Gent
from skancf.materials.hyperelastic.mooney_rivlin import MooneyRivlin
from skancf.materials.hyperelastic.neo_hooke import NeoHooke
from skancf.materials.hyperelastic.ogden import Ogden
from skancf.materials.hyperelastic.own import Hyperelastic
from skancf.materials.hyperelastic.yeoh import Yeoh

RUBBERS = [NeoHooke, MooneyRivlin, Ogden, Yeoh, Gent]

__all__ = ["RUBBERS", "Gent", "Hyperelastic", "MooneyRivlin", "NeoHooke", "Ogden", "Yeoh"]
