"""Score a method, or frames of another program: ``python evaluate.py --help``."""

from supersampling.commands.entry import script

if __name__ == "__main__":
    script(__file__)
