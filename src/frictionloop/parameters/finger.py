"""Parameters of a finger: how its friction varies, and the skin between the friction and the bone."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from frictionloop.parameters.block import Block, NotNegative, Number, Positive
from frictionloop.parameters.kinds import Kinds
from frictionloop.parameters.plant import Friction, FrictionLaw, FrictionLimit


class FingerFriction(FrictionLaw):
    """Friction limit of a finger: f0 (N/N0)^n (v/v0)^p M(t) (1 + n(x)) exp(-tau(t) a^2), physics/friction_limit.

    ``nominal_n`` is the limit at the reference load and speed, just landed, on average over the plate.
    """

    kind: Literal["finger"] = "finger"
    reference_load_n: Positive = 0.5
    """Load N0 at which the limit is ``nominal_n`` (0.49 to 0.64 N in active touch: Smith 2002)."""
    load_exponent: Annotated[Number, Field(ge=0, le=2)] = 0.9
    """Exponent n of the load (2/3 to 1 on smooth glass: Dzidek 2014; 0.79 from Seo 2009; 0.9 is assumed)."""
    speed_slope: Annotated[Number, Field(ge=-1, le=1)] = 0.0
    """Slope p = dlnF/dlnv (-0.15 to 0.15 from person to person, assumed; both signs are published)."""
    reference_speed_mm_s: Positive = 20.0
    """Speed v0 at which the limit is ``nominal_n`` (paper, Sec. 4.2)."""
    slow_mm_s: Positive = 1.0
    """Speed below which the limit no longer depends on it (assumed)."""
    static_ratio: Annotated[Number, Field(ge=1, le=5)] = 1.0
    """Limit after a second at rest over that of sliding; 1 is none (1.44 on one finger: finger-validation).

    A contact ages: dA/dt = 1 - |v| A/D, its limit rises as ln(1 + A/t1) (Baumberger and Caroli 2006).
    """
    static_s: Positive = 0.1
    """Rest t1 after which ageing is felt (assumed)."""
    static_um: Positive = 100.0
    """Way D over which sliding makes a contact young again (assumed: one finger's friction fell within 270 um)."""
    occlusion_ratio: Annotated[Number, Field(gt=0, le=20)] = 2.0
    """Limit after long contact over that just after landing; 1 is none (1 to 10: Adams 2013; 2 is assumed)."""
    occlusion_s: Positive = 20.0
    """Time constant of the rise: 20 s is published as one (Pasumarty 2011, Dzidek 2014).

    "Within 20 s" (PMC5642691), read as 95 %, would be 7 s.
    """
    drying_s: Positive = 20.0
    """Time constant of the recovery while lifted (assumed: as in contact)."""
    moist_loss: Annotated[Number, Field(ge=0, lt=1)] = 0.3
    """Share of tau lost when occlusion is complete (direction: Gueorguiev 2017; 0.3 is assumed)."""
    roughness_rms: Annotated[Number, Field(ge=0, le=0.3)] = 0.05
    """Standard deviation of n(x) over the plate (0.02 to 0.10, assumed; within 0.10 in Derler & Rotaru)."""
    roughness_longest_mm: Positive = 100.0
    """Longest wavelength of n(x), after which it repeats; the shortest is 1/1024 of it (assumed)."""


class RigidFinger(Block):
    """No skin: the friction force equals its limit at once (paper, Sec. 2)."""

    kind: Literal["rigid"] = "rigid"


class Skin(Block):
    """Fingertip in the sliding direction: mass, spring and damper in series with the contact (physics/contact)."""

    kind: Literal["skin"] = "skin"
    stiffness_n_m: Positive = 1000.0
    """Stiffness k (robomechjournal 10.1186/s40648-017-0080-8, Table 1; 500 to 2000 in other studies)."""
    damping_n_s_m: NotNegative = 1.0
    """Damping c (same table)."""
    mass_kg: Positive = 1e-4
    """Moving mass m (same table)."""
    slip_length_um: Annotated[Number, Field(ge=0, le=1000)] = 11.5
    """How far it slides while friction follows its limit, z; 0: at once (13.8 Hz per mm/s: arXiv 2505.11162)."""


Finger = Annotated[RigidFinger | Skin, Kinds(Block, RigidFinger, Skin, default="rigid")]
FRICTIONS = Kinds(
    FrictionLimit,
    Friction,
    FingerFriction,
    default="gaussian",
    beside={"rough_contact": "frictionloop.physics.rough_contact:RoughContactFriction"},
)
AnyFriction = Annotated[FrictionLimit, FRICTIONS]
