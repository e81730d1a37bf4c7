"""Train a method and log it: ``python train.py --help``."""

from supersampling.commands.entry import script

if __name__ == "__main__":
    script(__file__)
