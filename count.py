"""Count parameters and operations: ``python count.py --help``."""

from supersampling.commands.entry import script

if __name__ == "__main__":
    script(__file__)
