# SPDX-License-Identifier: GPL-2.0-or-later
"""The one exception that users see: a sentence that names file, key or place."""


class FloeError(Exception):
    """A fault in what the user gave, said in one clear sentence.

    The front door and the stages print it without a traceback and exit with code 1.
    """
