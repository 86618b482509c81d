"""What a controller was shown in a step, which the Rust core keeps to itself: the reference's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer import reference

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.parity.laws import Law


def decided(
    law: Law, controller: Any, state: Any, step: Sequence[float], adapt: Any = "auto"
) -> tuple[Any, Any]:
    """Return the located vehicle and the decision of a step of `controller` from `state`.

    The vehicle is the one predicted through the dead time, the decision the law's own, before the
    limits of the vehicle.
    """
    path = controller.path
    made = reference.Path(
        list(zip(path.x.tolist(), path.y.tolist(), strict=True)),
        speed=None if path.speed is None else path.speed.tolist(),
        closed=path.closed,
    )
    vehicle = reference.Vehicle(**controller.vehicle.as_dict())
    params = getattr(reference, law.params_name)(**controller.params.as_dict())
    if isinstance(adapt, dict):
        adapt = reference.AdaptParams(**adapt)
    twin = getattr(reference, law.name)(made, vehicle, params, adapt=adapt)
    twin.state = getattr(reference, law.state_name)(**state.as_dict())
    decide, seen = twin.decide, []

    def recorded(at: Any, belief: Any) -> Any:
        decision = decide(at, belief)
        seen.append((at, decision))
        return decision

    twin.decide = recorded
    twin.step(*step)
    ((at, decision),) = seen
    return at, decision
