"""The studies of the program, a function for each, with its options as arguments.

Generated: what ``--help`` says. What is not given has the default of the program. Files are written
to the folder ``out``, and to files that options name.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from ._chain import Chain, Scene
from ._progress import Progress
from ._study import Study, called
