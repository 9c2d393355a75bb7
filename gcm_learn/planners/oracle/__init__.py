"""The yardstick: bounds on the earliest catch of any movement."""

from gcm_learn.planners.oracle.bounds import Bounds, OraclePlanner, bounds, stratum

__all__ = ["Bounds", "OraclePlanner", "bounds", "stratum"]
