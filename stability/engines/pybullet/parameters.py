"""What a client and its bodies must be told, so that nothing is left to defaults or to who ran before."""

from math import sqrt

from stability.engines.pybullet.pybullet_binding import pybullet
from stability.engines.pybullet.pybullet_settings import PyBulletSettings
from stability.engines.pybullet.stepping import Stepping

# [engine m/s], for bodies as well as joints. By default PyBullet clamps speeds at 100, which is 10 m/s at scale 100.
TOP_SPEED = 1e4

# What all systems have in common; most of it belongs to the process and outlives its client.
ALIKE = {
    "restitutionVelocityThreshold": 0.2,
    "globalCFM": 0.0,
    "enableConeFriction": 1,
    "deterministicOverlappingPairs": 1,
    "constraintSolverType": pybullet.CONSTRAINT_SOLVER_LCP_SI,
    "enableSAT": 0,
    "collisionFilterMode": 0,
    "minimumSolverIslandSize": 128,
    "allowedCcdPenetration": 0.04,
}


def engine_parameters(settings: PyBulletSettings) -> dict[str, float]:
    """All that `setPhysicsEngineParameter` must be told: each belongs to the client or, worse, to the process.

    `contactBreakingThreshold` belongs to the process and outlives its client.
    """
    return {
        "fixedTimeStep": settings.time_step * sqrt(settings.scale),
        "numSolverIterations": settings.iterations,
        "numSubSteps": 0,
        "contactERP": settings.contact_erp,
        "erp": settings.contact_erp,
        "frictionERP": settings.friction_erp,
        "contactBreakingThreshold": settings.breaking_threshold,
        "contactSlop": settings.contact_slop,
        "solverResidualThreshold": settings.residual_threshold,
        "useSplitImpulse": 0 if settings.maximal_coordinates else 1,
        "warmStartingFactor": settings.warm_start,
        **ALIKE,
    }


# In more parts than these only what moves beside a sliver is stepped. There a corner that PyBullet finds late, some
# hundredths of a millimetre deep, is parted from a face at metres a second: a plank that tipped over one turned faster
# by 30 rad/s at once (heap 385 of `benchmarks.energy`).
MOST_PUSHING = 16


def step_parameters(settings: PyBulletSettings, how: Stepping) -> dict[str, float]:
    """What `setPhysicsEngineParameter` must be told when the stepping changes."""
    parameters = {
        "fixedTimeStep": settings.time_step * sqrt(settings.scale) / how.parts,
        "numSolverIterations": how.iterations,
    }
    if settings.maximal_coordinates:
        # What overlaps is then parted without being given speed. Stacks at rest creep by it.
        parted = how.lively or how.parts > MOST_PUSHING
        parameters |= {"useSplitImpulse": int(parted), "splitImpulsePenetrationThreshold": 0.0}
        parameters["globalCFM"] = settings.first_cfm if how.may_hit else 0.0
    if settings.maximal_coordinates and not how.lively:
        # The speed by which a share of an overlap is taken back in a step grows with the parts: what slips deep into
        # another is shot out. Divided by all of them, light bricks give way under heavy ones.
        parameters["contactERP"] = settings.contact_erp / sqrt(how.parts)
    elif settings.maximal_coordinates:
        parameters["contactERP"] = settings.contact_erp
    return parameters


def body_parameters(settings: PyBulletSettings, own_friction: float) -> dict[str, float]:
    """All that `changeDynamics` must be told of a body but its mass."""
    return {
        "lateralFriction": own_friction,
        "rollingFriction": 0.0,
        "spinningFriction": 0.0,
        "restitution": 0.0,
        "linearDamping": settings.linear_damping,
        "angularDamping": settings.angular_damping,
        "maxJointVelocity": TOP_SPEED,
        "frictionAnchor": 0,
        "activationState": pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
    }
