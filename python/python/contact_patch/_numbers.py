"""Arrays as the compiled part reads them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def numbers(values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """The values in one dimension: doubles, one after the other, aligned (arrays that came over a network may not be)."""
    return np.require(np.asarray(values, dtype=np.float64).ravel(), requirements=["C", "A"])
