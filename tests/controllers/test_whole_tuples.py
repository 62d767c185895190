"""Named tuples of the packages are one value each in compiled code; those of others are what numba makes of them."""

from typing import NamedTuple

import numba
from numba.core.registry import cpu_target
from numba.extending import register_jitable

from adaptive_ff.adaptive.command import CommandState
from controllers import Inputs, Output
from controllers.compiled import compiled_in_place
from controllers.kernels import planned_inputs, with_feedforward
from tests.helpers.in_memory import run_in_memory


class Named(NamedTuple):
    count: int
    flag: bool
    inner: Output


class Row(NamedTuple):
    first: float
    second: float


OURS = CommandState(True, 0.5), Output(1.0, 2.0), planned_inputs(0.0, 0.0, 0.0, 0.0, 0.01)


def model(value):
    return cpu_target.target_context.data_model_manager[numba.typeof(value)]


def test_tuples_of_the_packages_are_one_value_as_argument_result_and_in_memory():
    for value in OURS:
        found = model(value)
        forms = found.get_argument_type(), found.get_return_type(), found.get_data_type()
        assert forms == (found.get_value_type(),) * 3, type(value)


def test_tuples_of_others_are_taken_apart_as_numba_does():
    for value in (Named(1, True, Output(1.0, 2.0)), Row(1.0, 2.0)):
        assert len(model(value).get_argument_type()) == len(value)


@register_jitable
def turned(named):
    return Named(named.count + 1, not named.flag, Output(named.inner.feedforward, named.inner.torque))


def test_a_tuple_of_others_holds_one_of_the_packages():
    value = Named(3, True, Output(1.0, 2.0))
    assert compiled_in_place(lambda named: turned(turned(turned(named))))(value) == turned(value)._replace(count=6)


def test_flags_go_to_memory_and_back_whole():
    for flag in (False, True):
        value = CommandState(flag, 0.25)
        assert run_in_memory(lambda held: (held, not held.feedforward_enabled), value) == (value, not flag)


def test_a_function_that_numba_alone_compiles_hands_tuples_to_kernels_and_back():
    inputs = Inputs(*range(1, 12))._replace(feedforward=0.5)

    def twice(given, torque):
        return with_feedforward(with_feedforward(given, torque), torque)

    assert tuple(compiled_in_place(twice)(inputs, 0.25)) == tuple(inputs._replace(feedforward=1.0))
    assert tuple(numba.njit(error_model="numpy")(twice)(inputs, 0.25)) == tuple(inputs._replace(feedforward=1.0))
