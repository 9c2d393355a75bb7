"""Families for chains."""
