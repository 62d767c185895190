"""Motion that goes one way for long: what changes slowly there is taken for a load.

While a joint moves one way, offset and Coulomb friction are the same number, and what is left of the motion both ways
decides how they share what changes. By default both are known equally well, so friction takes half of a weight that
turns with the joint, and the next reversal, where friction changes its sign, misses all of that twice. Friction that
changes slowly with the way is rarer than a load that does: a weight, a spring, a cable. So the further the memory is
one of motion one way, the faster the offset is forgotten, while nothing is forgotten of friction,

    rho^2 = M_oc^2/(M_oo M_cc),    M  ->  M - x/(1 + x) M d d'M/(d'M d),    x = 128/s rho^6 dt

with the information ``M``, of the offset ``o`` and Coulomb friction ``c``, and the direction ``d`` of the offset. That
is what a larger variance of the offset makes of the covariance; no estimate is changed. Motion both ways has a small
``rho`` and loses nothing. ``x`` is less as far as noise explains what the model leaves, or as that is less than a
hundredth of the friction (:func:`left_over`): where there is no load that changes,
nothing is lost either.

With a weight of 100 N m that is not modelled the built-in joint settles at 5.1 times better than PI, and at 3.5 without
(seeds 131 to 150). It begins when a memory has been learnt: before, nothing is known of either, and the first seconds
of a joint without a weight would be up to a tenth worse. Where a map of friction is fed, it is left out.
"""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters, EstimatorState, load_count
from adaptive_ff.adaptive.learning.unexplained import missing_share
from adaptive_ff.adaptive.supervision.noise_level import NoiseState, noise_known
from adaptive_ff.estimation.quadratic import take_square_in_place
from adaptive_ff.friction.bounds import COULOMB, OFFSET

RATE = 128.0
"""Rate at which the offset is forgotten where all that is remembered is motion one way, 1/s.

With 64/s times the fourth power of ``rho`` viscous friction moves by 10.1 % through a push of 80 N m (10 % asked), by
8.9 % with this.
"""


@register_jitable
def loosen_offset_in_place(information: NDArray[np.float64], duration: float, work: NDArray[np.float64]) -> None:
    """Forget the offset as far as the memory is one of motion one way.

    Parameters
    ----------
    information : ndarray, shape (n, n)
        Information matrix of the scaled parameters; changed in place.
    duration : float
        Time since the last sample, s.
    work : ndarray, shape (n,)
        Scratch.
    """
    offset = information[OFFSET, OFFSET]
    both = offset * information[COULOMB, COULOMB]
    if not both > 0.0:
        return
    alike = information[OFFSET, COULOMB] * information[OFFSET, COULOMB] / both
    gone = RATE * duration * alike * alike * alike
    for i in range(work.size):
        work[i] = information[i, OFFSET]
    take_square_in_place(information, gone / (1.0 + gone) / offset, work)


@register_jitable
def left_over(noise: NoiseState, estimator: EstimatorState, squared: float, unfit: float) -> float:
    """Return the share to which what a model leaves, squared (N^2 m^2), unfit to a share, is a load, or friction."""
    if not noise_known(noise):
        return 0.0
    return min(unfit, missing_share(estimator, squared))


@register_jitable
def note_one_way_in_place(
    estimator: EstimatorParameters, old: EstimatorState, new: EstimatorState, duration: float
) -> None:
    """Forget the offset over a time (s) where something has been learnt on motion one way."""
    if new.recursion.estimate.size - load_count(estimator) > OFFSET:
        learnt = new.levels.learnt > max(old.levels.learnt, estimator.memory)
        if learnt and new.friction_map.share == 0.0:
            loosen_offset_in_place(new.recursion.information, duration, new.scratch.model_gradient)
