"""Units, the common error, linear systems and safe file writing: no domain knowledge."""

from frictionloop.quantities.lti import Array, Complex, Lti
from frictionloop.quantities.units import FrictionloopError, must_be, unit_of
from frictionloop.quantities.value_checks import check_each_once, check_known
from frictionloop.quantities.whole_files import replacing, why_unwritable
