"""What a program that writes files for a person needs: whether it can, whole files, and the usual refusals."""

from frictionloop.quantities.code_version import cited_version
from frictionloop.quantities.optional_libraries import needed
from frictionloop.quantities.units import must_be
from frictionloop.quantities.whole_files import replacing, why_unwritable

__all__ = ["cited_version", "must_be", "needed", "replacing", "why_unwritable"]
