# SPDX-License-Identifier: BSD-3-Clause
"""A check of VTK's XML files before VTK reads them: VTK takes the memory that a file announces, and follows indices and
nested blocks wherever they lead."""

import os
from xml.parsers import expat

from ..errors import FormatError

#: Bytes that one byte of a file may stand for: above what deflate (1032) and LZ4 (255) reach, and LZMA in practice.
_LARGEST_RATIO = 8192
#: Blocks within blocks, and the largest index of a block.
_DEEPEST = 100
_LARGEST_INDEX = 1_000_000
#: Attributes of a piece that announce a number of items.
_COUNTS = ("NumberOfPoints", "NumberOfCells", "NumberOfVerts", "NumberOfLines", "NumberOfStrips", "NumberOfPolys")
_EXTENTS = ("WholeExtent", "Extent")
_NESTED = ("Block", "MultiBlock", "vtkMultiBlockDataSet", "Piece")
_BLOCK_SIZE = 1 << 20


def check_vtk_xml(path):
    """Raises FormatError when a file, or one that it names in the same folder tree, announces more points, cells or values
    than its bytes can hold, has an index of a block below 0 or above 1,000,000, or more than 100 blocks within each
    other. Whatever else is wrong is left to VTK's reader. Appended data are not read."""
    for piece in dict.fromkeys(_Check(path).run()):  # each once
        source = os.path.join(os.path.dirname(path), piece)
        if os.path.isfile(source):
            _Check(source).run()
        elif os.path.exists(source) and not os.path.isdir(source):
            raise FormatError(f"{path}: the piece {piece} is no regular file, but a pipe, socket or device")


class _Check:
    def __init__(self, path):
        self._path = path
        self._size = os.path.getsize(path)
        self._depth = 0
        self._done = False
        self._items = 0  # the most items that an array of the piece at hand has
        self._pieces = []

    def run(self):
        """The files that the file names."""
        parser = expat.ParserCreate()
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.StartDoctypeDeclHandler = self._doctype
        with open(self._path, "rb") as file:
            try:
                while not self._done:
                    block = file.read(_BLOCK_SIZE)
                    parser.Parse(block, not block)
                    self._done = self._done or not block
            except expat.ExpatError:
                pass  # in VTK's words
        return self._pieces

    def _doctype(self, *_):
        raise FormatError(f"{self._path}: VTK's XML files have no document type declaration")

    def _start(self, name, attributes):
        if name == "AppendedData":  # which need not be XML
            self._done = True
            return
        self._depth += name in _NESTED
        if self._depth > _DEEPEST:
            raise FormatError(f"{self._path}: more than {_DEEPEST} blocks lie within each other")
        if name == "Piece":
            self._items = 0
        for key in _COUNTS:
            if key in attributes:
                self._items = max(self._items, self._count(key, attributes[key]))
        for key in _EXTENTS:
            if key in attributes:
                self._items = max(self._items, self._extent(key, attributes[key]))
        if name in ("DataArray", "Array"):
            self._check_array(attributes)
        if "index" in attributes:
            self._check_index(attributes["index"])
        if name == "DataSet" and attributes.get("file"):
            self._pieces.append(attributes["file"])

    def _end(self, name):
        self._depth -= name in _NESTED

    def _count(self, key, text):
        return self._possible(key, text, self._integer(key, text))

    def _extent(self, key, text):
        words = text.split()
        if len(words) != 6:
            return 0
        numbers = [self._integer(key, word) for word in words]
        count = 1
        for lower, upper in zip(numbers[::2], numbers[1::2]):
            count *= max(upper - lower + 1, 0)
        return self._possible(key, text, count if max(map(abs, numbers)) < 2**31 else -1)

    def _check_array(self, attributes):
        components = self._count("NumberOfComponents", attributes.get("NumberOfComponents", "1"))
        tuples = self._count("NumberOfTuples", attributes.get("NumberOfTuples", str(self._items)))
        self._possible("NumberOfComponents", attributes.get("NumberOfComponents", "1"), components * tuples)

    def _possible(self, key, text, count):
        """The count, when the file can hold as many values."""
        if not 0 <= count <= self._size * _LARGEST_RATIO:
            raise FormatError(f"{self._path}: {key} is {_shortened(text)}, which a file of {self._size} bytes cannot hold")
        return count

    def _check_index(self, text):
        if not 0 <= self._integer("the index of a block", text) <= _LARGEST_INDEX:
            raise FormatError(
                f"{self._path}: the index of a block is {_shortened(text)}; from 0 to {_LARGEST_INDEX} is possible"
            )

    def _integer(self, what, text):
        digits = text.strip().removeprefix("-")
        if not digits.isascii() or not digits.isdigit() or len(digits) > 40:
            raise FormatError(f"{self._path}: {what} is '{_shortened(text)}', which is no integer")
        return int(text)


def _shortened(text):
    return text if len(text) <= 40 else text[:37] + "..."
