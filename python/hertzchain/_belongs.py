"""What belongs to a function: its code, and the values that it has beside its arguments."""

from __future__ import annotations

import copyreg
import dis
import functools
import hashlib
from collections import Counter
from collections.abc import Callable
from types import CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from ._values import Value

_PLAIN = (type(None), bool, int, float, complex, str, bytes, type(...), range)


def belongings(function: Callable[..., Any]) -> dict[str, str]:
    """Digests of what belongs to a function, by what each is: ``"the code"``, a variable.

    These are its code, its defaults, the variables of the functions about it, globals of its
    module, the arguments of a ``functools.partial``, and attributes of the object of which it is a
    method; functions and classes of its module are taken with what belongs to them. Of other
    modules there are only names. What has no digest, such as a lock or an open file, is left out.
    """
    return {name: _hash(text) for name, text in _Parts(function).texts.items() if text is not None}


def digest(value: Any) -> str:
    """One digest of a value, such as a list of points."""
    return _hash(repr(_Parts(value).texts))


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:16]


class _Parts:
    """Texts that tell values apart; those of variables and attributes by their names."""

    def __init__(self, function: Any) -> None:
        self.texts: dict[str, str | None] = {}
        self._count: Counter[str] = Counter()
        self._own = getattr(function, "__func__", function)
        self._module = getattr(getattr(function, "func", function), "__module__", None)
        # Values by their ids, kept so that no id occurs twice; ids of those that are taken apart.
        self._known: dict[int, tuple[Any, str]] = {}
        self._open: list[int] = []
        self._part("the value", function)

    def text(self, value: Any) -> str:
        """A text that is that of another value only if both are alike; an exception if none is."""
        if type(value) in _PLAIN:
            return repr(value)
        if id(value) in self._open:  # It has itself as a part.
            return f"the value {self._open.index(id(value))}"
        if id(value) not in self._known:
            self._open.append(id(value))
            try:
                self._known[id(value)] = value, self._text(value)
            finally:
                self._open.pop()
        return self._known[id(value)][1]

    def _text(self, value: Any) -> str:
        kind = type(value)
        if kind in (list, tuple):
            return f"{kind.__name__}({', '.join(map(self.text, value))})"
        if kind is dict:
            return f"dict({self.text([*value.items()])})"
        if kind in (set, frozenset):  # Their order is not the same in every process.
            return f"{kind.__name__}({', '.join(sorted(map(self.text, value)))})"
        if kind is np.ndarray and not value.dtype.hasobject:
            return f"array({value.dtype}, {value.shape}, {hashlib.sha256(value.tobytes()).hexdigest()})"
        if isinstance(value, ModuleType):
            return value.__name__
        if isinstance(value, CodeType):
            return self._code(value)
        if isinstance(value, FunctionType):
            return self._of_function(value)
        if isinstance(value, MethodType):
            return f"{self.text(value.__func__)} of {self.text(value.__self__)}"
        if isinstance(value, functools.partial):
            return f"partial({', '.join(map(self.text, (value.func, value.args, value.keywords)))})"
        if isinstance(value, (staticmethod, classmethod)):
            return f"{kind.__name__}({self.text(value.__func__)})"
        if isinstance(value, property):
            return f"property({self.text([value.fget, value.fset, value.fdel])})"
        if isinstance(value, type):
            return self._of_class(value)
        if hasattr(value, "__wrapped__"):  # such as by functools.cache
            return f"{kind.__qualname__}({self.text(value.__wrapped__)})"
        if isinstance(value, Value):
            known = value._own()
            return self._of_object(kind, {name: known[name] for name in known if name not in value._left_out})
        return self._reduced(value)

    def _reduced(self, value: Any) -> str:
        """An object by what it would be made of anew."""
        known = copyreg.dispatch_table.get(type(value))
        made = known(value) if known else value.__reduce_ex__(2)
        if isinstance(made, str):
            return f"{getattr(value, '__module__', None)}.{made}"
        parts: tuple[Any, ...] = (*made, None, None, None)
        maker, given, state, items, pairs = parts[:5]
        name = getattr(maker, "__qualname__", repr(maker))
        rest = [given, None if items is None else list(items), None if pairs is None else dict(pairs)]
        if isinstance(state, dict) and all(isinstance(key, str) for key in state):
            return f"{name}({self.text(rest)}) {self._of_object(type(value), state)}"
        return f"{name}({self.text([*rest, state])})"

    def _of_object(self, kind: type, attributes: dict[str, Any]) -> str:
        """The class of an object, and its attributes, each a part of its own."""
        of = f" of {kind.__qualname__}"
        return f"{self.text(kind)} with {[self._part(name + of, one) for name, one in attributes.items()]}"

    def _of_class(self, kind: type) -> str:
        name = kind.__qualname__
        if kind.__module__ != self._module:
            return f"{kind.__module__}.{name}"
        hidden = {"__dict__", "__weakref__", "__doc__", "__module__", "__slotnames__", "_abc_impl"}
        hidden |= {"__firstlineno__", "__static_attributes__"}
        own = {key: of for key, of in vars(kind).items() if key not in hidden}
        members = [self._part(f"{key} of {name}", of) for key, of in own.items()]
        return f"{name}({self.text(kind.__bases__)}) with {members}"

    def _of_function(self, function: FunctionType) -> str:
        """A function by its name; its code, defaults and variables are parts of their own."""
        if function.__module__ != self._module:
            return f"{function.__module__}.{function.__qualname__}"
        of = "" if function is self._own else f" of {function.__qualname__}"
        parts = {"the code": function.__code__, "defaults": [function.__defaults__, function.__kwdefaults__]}
        code = function.__code__
        for name, cell in zip(code.co_freevars, function.__closure__ or ()):
            try:
                parts[name] = cell.cell_contents
            except ValueError:  # It has no value yet.
                continue
        parts |= {name: function.__globals__[name] for name in _globals(code) if name in function.__globals__}
        for name, value in parts.items():
            self._part(name + of, value)
        return f"function{of}"

    def _part(self, name: str, value: Any) -> str:
        """The name by which a value is a part of its own."""
        self._count[name] += 1
        if self._count[name] > 1:
            name = f"{name}, number {self._count[name]},"
        self.texts[name] = None
        try:
            self.texts[name] = self.text(value)
        except Exception:  # what classes do that refuse to be taken apart
            pass
        return name

    def _code(self, code: CodeType) -> str:
        """What a code does in this version of Python, its comments and lines left out."""
        table = getattr(code, "co_exceptiontable", b"")
        names = [code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars]
        return self.text([code.co_code, table, code.co_flags, names, code.co_consts])


def _globals(code: CodeType) -> list[str]:
    """The names of globals that a code, or a code inside it, reads."""
    inner = [name for one in code.co_consts if isinstance(one, CodeType) for name in _globals(one)]
    own = [one.argval for one in dis.get_instructions(code) if one.opname in ("LOAD_GLOBAL", "LOAD_NAME")]
    return list(dict.fromkeys(own + inner))
