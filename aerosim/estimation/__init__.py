"""Belief: from the rows' grey values to drift and v/h.  Nothing here knows the truth."""
