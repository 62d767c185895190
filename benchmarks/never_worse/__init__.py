"""Never worse than PI: ``python -m benchmarks.never_worse [--every] [--joints N] [--machines N] [--cascades N] ...``.

A controller against its own PI loop, as ``adaptive_ff.comparison.windows`` defines it, beside what is asked of it: in
situations outside the controller's model (by default), in scenarios of the matrix (``--scenario``, ``--every``) and on
joints drawn at random around the built-in one (``--joints``), by how steeply their friction falls against the
proportional gain. Where it falls by more than the gain, PI itself hunts. Machines (``--machines``) are drawn over
decades of size, speed and sampling rate, see ``benchmarks.drawn_machines``; with a weight and behind a position loop
(``--cascades``), and with rests of seconds between moves there (``--resting``), the error is that of the position, in
mrad. With ``--saturating`` joints and machines have drives that saturate, of whose torque the controllers are told
nothing; with ``--elastic`` machines have gears that are elastic, or have play, of which nothing is told. ``--controller
pi`` compares PI with itself under other noise: what chance alone does to the figures. Reported are references of seeds
from 1 on and the draws of seed 1; whoever tunes takes ``--first-seed 101``.
"""
