"""Makes the helpers in this folder importable for all tests, and keeps hypothesis from judging by the clock."""

from hypothesis import HealthCheck, settings

settings.register_profile("without clock", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("without clock")
