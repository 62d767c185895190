"""The command line in this process, for tests."""

import io
import sys
import warnings
from contextlib import redirect_stderr, redirect_stdout
from typing import NamedTuple
from unittest.mock import patch

import pytest

from adaptive_ff.cli import main

WARNING = ("adaptive-ff: warning:", "warning:")


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


def run_command_line(*arguments):
    """Run ``adaptive-ff`` with arguments, warnings shown as for a user."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["adaptive-ff", *(str(argument) for argument in arguments)]
    with warnings.catch_warnings(), patch.object(sys, "argv", argv), redirect_stdout(out), redirect_stderr(err):
        warnings.simplefilter("default")
        with pytest.raises(SystemExit) as ended:
            main()
    return Outcome(ended.value.code or 0, out.getvalue(), err.getvalue())


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


def content_of(folder):
    """Every file below a folder with its content, and every folder."""
    paths = sorted(folder.rglob("*"))
    return {str(path.relative_to(folder)): None if path.is_dir() else path.read_bytes() for path in paths}
