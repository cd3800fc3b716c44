# SPDX-License-Identifier: BSD-3-Clause
"""The exceptions and the warning of the package."""


class SurfaceSynthesisError(RuntimeError):
    """A filter, reader or writer failed; the text is what VTK or the library reported.

    ``messages`` holds the reports one by one: a composite dataset may have several bad blocks.
    """

    def __init__(self, *messages):
        super().__init__("\n".join(messages))
        self.messages = list(messages)


class FormatError(SurfaceSynthesisError):
    """A file does not follow its format; the text starts with the file and, in text files, the line."""


class Cancelled(SurfaceSynthesisError):
    """The ``progress`` callable returned False."""


class SurfaceSynthesisWarning(UserWarning):
    """A result that was computed and may be of no use, such as noise on a mesh too coarse for the range."""
