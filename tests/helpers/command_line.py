"""The command line in this process, for tests."""

import functools
import io
import os
import re
import sys
import warnings
from contextlib import redirect_stderr, redirect_stdout
from typing import NamedTuple
from unittest.mock import patch

import pytest
import typer

from adaptive_ff.cli.main import main
from adaptive_ff.scenario.loop import tried_bandwidths
from adaptive_ff.studies import bandwidth_study, exciting_motion
from adaptive_ff.studies.exciting_motion import find_excitations, polished

WARNING = ("adaptive-ff: warning:", "warning:")
BUILT = functools.cache(typer.main.get_command)
"""Commands are built once, not for every call."""
COLOUR = re.compile(r"\x1b\[[0-9;]*m")


class Outcome(NamedTuple):
    """What a call ended with and wrote."""

    status: int
    out: str
    err: str

    @property
    def warnings(self):
        return [line for line in self.err.splitlines() if line.startswith(WARNING)]

    @property
    def messages(self):
        """Lines on stderr that are no warnings."""
        return [line for line in self.err.splitlines() if not line.startswith(WARNING)]


def run_command_line(*arguments, columns=1000):
    """Run ``adaptive-ff`` with arguments, warnings shown as for a user."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["adaptive-ff", *(str(argument) for argument in arguments)]
    plain = {name: value for name, value in os.environ.items() if name not in ("FORCE_COLOR", "TTY_COMPATIBLE")}
    with (
        warnings.catch_warnings(action="default"),
        patch.dict(os.environ, {**plain, "COLUMNS": str(columns)}, clear=True),
        patch.object(sys, "argv", argv),
        patch.object(typer.main, "get_command", BUILT),
        redirect_stdout(out),
        redirect_stderr(err),
        pytest.raises(SystemExit) as ended,
    ):
        main()
    return Outcome(ended.value.code or 0, COLOUR.sub("", out.getvalue()), COLOUR.sub("", err.getvalue()))


def refusal(*arguments):
    """Run it where it must refuse: status 2, one line, nothing on stdout; return the line."""
    outcome = run_command_line(*arguments)
    assert outcome.status == 2, outcome
    assert outcome.out == ""
    assert len(outcome.messages) == 1, outcome.err
    (line,) = outcome.messages
    assert line.startswith("adaptive-ff: ")
    assert "Traceback" not in line
    return line


def search_shortly(patch):
    """Let a search for a motion start once, go one round, try a few motions near the best, and few bandwidths."""
    patch.setattr(exciting_motion, "find_excitations", functools.partial(find_excitations, starts=1, rounds=1))
    patch.setattr(exciting_motion, "polished", functools.partial(polished, trials=3))
    patch.setattr(bandwidth_study, "tried_bandwidths", lambda scenario: tried_bandwidths(scenario)[::-3][::-1])


def content_of(folder):
    """Every file below a folder with its content, and every folder."""
    paths = sorted(folder.rglob("*"))
    return {str(path.relative_to(folder)): None if path.is_dir() else path.read_bytes() for path in paths}
