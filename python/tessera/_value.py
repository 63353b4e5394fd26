"""What all values of a scene have in common."""
from __future__ import annotations

import functools
import re
import threading
from typing import Any, Callable, Dict, Mapping, NoReturn, Optional, Tuple, Type, TypeVar

from . import _core
from ._arguments import nearest, refuse_unknown
from ._callers import Place, where
from .errors import NestingError, SceneError

V = TypeVar("V", bound="Value")
# The class that users see, by message and kind.
CLASSES: Dict[Tuple[str, str], Type[Value]] = {}

_GENERATED = f"{__package__}._messages"
_MOST_SHOWN = 1000  # characters of a text that evaluates back
_MOST_OF_FIELD = 100  # those of each field where the text would be longer
_being_shown = threading.local()  # while a text is made: `left`, how many more characters it may have


class _TooLong(Exception):
    """The text that repr() makes would have more characters than it may."""


class Value(_core.ValueBase):
    """A part of a scene: compares, copies, pickles and prints by what it holds."""

    __slots__ = ("_place",)
    _MESSAGE = ""
    _KIND = ""
    _FIELDS: Tuple[str, ...] = ()
    _place: Optional[Place]

    def __init_subclass__(cls) -> None:
        if not (cls._MESSAGE and cls.__module__.startswith(__package__ + ".")):
            return
        generated = CLASSES.setdefault((cls._MESSAGE, cls._KIND), cls)
        if generated is not cls:
            words, heading, fields = (generated.__doc__ or "").partition("    Attributes:\n")
            cls.__doc__ = f"{(cls.__doc__ or words).rstrip()}\n\n{heading}{fields}"
        CLASSES[cls._MESSAGE, cls._KIND] = cls

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Value) or self._MESSAGE != other._MESSAGE:
            return NotImplemented
        if self is other:
            return True
        try:
            return _core.describe(self) == _core.describe(other)
        except NestingError:
            raise
        except SceneError:
            return False  # what is no part of a scene equals nothing but itself

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """Evaluates back if that takes at most 1,000 characters and no array of over 1,000 numbers. A
        longer text tells fields of over 100 characters by class and length: `nodes=<list of 240>`."""
        if getattr(_being_shown, "left", None) is not None:  # a part of another's text
            return self._text(_shown)
        whole = _text_within(_MOST_SHOWN, lambda: self._text(_shown))
        return self._text(_shown_briefly) if whole is None else whole

    def _text(self, shown: Callable[[Any], str]) -> str:
        _spend(len(type(self).__name__) + 2)
        held = ((name, getattr(self, name)) for name in self._FIELDS)
        arguments = [_argument(name, value, shown) for name, value in held if _is_set(value)]
        return f"{type(self).__name__}({', '.join(arguments)})"

    def __copy__(self: V) -> V:
        return _rebuild(type(self), {name: _copied(value) for name, value in _slots(self).items()},
                        getattr(self, "_place", None), getattr(self, "__dict__", {}))

    def __reduce__(self) -> Tuple[Any, ...]:
        held = {name: value for name, value in _slots(self).items() if value is not None}
        return _rebuild, (type(self), held, where(self), getattr(self, "__dict__", {}))


@functools.lru_cache(maxsize=None)
def _slots_of(made: type) -> Dict[str, Any]:
    """The descriptors of the slots of a class by their names, but for that of `_place`."""
    names = (name for base in made.__mro__ for name in base.__dict__.get("__slots__", ()))
    return {name: slot_of(made, name) for name in names if name != "_place"}


def _slots(value: Value) -> Dict[str, Any]:
    """What the slots hold, whatever properties hide them."""
    held = {}
    for name, slot in _slots_of(type(value)).items():
        try:
            held[name] = slot.__get__(value)
        except AttributeError:
            refuse_name(value, name)
    return held


def words_of(made: type, field: str) -> str:
    """What the class tells of a field: its unit, default and values."""
    found = re.search(rf"^ +{field}: (.*(?:\n {{12}}.*)*)", made.__doc__ or "", re.MULTILINE)
    return " ".join(found.group(1).split()) if found else ""


def slot_of(made: type, name: str) -> Any:
    for base in made.__mro__:
        if name in base.__dict__.get("__slots__", ()):
            # A property of a derived class may hide the slot, never that of the class itself.
            return base.__dict__[name]
    raise AttributeError(name)


def _copied(value: Any) -> Any:
    return value.copy() if isinstance(value, (list, dict)) else value


