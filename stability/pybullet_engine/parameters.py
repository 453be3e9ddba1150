"""What a client and its bodies must be told, so that nothing is left to defaults or to who ran before."""

from math import sqrt

from stability.engine_settings import EngineSettings
from stability.pybullet_engine.binding import pybullet

# [engine m/s], for bodies as well as joints. By default PyBullet clamps speeds at 100, which is 10 m/s at scale 100.
TOP_SPEED = 1e4


def engine_parameters(settings: EngineSettings) -> dict[str, float]:
    """All that `setPhysicsEngineParameter` must be told: each belongs to the client or, worse, to the process.

    `contactBreakingThreshold` belongs to the process and outlives its client.
    """
    return {
        "fixedTimeStep": settings.time_step * sqrt(settings.scale),
        "numSolverIterations": settings.iterations,
        "numSubSteps": 0,
        "contactERP": settings.contact_erp,
        "erp": settings.contact_erp,
        "frictionERP": 0.2,
        "contactBreakingThreshold": settings.breaking_threshold * settings.scale,
        "contactSlop": 1e-5,
        "solverResidualThreshold": settings.residual_threshold,
        "restitutionVelocityThreshold": 0.2,
        "globalCFM": 0.0,
        "enableConeFriction": 1,
        "deterministicOverlappingPairs": 1,
        "constraintSolverType": pybullet.CONSTRAINT_SOLVER_LCP_SI,
    }


def body_parameters(settings: EngineSettings, own_friction: float) -> dict[str, float]:
    """All that `changeDynamics` must be told of a body but its mass."""
    return {
        "lateralFriction": own_friction,
        "rollingFriction": 0.0,
        "spinningFriction": 0.0,
        "restitution": 0.0,
        "linearDamping": settings.linear_damping,
        "angularDamping": settings.angular_damping,
        "maxJointVelocity": TOP_SPEED,
        "frictionAnchor": int(settings.friction_anchor),
        "activationState": pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
    }
