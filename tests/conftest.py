"""What holds for all tests."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

# A busy machine is no fault of the code: no limit on time, neither on an example nor on drawing it.
# By default the examples are the same in every run, so that a red test stays red until mended;
# `pytest --hypothesis-profile=search` draws new ones. Both print how to repeat what they find.
settings.register_profile(
    "same",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    print_blob=True,
    derandomize=True,
)
settings.register_profile("search", settings.get_profile("same"), derandomize=False)
settings.load_profile("same")
