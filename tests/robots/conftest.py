"""Modules that need ROS 2, which pytest must not import: `tests/robots/run` has it in an environment of its own."""

collect_ignore = ["bridge.py", "codec.py", "driver.py"]
