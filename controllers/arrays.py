"""Types of arrays under short names: expanded, those of numpy drown a signature in ``help()``."""

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike as ArrayLike
    from numpy.typing import NDArray as NDArray
else:

    class _Named:
        """A type in annotations that shows as its name; nothing checks it while a program runs."""

        def __init__(self, name: str) -> None:
            self.name = name

        def __repr__(self) -> str:
            return self.name

        def __or__(self, other: Any) -> "_Named":
            return _Named(f"{self} | {_name(other)}")

        def __ror__(self, other: Any) -> "_Named":
            return _Named(f"{_name(other)} | {self}")

        def __getitem__(self, kind: Any) -> "_Named":
            return _Named(f"{self}[{_name(kind)}]")

        def __call__(self) -> None:
            raise TypeError(f"{self} is for annotations only")

    def _name(kind: Any) -> str:
        return "None" if kind is None else getattr(kind, "__name__", str(kind))

    ArrayLike, NDArray = _Named("ArrayLike"), _Named("NDArray")

MutableArray: TypeAlias = NDArray[np.float64]
"""An array of a state that steps change in place; all other arrays stay as they are."""
