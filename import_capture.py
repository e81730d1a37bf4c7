"""Import a capture of another program: ``python import_capture.py --help``."""

from supersampling.commands.entry import script

if __name__ == "__main__":
    script(__file__)
