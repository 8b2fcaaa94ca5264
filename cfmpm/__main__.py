"""``python -m cfmpm``."""

from cfmpm.cli import main

if __name__ == "__main__":
    main()
