# SPDX-License-Identifier: BSD-3-Clause
"""Reads DICOM files with GDCM, as a program of its own: GDCM ends the process at some malformed files.

    python3 dicom_process.py headers|samples BYTES    (file names on standard input, one on each line as JSON)

BYTES is the size of the samples of the largest file, 0 for headers.
Before each file a line {"file": name} is written; after it, in JSON, its header or {"bytes": n} and n bytes of samples.
{"error": text} ends the output. Nothing else of the package is imported.
"""

import json
import os
import resource
import sys

#: Memory and processor time that reading may take: a fixed part, and one for each byte of the files.
_MEMORY, _MEMORY_PER_BYTE = 512 << 20, 8
_SECONDS, _BYTES_PER_SECOND = 10, 1 << 20

_UID, _NUMBER, _DESCRIPTION = (0x0020, 0x000E), (0x0020, 0x0011), (0x0008, 0x103E)
_POSITION, _ORIENTATION, _SPACING = (0x0020, 0x0032), (0x0020, 0x0037), (0x0028, 0x0030)
_SLOPE, _INTERCEPT = (0x0028, 0x1053), (0x0028, 0x1052)
#: Attributes of a header, as texts; a missing one is "".
_TEXTS = {
    "uid": _UID, "number": _NUMBER, "description": _DESCRIPTION, "instance": (0x0020, 0x0013),
    "acquisition": (0x0020, 0x0012), "rows": (0x0028, 0x0010), "columns": (0x0028, 0x0011), "frames": (0x0028, 0x0008),
    "channels": (0x0028, 0x0002), "bits": (0x0028, 0x0100), "signed": (0x0028, 0x0103),
    "stored": (0x0028, 0x0101), "high": (0x0028, 0x0102), "photometric": (0x0028, 0x0004), "thickness": (0x0018, 0x0050), "between": (0x0018, 0x0088),
    "position": _POSITION, "orientation": _ORIENTATION, "spacing": _SPACING, "slope": _SLOPE, "intercept": _INTERCEPT,
}  # fmt: skip
#: Transfer syntaxes of little endian samples as they are: with implicit and explicit types.
_PLAIN = ("1.2.840.10008.1.2", "1.2.840.10008.1.2.1")
_SHARED_GROUPS, _FRAME_GROUPS = (0x5200, 0x9229), (0x5200, 0x9230)
#: Attributes of a frame in files with several: the sequence that holds them, and the attribute in it.
_OF_FRAMES = {
    "position": ((0x0020, 0x9113), _POSITION), "orientation": ((0x0020, 0x9116), _ORIENTATION),
    "spacing": ((0x0028, 0x9110), _SPACING), "slope": ((0x0028, 0x9145), _SLOPE),
    "intercept": ((0x0028, 0x9145), _INTERCEPT), "thickness": ((0x0028, 0x9110), (0x0018, 0x0050)),
}  # fmt: skip


def main(mode, largest):
    """Answers for the files named on standard input."""
    names = [json.loads(line) for line in sys.stdin]
    try:
        import gdcm
    except ImportError:
        return _say(error="missing")
    _limit(sum(os.path.getsize(name) for name in names), largest)
    gdcm.Trace.WarningOff()
    gdcm.Trace.ErrorOff()
    for name in names:
        _say(file=name)
        answer = _header(gdcm, name) if mode == "headers" else _samples(gdcm, name)
        if not answer:
            return _say(error="GDCM cannot read this file; it is damaged, or of a kind that GDCM does not know")
    return None


def _say(**words):
    sys.stdout.buffer.write(json.dumps(words).encode() + b"\n")
    sys.stdout.buffer.flush()


def _limit(size, largest):
    for kind, most in (
        (resource.RLIMIT_AS, _MEMORY + _MEMORY_PER_BYTE * (size + largest)),
        (resource.RLIMIT_CPU, _SECONDS + size // _BYTES_PER_SECOND),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(kind)[1]
        resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _header(gdcm, name):
    reader = gdcm.Reader()
    reader.SetFileName(name)
    pixels = gdcm.Tag(0x7FE0, 0x0010)
    if not reader.ReadUpToTag(pixels, gdcm.TagSetType([pixels])):  # whose value is skipped
        return False
    file = reader.GetFile()
    texts = gdcm.StringFilter()
    texts.SetFile(file)
    data = file.GetDataSet()
    header = {}
    for key, tag in _TEXTS.items():
        found = data.FindDataElement(gdcm.Tag(*tag)) and not data.GetDataElement(gdcm.Tag(*tag)).IsEmpty()
        header[key] = _printable(texts.ToString(gdcm.Tag(*tag))) if found else ""
    syntax = file.GetHeader().GetDataSetTransferSyntax()
    header["encapsulated"] = syntax.IsEncapsulated()
    header["plain"] = syntax.GetString() in _PLAIN
    header["begin"] = reader.GetStreamCurrentPosition()
    header["groups"] = _groups(gdcm, data)
    _say(**header)
    return True


def _printable(text):
    return "".join(c if c.isprintable() else "?" for c in text.strip(" \0"))


def _groups(gdcm, data):
    """The attributes of each frame, of those that all share where the frame has none; [] without such groups."""
    shared = next(iter(_items(gdcm, data, _SHARED_GROUPS)), None)
    groups = []
    for item in _items(gdcm, data, _FRAME_GROUPS):
        group = {}
        for key, (sequence, tag) in _OF_FRAMES.items():
            for source in (item, shared):
                inner = next(iter(_items(gdcm, source, sequence)), None) if source is not None else None
                if inner is not None and inner.FindDataElement(gdcm.Tag(*tag)):
                    group[key] = _printable(str(inner.GetDataElement(gdcm.Tag(*tag)).GetValue()))
                    break
        groups.append(group)
    return groups


def _items(gdcm, data, tag):
    """The datasets in a sequence."""
    if not data.FindDataElement(gdcm.Tag(*tag)):
        return []
    sequence = data.GetDataElement(gdcm.Tag(*tag)).GetValueAsSQ()
    number = sequence.GetNumberOfItems() if sequence else 0
    return [sequence.GetItem(k).GetNestedDataSet() for k in range(1, number + 1)]


def _samples(gdcm, name):
    reader = gdcm.ImageReader()
    reader.SetFileName(name)
    if not reader.Read():
        return False
    samples = reader.GetImage().GetBuffer().encode("utf-8", "surrogateescape")
    _say(bytes=len(samples))
    sys.stdout.buffer.write(samples)
    return True


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
