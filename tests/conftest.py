"""Makes the helpers in this folder importable for all tests, and keeps hypothesis from judging by the clock."""

from hypothesis import settings

settings.register_profile("without clock", deadline=None)
settings.load_profile("without clock")
