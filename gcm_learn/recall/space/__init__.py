"""Recall for arms in space: catches kept in their joints."""
