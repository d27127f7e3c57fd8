"""A user's own aircraft: looked at and tried before it flies."""
