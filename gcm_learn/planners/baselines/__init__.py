"""Planners that maps are compared with."""
