"""The force sensor: springs, electrodes, front end, noise, netlist."""
