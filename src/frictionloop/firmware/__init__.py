"""The controller as the firmware runs it: words, quantised forms, the C core on the host, the image."""
