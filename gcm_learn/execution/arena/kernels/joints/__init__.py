"""Spatial arms: commands are rates of the joints."""
