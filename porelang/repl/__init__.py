"""`pore repl`: a program that is written a line at a time, and asked what its names are worth."""
