# SPDX-License-Identifier: GPL-3.0-or-later
"""Of two versions that were installed, one's native module may meet the other's package: one sentence says so."""

from __future__ import annotations

import pytest

from tyndall import _native, native_fit


def test_what_was_built_together_fits() -> None:
    native_fit.require_fit()


class _OfAnotherVersion:
    """As pybind11's classes refuse arguments that they do not know."""

    def __init__(self, *_places: object, **_arguments: object) -> None:
        raise TypeError("__init__(): incompatible constructor arguments. The following argument types are supported:")


@pytest.mark.parametrize(
    "name", ["Light", "OccluderEdit", "Heterogeneity", "WeightedFunction", "FrameConfig", "Camera"]
)
def test_a_native_module_of_another_version_is_named_in_words(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """Not in pybind11's: both folders, and what to do; the first error is its cause."""
    monkeypatch.setattr(_native, name, _OfAnotherVersion)
    with pytest.raises(
        RuntimeError, match=r"is of another version than the package in .*: install Tyndall again"
    ) as refused:
        native_fit.require_fit()
    assert "incompatible constructor arguments" in str(refused.value.__cause__)


@pytest.mark.parametrize("name", ["render", "HoleNoise"])
def test_a_native_module_that_lacks_something_is_named_as_well(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """One that is older than the package."""
    monkeypatch.delattr(_native, name)
    with pytest.raises(RuntimeError, match="is of another version than the package"):
        native_fit.require_fit()
