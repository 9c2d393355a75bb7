"""Figures: functions that take records and draw them with matplotlib."""
