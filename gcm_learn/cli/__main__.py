"""``python -m gcm_learn.cli``: as ``python -m gcm_learn``."""

import sys

from gcm_learn.cli import main

if __name__ == "__main__":
    sys.exit(main())
