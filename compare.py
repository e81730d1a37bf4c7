"""Compare two methods over the same clips: ``python compare.py --help``."""

from supersampling.commands.entry import script

if __name__ == "__main__":
    script(__file__)
