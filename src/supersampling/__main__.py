"""``python -m supersampling``: the console command without its script."""

from supersampling.commands.entry import main

if __name__ == "__main__":
    main()
