"""aerosim: simulator of airborne photo missions."""
