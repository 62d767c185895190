"""A regression test of tracking: ``pytest examples/guard_tracking.py``.

The first time ``pytest examples/guard_tracking.py --update-tracking-baseline`` stores the baseline.
"""

import tempfile
from pathlib import Path

from adaptive_ff import assert_no_regression, compare, load_scenario

SCENARIO = load_scenario().modified(duration=10.0, controllers=["pi", "adaptive"])


def test_tracking_is_as_good_as_it_was(tracking_baseline):
    """Fail where a figure of tracking got worse than in the stored baseline."""
    tracking_baseline.check(compare(SCENARIO), tolerance={"default": "5%", "max_error": "20%"})


if __name__ == "__main__":  # the same without pytest
    baseline = Path(tempfile.mkdtemp()) / "baseline.json"
    compare(SCENARIO).write(baseline)
    assert_no_regression(compare(SCENARIO), baseline, tolerance="1%")
    print("tracking is as good as it was")
    try:
        assert_no_regression(compare(SCENARIO.modified(feedback={"bandwidth": 8.0})), baseline)
    except ValueError as error:
        print(error)
