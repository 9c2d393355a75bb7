"""The yardstick: bounds on the earliest catch of any movement."""
