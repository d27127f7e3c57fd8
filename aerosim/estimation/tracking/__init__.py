"""Mode `best`: all strips, windows that follow the prediction, least squares, filters that know the delay."""
