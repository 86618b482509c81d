"""Path tracking as a Gymnasium environment; importing this registers ``popsteer/Track-v0``.

It needs the extra ``gym``. An agent steers a plant along a path,
one control step at a time; `TrackEnv` says what it sees, does and is rewarded for.

Examples
--------
>>> import gymnasium
>>> import popsteer.adapters.gymnasium
>>> env = gymnasium.make("popsteer/Track-v0", track="slalom")
>>> observation, info = env.reset(seed=1)
>>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
>>> terminated, round(info["time"], 3)
(False, 0.05)

Many at once, on all cores:

>>> envs = gymnasium.make_vec("popsteer/Track-v0", num_envs=512, plant="kinematic-bicycle")
>>> observations, infos = envs.reset(seed=1)
>>> observations.shape
(512, 27)
"""

try:
    import gymnasium as _gymnasium
except ModuleNotFoundError as error:
    if error.name != "gymnasium":
        raise
    from popsteer.extras import MissingExtra

    raise MissingExtra("popsteer.adapters.gymnasium", "gym") from error

from popsteer.adapters.gymnasium.env import TrackEnv
from popsteer.adapters.gymnasium.task import RewardWeights
from popsteer.adapters.gymnasium.vector import TrackVectorEnv

__all__ = ["RewardWeights", "TrackEnv", "TrackVectorEnv"]

if "popsteer/Track-v0" not in _gymnasium.registry:
    _gymnasium.register(
        id="popsteer/Track-v0",
        entry_point="popsteer.adapters.gymnasium:TrackEnv",
        vector_entry_point="popsteer.adapters.gymnasium:TrackVectorEnv",
    )
