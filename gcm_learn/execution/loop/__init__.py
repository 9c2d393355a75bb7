"""Loops in which agents command plants, with exact or with perceived situations."""
