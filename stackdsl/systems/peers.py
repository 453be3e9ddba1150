"""Systems on other engines, to compare with: each can be played where its package is installed.

Only the command line and benchmarks know them. A scenario cannot name them in `systems`, so that it is right or wrong
alike for those who have the package and those who have not (docs/decisions/0016).
"""

from stability.engines.mujoco.mujoco_settings import MuJoCoSettings
from stability.engines.sapien.sapien_settings import SapienSettings
from stackdsl.systems.systems import MOVING, MUJOCO, Method, System

# Five times the cost, for straight columns of a hundred planks.
MUJOCO_STIFF = MuJoCoSettings(
    time_step=0.0005,
    iterations=200,
    contact_time=0.0012,
    impedance_range=(0.98, 0.999, 0.0001),
    friction_impedance=10.0,
    tolerance=1e-10,
    most_travel=MOVING.most_travel,
)

SAPIEN = SapienSettings(
    time_step=1.0 / 960.0,
    iterations=20,
    velocity_iterations=1,
    contact_offset=0.001,
    most_travel=MOVING.most_travel,
)

PEERS = {
    system.name: system
    for system in (
        System("mujoco", "MuJoCo with the settings that stack best", MUJOCO, method=None),
        System("mujoco-stiff", "MuJoCo with stiff contacts", MUJOCO_STIFF, method=None),
        System("mujoco-exact", "exact statics, and MuJoCo for what moves", MUJOCO, Method.PROVEN),
        System("mujoco-thesis", "MuJoCo with the published stack-stability method", MUJOCO, Method.PUBLISHED),
        System("sapien", "PhysX 5 with the settings that stack best", SAPIEN, method=None),
        System("sapien-thesis", "PhysX 5 with the published stack-stability method", SAPIEN, Method.PUBLISHED),
    )
}
