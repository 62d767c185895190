"""What a comparison looks like in a console, a notebook, pandas and xarray."""

from html.parser import HTMLParser

import numpy as np
import pytest

from adaptive_ff import compare, load_scenario


@pytest.fixture(scope="module")
def comparison():
    return compare(load_scenario().modified(duration=6.0, controllers=["pi", "adaptive"]))


def test_short_texts(comparison):
    settled = {name: run.metrics.rms_error_settled for name, run in comparison.runs.items()}
    shown = f"pi {settled['pi']:.3g}, adaptive {settled['adaptive']:.3g}"
    assert repr(comparison) == f"Comparison(settled rms error, rad/s: {shown})"
    assert repr(comparison.runs["pi"]) == f"Run('pi', 6 s, settled rms error {settled['pi']:.3g} rad/s)"


def test_notebook_shows_tables_and_a_picture(comparison):
    tags = []

    class Seen(HTMLParser):
        def handle_starttag(self, tag, attrs):
            tags.append(tag)

    text = comparison._repr_html_()
    Seen().feed(text)
    assert tags.count("table") == 2
    assert tags.count("img") == 1
    assert f"{comparison.improvement['adaptive']:.2f}</td>" in text
    assert "kg m²" in text


def test_frame_of_pandas(comparison):
    pytest.importorskip("pandas")
    frame = comparison.to_pandas()
    assert list(frame.index) == ["pi", "adaptive"]
    for name, run in comparison.runs.items():
        assert frame.loc[name, "rms_error_settled"] == run.metrics.rms_error_settled
        assert frame.loc[name, "improvement"] == comparison.improvement[name]
    assert frame.attrs["units"]["rms_error"] == "rad/s"
    assert set(frame.attrs["units"]) == set(frame.columns)


def test_dataset_of_xarray(comparison):
    pytest.importorskip("xarray")
    dataset = comparison.to_xarray()
    run = comparison.runs["adaptive"]
    assert np.array_equal(dataset["torque"].sel(controller="adaptive"), run.torque)
    assert np.array_equal(dataset["time"], run.time)
    assert (dataset["torque"].attrs["units"], dataset["velocity"].attrs["units"]) == ("N m", "rad/s")
    assert dataset["time"].attrs["units"] == "s"
