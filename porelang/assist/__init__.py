"""What is told of a place in a text to who writes it: names and what they stand for, what may stand here, what a call
takes, the outline. Pure functions of a snapshot; an editor, a page and a REPL ask the same ones.
"""
