"""Other programs' files: export and import, one module each."""
