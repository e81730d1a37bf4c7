"""Export a data set as a capture: ``python export_capture.py --help``."""

from supersampling.commands.entry import script

if __name__ == "__main__":
    script(__file__)
