"""Problems and results in files: documented, versioned, without code."""

from skancf.storage.files import load, save
from skancf.storage.problem_file import ProblemFile, read_problem
from skancf.storage.run_file import FileRun, run_file
from skancf.storage.splined import Splined
from skancf.storage.stored import StoredFields, StoredState

__all__ = ["FileRun", "ProblemFile", "Splined", "StoredFields", "StoredState", "load", "read_problem", "run_file", "save"]
