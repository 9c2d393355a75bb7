"""``python -m gcm_learn``: the command line without its console script."""

import sys

from gcm_learn.cli import main

if __name__ == "__main__":
    sys.exit(main())
