"""How a solve, a path, a motion or an adaptive run ended."""

from enum import Enum


class Status(Enum):
    """How it ended, in words as its value.

    Of the many ways to end, three are what was asked for: ``CONVERGED`` of a solve or a path, ``FINISHED`` of a motion, and
    ``REACHED`` of an adaptive run.

    Examples
    --------
    >>> sk.Status.CONVERGED.value, sk.Status.CONVERGED.ok
    ('converged', True)
    """

    CONVERGED = "converged"
    FINISHED = "finished"
    REACHED = "the asked accuracy is reached"

    STEPS_SPENT = "iteration limit reached"
    DIVERGED = "residual grew"
    NOT_FINITE = "residual is not finite"
    SINGULAR = "tangent is singular"
    TOO_FAR = "the first correction goes too far"
    ROUNDING = "rounding leaves the answer open"
    UNBALANCED = "a balance left its tolerance"

    STEP_TOO_SMALL = "the step became too small"
    LIMIT_POINT = "limit point"
    BIFURCATION = "bifurcation"
    MECHANISM = "a mechanism is free"
    CONTRADICTORY = "conditions contradict each other"
    FOLDED = "an element folded"
    TURNED_BACK = "the path turned back"
    NOT_REACHED = "the asked end was not reached"

    BUDGET = "the budget is spent"
    NO_LIMIT = "the number has no limit"
    UNMARKED = "the next mesh would be the same"

    INTERRUPTED = "interrupted from the keyboard"
    FAILED = "an error on the way"
    UNFINISHED = "read from its folder before its end"

    @property
    def ok(self) -> bool:
        """Whether it worked: the asked end was reached, and no check took that away.

        Every result has this word of its own, with the same meaning.
        """
        return self in (Status.CONVERGED, Status.FINISHED, Status.REACHED)
