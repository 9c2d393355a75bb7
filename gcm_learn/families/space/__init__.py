"""Families for an arm in space."""
