"""``python -m followspot``."""

from followspot.cli import main

if __name__ == "__main__":
    main()
