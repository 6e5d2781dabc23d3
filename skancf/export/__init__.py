"""Problems as files of other programs, and their answers."""

from skancf.export.calculix import calculix
from skancf.export.results import CalculixDeck, CalculixResult, Printed, read_calculix

__all__ = ["CalculixDeck", "CalculixResult", "Printed", "calculix", "read_calculix"]
