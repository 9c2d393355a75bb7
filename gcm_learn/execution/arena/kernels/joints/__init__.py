"""Spatial arms: commands are rates of the four joints."""
