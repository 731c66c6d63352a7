"""Closed forms: Hertz's chain and its solitary wave, Hertz's impact."""

from granwave.workflows.python.theory import *
from granwave.workflows.python.theory import __all__ as __all__
