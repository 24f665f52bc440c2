"""An experiment in a browser: a page for the participant and one for the experimenter, on one machine or two."""
