"""Draw the pictures of the README and the documents: ``python -m gcm_learn.plots FOLDER``."""

import sys
from pathlib import Path

from gcm_learn.plots.reports.documents import write_gallery

for path in write_gallery(Path(sys.argv[1])):
    print(path)
