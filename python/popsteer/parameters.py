"""What classes of parameters in Python share: a range for each number, and changed copies."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from collections.abc import Mapping

    from typing_extensions import Self


@dataclass(frozen=True)
class Parameters:
    """Base of parameters that cannot be changed; each is checked against its range.

    None stands where it is the default.

    Raises
    ------
    ConfigError
        A number is not in its range.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Pedals(Parameters):
    ...     RANGES = {"drive": (0.0, 100.0)}
    ...     drive: float = 6.0
    >>> Pedals().replace(drive=4.0).as_dict()
    {'drive': 4.0}
    >>> Pedals(drive=-1.0)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: drive must be in [0, 100], got -1.0
    """

    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {}

    def __post_init__(self) -> None:
        for name, (low, high) in self.RANGES.items():
            value = getattr(self, name)
            if value is None and getattr(type(self), name) is None:
                continue  # left to what it scales with
            check_in_range(name, value, low, high)

    def as_dict(self) -> dict[str, Any]:
        """Give the parameters by name.

        Returns
        -------
        dict
            A new one.
        """
        return asdict(self)

    def replace(self, **changes: Any) -> Self:  # noqa: ANN401 - of the kinds that the fields have
        """Change some.

        Parameters
        ----------
        **changes : number
            New values by name.

        Returns
        -------
        same as the object
            A changed copy.

        Raises
        ------
        ConfigError
            A number is not in its range.
        """
        return replace(self, **changes)
