"""The same types as Cyclone DDS has them, made of the definitions that rosbags has."""

from __future__ import annotations

from functools import cache
from typing import Any

from popsteer.adapters.ros2.messages import store
from popsteer.extras import require


class _Bytes:
    """What a reader gives and a writer takes: a message's bytes, as they are on the wire."""

    def __init__(self, data: bytes) -> None:
        self.data = data

    def serialize(self, **_: object) -> bytes:
        return self.data


@cache
def idl_type(name: str) -> Any:  # noqa: ANN401 - cyclonedds is an extra
    """Give the type that DDS knows a message by: ``nav_msgs::msg::dds_::Path_``, say."""
    return _made(name)


@cache
def wire_type(name: str) -> Any:  # noqa: ANN401
    """Give the same type with samples of bytes, for rosbags to convert and to record."""
    return as_bytes(_made(name))  # a class of its own, for its methods are others


def as_bytes(kind: Any) -> Any:  # noqa: ANN401
    """Make the samples of a type plain bytes."""
    kind.__init__ = _Bytes.__init__
    kind.serialize = _Bytes.serialize
    # Samples of a reader are given more attributes, so they are no plain bytes.
    kind.deserialize = classmethod(lambda _, data, **__: _Bytes(bytes(data)))
    kind.deserialize_key = kind.deserialize
    return kind


def _made(name: str) -> Any:  # noqa: ANN401
    require("ROS 2", "ros2", "cyclonedds")
    from cyclonedds.idl import make_idl_struct, types

    package, part, kind = name.split("/")
    fields = {field: _field(*of) for field, of in store().get_msgdef(name).fields}
    if part == "srv":  # what `rmw_cyclonedds_cpp` puts before requests and answers
        fields = {"writer_guid": types.uint64, "sequence_number": types.int64, **fields}
    return make_idl_struct(f"{kind}_", f"{package}.{part}.dds_.{kind}_", fields)


def _field(kind: Any, detail: Any) -> Any:  # noqa: ANN401
    from cyclonedds.idl import types

    if kind.name == "NAME":
        return idl_type(detail)
    if kind.name == "BASE":
        plain = {"bool": bool, "string": str, "char": types.uint8, "byte": types.byte}
        return plain[detail[0]] if detail[0] in plain else getattr(types, detail[0])
    (inner, of), count = detail
    item = _field(inner, of)
    return types.array[item, count] if kind.name == "ARRAY" else types.sequence[item]
