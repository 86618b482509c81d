"""How a steering loop answers: to frequencies, open at the command, and to a step of the path."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from popsteer.lab.stability.linear import linearised
from popsteer.lab.stability.loop import Loop

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer._core import Vehicle
    from popsteer.controllers import Params

    Crossings: TypeAlias = tuple[list[tuple[float, float]], list[tuple[float, float]]]

_ALIASED = 1e-9  # of what comes after the window, what remains in it
_LONGEST = 60.0  # s


class Response(NamedTuple):
    """What a loop answers at one speed."""

    frequency: NDArray[np.float64]
    """Frequencies, ascending, up to half of the control rate [rad/s]."""
    gain: NDArray[np.complex128]
    """The gain of the open loop there."""
    time: NDArray[np.float64]
    """Times from the step on, one a control period [s]."""
    offset: NDArray[np.float64]
    """Offset of the no-slip point where the path moves by 1 m at once [m]; NaN if unstable."""

    @property
    def phase(self) -> NDArray[np.float64]:
        """Phase of the gain [rad], without jumps, within half a turn of -180 degrees at first."""
        phase = np.unwrap(np.angle(self.gain))
        return np.asarray(phase - math.tau * np.round((phase[0] + math.pi) / math.tau))

    def crossings(self) -> Crossings:
        """Find where the margins are read."""
        return crossings(self.frequency, self.gain, self.phase)


def crossings(
    frequency: NDArray[np.float64], gain: NDArray[np.complex128], phase: NDArray[np.float64]
) -> Crossings:
    """Find where the margins of a response are read, of its continuous phase [rad].

    Frequency [rad/s] and phase [rad] where the gain falls or rises through 1; frequency and size of
    the gain where the phase passes -180 degrees.
    """

    def between(at: NDArray[Any], share: NDArray[Any], values: NDArray[Any]) -> Any:  # noqa: ANN401
        ends = (each[at] + share * (each[at + 1] - each[at]) for each in (frequency, values))
        return zip(*(each.tolist() for each in ends), strict=True)

    size = np.log(np.abs(gain))
    at = np.flatnonzero(np.diff(np.sign(size)))
    gains = list(between(at, size[at] / (size[at] - size[at + 1]), phase))
    # An odd number of half turns: where the gain is real and negative.
    turned = (phase + math.pi) / (2.0 * math.pi)
    whole = np.floor(turned)
    at = np.flatnonzero(np.diff(whole))
    share = (np.maximum(whole[at], whole[at + 1]) - turned[at]) / (turned[at + 1] - turned[at])
    return gains, [(where, math.exp(value)) for where, value in between(at, share, size)]


def respond(
    params: Params,
    vehicle: Vehicle,
    speed: float,
    dt: float = 0.05,
    *,
    believed: Vehicle | None = None,
    seconds: float = 6.0,
) -> Response:
    """Compute the answers of a loop; the arguments are those of `margins`, and for how long.

    The step is found by the inverse z-transform on a circle around all poles::

        y[k] = rᵏ IFFT(T(z) / (1 - 1/z)),   T = C_e E / (D (1 + L)),   z = r exp(jθ)

    Examples
    --------
    >>> from popsteer import PopParams, Vehicle
    >>> found = respond(PopParams(), Vehicle(steer_lag=0.1), 10.0)
    >>> bool(found.offset[0] == 0.0), round(float(found.offset[-1]), 2)
    (True, 1.0)
    """
    believed = vehicle if believed is None else believed
    law = linearised(params, believed, speed, dt)
    loop = Loop(law, vehicle, speed, dt, believed=believed)
    count = math.ceil(min(seconds, _LONGEST) / dt) + 1
    size = 1 << (2 * count - 1).bit_length()
    # Beyond a window of `size` it would come again, by so much less.
    radius = _ALIASED ** (-1.0 / size)
    angles = 2.0 * math.pi * np.arange(size) / size
    back = np.exp(-1j * angles) / radius
    around = Loop(law, vehicle, speed, dt, believed=believed, back=back)
    found = np.fft.ifft(around.answer() / (1.0 - back)).real * radius ** np.arange(size)
    offset = np.where(np.abs(found) < 1e-9, 0.0, found)[:count].astype(np.float64)
    if not loop.is_stable():
        offset = np.full(count, math.nan)
    time = dt * np.arange(count, dtype=np.float64)
    return Response(loop.angles / dt, loop.gain(), time, offset)
