"""Measures of signals and waves: arrays in SI units in, numbers out."""

from granwave.workflows.python.measures import *
from granwave.workflows.python.measures import __all__ as __all__
