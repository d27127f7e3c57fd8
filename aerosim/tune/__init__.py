"""From recorded flights and notes to what a filter ought to assume: tables of disturbances over height."""
