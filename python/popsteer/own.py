"""Controllers, plants and tracks of your own, by name.

A name is ``FILE.py:NAME``, ``MODULE:NAME``, or an entry point ``popsteer.controllers`` or
``popsteer.plants`` of an installed package. What is named is a class or a function. If it has an
attribute ``Params``, a dataclass whose fields are numbers with defaults, it is called with an
object of that as its last argument; ``RANGES`` there bounds them, (lowest, highest) by name.

Examples
--------
>>> is_named("controller", "mine.py:Mpc"), is_named("controller", "mpc")
(True, False)
>>> title("folder/mine.py:Mpc")
'Mpc'
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import importlib.util
import re
import sys
import traceback
import zlib
from dataclasses import MISSING, field, fields, is_dataclass, make_dataclass
from functools import cache, lru_cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from popsteer.errors import ConfigError, PopsteerError, printable, short
from popsteer.parameters import Parameters

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from types import ModuleType, TracebackType

What: TypeAlias = Literal["controller", "plant", "track"]

_REFERENCE = re.compile(r"(?P<place>.+):(?P<name>[A-Za-z_]\w*)")
_PACKAGE = str(Path(__file__).parent)
_INSTALLED = {"site-packages", "dist-packages"}


class OwnCodeError(PopsteerError):
    """Code of your own raised where nothing can be driven without it; has its `traceback`."""

    traceback: str

    def __init__(self, name: str, error: BaseException) -> None:
        super().__init__(f"{name} raised {type(error).__name__}: {short(str(error))}")
        self.traceback = raised(error)


def is_reference(name: object) -> bool:
    """Whether a name is written ``FILE.py:NAME`` or ``MODULE:NAME``."""
    return isinstance(name, str) and _REFERENCE.fullmatch(name) is not None


def is_named(what: What, name: object) -> bool:
    """Whether a name is a reference, or an entry point of an installed package."""
    return is_reference(name) or (isinstance(name, str) and name in entry_points(what))


def title(name: str) -> str:
    """Give what a reference names; any other name as it is."""
    found = _REFERENCE.fullmatch(name)
    return found["name"] if found else name


@cache
def entry_points(what: What) -> Mapping[str, metadata.EntryPoint]:
    """Give the entry points of installed packages, by name."""
    return {each.name: each for each in metadata.entry_points(group=f"popsteer.{what}s")}


def load(what: What, name: str) -> Any:  # noqa: ANN401 - whatever is there
    """Give what a name stands for; ConfigError if nothing, OwnCodeError if loading it raises."""
    found = _REFERENCE.fullmatch(name)
    if found and found["place"].endswith(".py") and _file(found["place"]) is None:
        raise ConfigError(what, name, "in a file that exists")
    try:
        if found is None:
            return entry_points(what)[name].load()
        place = found["place"]
        if not place.endswith(".py"):
            module = importlib.import_module(place)
        else:
            module = _module(str(_file(place)))
    except Exception as error:
        missing = getattr(error, "name", None) if isinstance(error, ModuleNotFoundError) else None
        if found and missing and f"{found['place']}.".startswith(f"{missing}."):
            wanted = "FILE.py:NAME, or MODULE:NAME of a module that Python finds"
            raise ConfigError(what, name, wanted) from error
        raise OwnCodeError(name, error) from error
    if not hasattr(module, found["name"]):
        raise ConfigError(what, name, f"defined in {found['place']}")
    return getattr(module, found["name"])


def code(what: What, name: str) -> dict[str, str]:
    """Give hashes of the files of code that a name stands for; of popsteer's names there is none.

    They are those below the folder of the file, or of the module's package: modules that it
    imports, wherever in it that stands, and those that are loaded. They are named from that folder.
    """
    if not is_named(what, name):
        return {}
    load(what, name)
    found = _reference(what, name)
    folder, first = _folder(found["place"]), _file(found["place"])
    every = [getattr(each, "__file__", None) for each in tuple(sys.modules.values())]
    paths = {Path(file).resolve() for file in every if file} | ({first} if first else set())
    new = {path for path in paths if path.suffix == ".py" and path.is_relative_to(folder)}
    root = _root(found["place"], folder)
    while new:
        imported = {each for path in new for each in _imported(path, root)} - paths
        new = {path for path in imported if path.is_relative_to(folder)}
        paths |= new
    # What is installed below the folder, such as an environment of its own, is not its code.
    names = [path.relative_to(folder) for path in paths if path.is_relative_to(folder)]
    mine = sorted(each.as_posix() for each in names if not _INSTALLED & set(each.parts))
    mine = [each for each in mine if not str(folder / each).startswith(_PACKAGE)]
    if _INSTALLED & {folder.name}:  # a module alone among all that is installed
        mine = [f"{found['place'].partition('.')[0]}.py"]
    hashes = {each: _hash(folder / each) for each in mine}
    return {each: found for each, found in hashes.items() if found is not None}


def _imported(file: Path, root: Path) -> Iterator[Path]:
    """Give the files below a root that a file of code imports, wherever in it that stands."""
    for node in ast.walk(ast.parse(file.read_bytes())):
        at, names = root, []
        if isinstance(node, ast.Import):
            names = [each.name for each in node.names]
        elif isinstance(node, ast.ImportFrom):
            at = file.parents[node.level - 1] if node.level else root
            names = [f"{node.module or ''}.{each.name}".strip(".") for each in node.names]
        for parts in (name.split(".") for name in names):
            for k in range(1, len(parts) + 1):
                stem = at.joinpath(*parts[:k])
                both = stem.with_name(f"{stem.name}.py"), stem / "__init__.py"
                yield from (each for each in both if each.is_file())


def changed(what: What, name: str, known: Mapping[str, str]) -> str | None:
    """Name the first file of `code` that is not as it was `known`; None if all are."""
    folder = _folder(_reference(what, name)["place"])
    other = [each for each in known if _hash(folder / each) != known[each]]
    return next(iter(other or sorted(code(what, name).keys() - known)), None)


def sent(what: What, name: str) -> tuple[tuple[str, bytes], ...]:
    """Give the files of `code` with what is in them, named from a folder that finds modules."""
    found = code(what, name)
    if not found:
        return ()
    folder = _folder(place := _reference(what, name)["place"])
    root = _root(place, folder)
    paths = [folder / each for each in found]
    return tuple((path.relative_to(root).as_posix(), path.read_bytes()) for path in paths)


@lru_cache(maxsize=1)
def receive(files: tuple[tuple[str, bytes], ...], folder: Path) -> None:
    """Put what was `sent` below a folder where modules are found, in place of what was before."""
    mark = "popsteer-own-"
    root = folder / f"{mark}{hashlib.sha256(repr(files).encode()).hexdigest()[:16]}"
    if str(root) in sys.path:
        return  # a task beside this one may just look for a module there
    loaded = tuple(sys.modules.items())
    before = {name for name, each in loaded if mark in str(getattr(each, "__file__", None))}
    first = {name.partition(".")[0] for name in before}
    for name, _ in loaded:
        if name.partition(".")[0] in first:
            del sys.modules[name]
    sys.path[:] = [each for each in sys.path if mark not in each]
    for name, content in files:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(content)
    sys.path.append(str(root))  # the last, as by `_module`: nothing hides what was there
    importlib.invalidate_caches()


def _reference(what: What, name: str) -> re.Match[str]:
    found = _REFERENCE.fullmatch(name) or _REFERENCE.fullmatch(entry_points(what)[name].value)
    if found is None:
        raise ConfigError(what, name, "FILE.py:NAME or MODULE:NAME")
    return found


def _folder(place: str) -> Path:
    """Find the folder of a file, or of a module's package, without running any of it."""
    if place.endswith(".py"):
        file = _file(place)
        return Path(place).resolve().parent if file is None else file.parent
    spec = importlib.util.find_spec(place.partition(".")[0])
    if spec is None or not (spec.submodule_search_locations or spec.origin):
        return Path.cwd()
    inside = list(spec.submodule_search_locations or ())
    return Path(inside[0]).resolve() if inside else Path(str(spec.origin)).resolve().parent