def _rebuild(made: Type[V], slots: Mapping[str, Any], place: Optional[Place],
             attributes: Mapping[str, Any] = {}) -> V:
    """A value that was copied or pickled; `attributes`: those of a derived class that has no slots. A
    class of `_messages` stands for the one that users see."""
    if made.__module__ == _GENERATED:
        made = CLASSES[made._MESSAGE, made._KIND]  # type: ignore[assignment]
    value = made.__new__(made)
    for name, slot in _slots_of(made).items():
        slot.__set__(value, slots.get(name))
    value._place = place
    if attributes:
        value.__dict__.update(attributes)
    return value


def _is_set(value: Any) -> bool:
    return value is not None and not (isinstance(value, (list, dict)) and not value)


def _argument(name: str, value: Any, shown: Callable[[Any], str]) -> str:
    _spend(len(name) + 3)
    return f"{name}={shown(value)}"


def _spend(characters: int) -> None:
    """Counts characters of the text that is being made; raises _TooLong where it has too many."""
    left = getattr(_being_shown, "left", None)
    if left is None:
        return
    if characters > left:
        raise _TooLong
    _being_shown.left = left - characters


def _text_within(left: int, make: Callable[[], str]) -> Optional[str]:
    """What `make` returns, or None where it is longer than that."""
    _being_shown.left = left
    try:
        text = make()
        return text if len(text) <= left else None
    except _TooLong:
        return None
    finally:
        _being_shown.left = None


def _shown_briefly(value: Any) -> str:
    text = _text_within(_MOST_OF_FIELD, lambda: _shown(value))
    if text is not None:
        return text
    size = f" {value.shape}" if hasattr(value, "shape") else f" of {len(value)}" if hasattr(value, "__len__") else ""
    return f"<{type(value).__name__}{size}>"


def _shown(value: Any) -> str:
    """`repr`, with numpy's arrays as lists that evaluate back."""
    if isinstance(value, Value):
        return repr(value)
    if isinstance(value, list):
        _spend(2)
        return f"[{', '.join(map(_shown, value))}]"
    text = repr(value) if not hasattr(value, "__array_interface__") else _array_text(value)
    _spend(len(text))
    return text


def _array_text(value: Any) -> str:
    if value.ndim == 0:
        return repr(value.item())
    if value.dtype.kind not in "biuf" or value.dtype.char == "g":
        return repr(value)  # no part of a scene
    native = value.astype(value.dtype.newbyteorder("="))
    return repr(_core.Array.from_bytes(native.tobytes(), native.dtype.char, list(value.shape)))


def restore_array(data: Any, code: str, shape: Tuple[int, ...]) -> _core.Array:
    """The array that was pickled, of its bytes or of a list of arrays of some of them each."""
    if isinstance(data, list):
        return _core.Array._from_parts(data, code, list(shape))
    return _core.Array.from_bytes(data, code, list(shape))


def refuse_name(value: Value, name: str) -> NoReturn:
    """Says that a class has no such attribute, or none that is assigned to, and which is nearest; or
    that a class derived from it has not set it."""
    made = type(value).__name__
    if name in _slots_of(type(value)):
        raise AttributeError(f"{made}.{name} is not set; expected {made}.__init__ to call super().__init__()")
    held = getattr(type(value), name, None)
    if callable(held) or (isinstance(held, property) and held.fset is None):
        settings = CLASSES["tessera.v1.Settings", ""]
        hint = f"; did you mean 'settings.{name}'?" if name in settings._FIELDS else ""
        raise AttributeError(f"{made}.{name} cannot be assigned to{hint}")
    hint = nearest(name, [n for n in dir(type(value)) if not n.startswith("_")])
    raise AttributeError(f"{made} has no attribute '{name}'{hint}")


def refuse_keywords(value: Value, unknown: Mapping[str, Any]) -> NoReturn:
    """Says that a constructor has no such keyword, and which is nearest, or else which class method has
    it."""
    from inspect import ismethod, signature  # here: few scripts need it
    made, name = type(value), next(iter(unknown))
    known = [each for each in signature(made).parameters if each not in unknown]
    methods = ((each, getattr(made, each)) for each in dir(made) if not each.startswith("_"))
    makers = [each for each, method in methods if ismethod(method) and name in signature(method).parameters]
    if makers and not nearest(name, known):
        raise TypeError(f"{made.__name__}() has no keyword '{name}'; did you mean "
                        f"{made.__name__}.{makers[0]}({name}=...)?")
    refuse_unknown(made.__name__, unknown, known)
