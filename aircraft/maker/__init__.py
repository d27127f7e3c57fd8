"""Makes the aircraft that ship: tables of sourced coefficients, and what writes JSBSim models out of them."""
