"""State of the detection of a saturating drive; see :mod:`adaptive_ff.adaptive.faults.drive_limit`."""

from typing import NamedTuple

from adaptive_ff.adaptive.faults.rising_resistance import RisingResistance, initial_rising_resistance

PATIENCE = 60.0
"""Motion after which a drive that has seemed to saturate is given another chance, integral times; doubled each time.

Without another chance an arm that follows slowly at first is fed half of its friction for good, and is 3.0 times better
than PI instead of 9.2 times (``benchmarks.robot``, two links at 500 Hz). Of 400 drives that do saturate (seeds 101 and
201) as many settle at 0.95 of PI's accuracy or better as without it; with 30 integral times one less.
"""


class DriveLimit(NamedTuple):
    """State of the detection of a saturating drive.

    Attributes
    ----------
    torque, moved, error : float
        Torque asked for less the known torque, torque of the inertia (both N m), and error (rad/s), all low-passed.
    velocity : float
        Last measured velocity, rad/s.
    proven : float
        Largest resistance ``R_p`` with which the joint has followed, N m; zero before there is one.
    usual : float
        Mean resistance in motion before anything is proven, N m.
    moving : float
        How long the joint has moved before anything is proven, s.
    follows : float
        For how long the joint has followed with a larger resistance than the proven one, s.
    stuck : float
        For how long the joint has stood, s.
    broke : float
        Resistance at which the joint broke loose, fading, N m.
    doubt : float
        Doubt: grows by 1 in two integral times of torque that is not believed. Above 1 what is fed fades; 2 at most.
    suspect : bool
        Whether doubt has reached 2 before anything was proven.
    unproven : bool
        Whether more torque is asked for than is believed.
    given : float
        Largest torque beyond the known one that the drive is assumed to give, N m; zero without reason for a limit.
    largest : float
        Largest torque so far that was not believed, N m.
    anew : bool
        Whether everything learnt is to be forgotten now.
    established : bool
        Whether doubt has been at 2 after something was proven, and no more has been proven since.
    waited : float
        How long the joint has moved since then, s.
    patience : float
        After how long the drive is given another chance, integral times.
    shown : float
        Mean resistance over the time that ``follows`` counts, N m.
    answered : float
        Largest torque that the feedback has asked for, growing slowly, N m.
    bounded : bool
        Whether ``answered`` bounds what is fed: where no model was given, until the drive has reported its torque once.
    rising : RisingResistance
        How the resistance rises with the speed.
    """

    torque: float
    moved: float
    error: float
    velocity: float
    proven: float
    usual: float
    moving: float
    follows: float
    stuck: float
    broke: float
    doubt: float
    suspect: bool
    unproven: bool
    given: float
    largest: float
    anew: bool
    established: bool
    waited: float
    patience: float
    shown: float
    answered: float
    bounded: bool
    rising: RisingResistance


def initial_drive_limit(*, model_given: bool = False) -> DriveLimit:
    """Return the state before any motion, where a model of the joint was given or not."""
    return DriveLimit(
        torque=0.0,
        moved=0.0,
        error=0.0,
        velocity=0.0,
        proven=0.0,
        usual=0.0,
        moving=0.0,
        follows=0.0,
        stuck=0.0,
        broke=0.0,
        doubt=0.0,
        suspect=False,
        unproven=False,
        given=0.0,
        largest=0.0,
        anew=False,
        established=False,
        waited=0.0,
        patience=PATIENCE,
        shown=0.0,
        answered=0.0,
        bounded=not model_given,
        rising=initial_rising_resistance(),
    )
