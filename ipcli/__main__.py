"""`python -m ipcli`."""

import sys

from ipcli.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
