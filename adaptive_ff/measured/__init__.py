"""Recorded data of real machines: reading logs, and identifying the joint behind them."""

from adaptive_ff.measured.defects import Piece, Skipped, usable_pieces
from adaptive_ff.measured.identification import identify_log
from adaptive_ff.measured.logs import Log, read_log
from adaptive_ff.measured.result import LogIdentification

__all__ = ["Log", "LogIdentification", "Piece", "Skipped", "identify_log", "read_log", "usable_pieces"]
