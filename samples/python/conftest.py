"""The fixture and the marker of deadline_test.py."""

pytest_plugins = ["gicube.testing"]
