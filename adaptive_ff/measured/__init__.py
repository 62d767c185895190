"""Recorded data of real machines: reading logs, and identifying the joint behind them."""

from adaptive_ff.measured.defects import Piece, Skipped, usable_pieces
from adaptive_ff.measured.identification import identify_log
from adaptive_ff.measured.logs import Log, read_log
from adaptive_ff.measured.replay import replay_log
from adaptive_ff.measured.replay_result import Replay
from adaptive_ff.measured.replay_settings import ReplaySettings
from adaptive_ff.measured.result import LogIdentification

__all__ = [
    "Log",
    "LogIdentification",
    "Piece",
    "Replay",
    "ReplaySettings",
    "Skipped",
    "identify_log",
    "read_log",
    "replay_log",
    "usable_pieces",
]
