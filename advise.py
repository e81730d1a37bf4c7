"""Find what a scene requires: ``python advise.py --help``."""

from supersampling.commands.entry import script

if __name__ == "__main__":
    script(__file__)
