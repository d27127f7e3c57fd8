"""The verbs."""


def main() -> None:
    """Entry point."""
