"""``python -m cfmpm``."""

from cfmpm.cli import main

main()
