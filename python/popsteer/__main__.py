"""``python -m popsteer``: the command line."""

from popsteer.cli import main

if __name__ == "__main__":
    main()