def _root(place: str, folder: Path) -> Path:
    """Give the folder from which modules below `folder` are imported."""
    package = not place.endswith(".py") and folder.name == place.partition(".")[0]
    return folder.parent if package else folder


def _hash(file: Path) -> str | None:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()[:16]
    except OSError:
        return None


def params_of(kind: Any) -> type[Parameters]:  # noqa: ANN401 - a class or a function
    """Give what `load` gave its ``Params``; ConfigError unless a dataclass with all defaults."""
    given: Any = getattr(kind, "Params", None)
    if given is None:
        return Parameters
    wanted = "a dataclass whose fields have defaults"
    if not isinstance(given, type) or not is_dataclass(given):
        raise ConfigError(f"Params of {kind.__name__}", given, wanted)
    if issubclass(given, Parameters):
        return given
    named = []
    for each in fields(given):
        if each.default is MISSING:
            raise ConfigError(f"{given.__name__}.{each.name}", "no default", wanted)
        named.append((each.name, each.type, field(default=each.default)))
    made = make_dataclass(
        given.__name__,
        named,
        bases=(Parameters,),
        namespace={"RANGES": getattr(given, "RANGES", {}), "__doc__": given.__doc__},
        frozen=True,
    )
    made.__module__ = given.__module__
    return made


def called(kind: Any, *given: object, params: Any) -> Any:  # noqa: ANN401 - whatever is there
    """Call what `load` gave: with the arguments, and its parameters where it has some."""
    if not hasattr(kind, "Params"):
        return kind(*given)
    own = kind.Params
    return kind(*given, params if isinstance(params, own) else own(**params.as_dict()))


def raised(error: BaseException) -> str:
    """Give the traceback of an error, from the first line that is not popsteer's own, if any is."""
    here: TracebackType | None = error.__traceback__
    ours = (_PACKAGE, "<frozen importlib", importlib.__file__)
    while here is not None and here.tb_frame.f_code.co_filename.startswith(ours):
        here = here.tb_next
    lines = "".join(traceback.format_exception(type(error), error, here)).split("\n")
    return "\n".join(short(printable(line)) for line in lines)


def _file(place: str) -> Path | None:
    """Find the file of a reference: as it is named, or, on a cluster, where modules are found."""
    if not place.endswith(".py"):
        return None
    paths = [Path(place), *(Path(folder) / Path(place).name for folder in sys.path)]
    return next((path.resolve() for path in paths if path.is_file()), None)


@cache
def _module(file: str) -> ModuleType:
    """Run a file, once a process, as a module of a name of its own."""
    path = Path(file)
    name = f"{path.stem}_{zlib.crc32(file.encode()):08x}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file} is no module")
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))  # what lies beside it can be imported, as by a script
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look there for the module of their class
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module
