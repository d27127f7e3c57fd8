"""The flight: aircraft, trim, plan, guidance.  Nothing is imported here: the plan needs no JSBSim."""
