"""Planar arms: commands are velocities of the hand, or of the two joints."""
