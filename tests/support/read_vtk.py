"""Reads .vtp and legacy .vtk files with Python's standard library alone, and prints what is in them as
JSON: a reader that shares no line of code with the writer."""

import base64
import json
import struct
import sys
import urllib.parse
import xml.etree.ElementTree as ElementTree
import zlib

FORMATS = {"Float64": "d", "Float32": "f", "Int32": "i", "Int64": "q", "UInt8": "B"}


def decode_binary(text):
    """Inline binary, zlib: base64(header) then base64(blocks); the header counts the blocks."""
    text = text.strip()
    blocks = struct.unpack("<I", base64.b64decode(text[:8])[:4])[0]
    if blocks == 0:
        return b""
    header_size = 4 * (3 + blocks)
    header_chars = (header_size + 2) // 3 * 4
    header = struct.unpack("<%dI" % (3 + blocks), base64.b64decode(text[:header_chars])[:header_size])
    data = base64.b64decode(text[header_chars:])
    out, at = b"", 0
    for size in header[3:]:
        out += zlib.decompress(data[at:at + size])
        at += size
    return out


def array_values(element):
    data = decode_binary(element.text)
    if element.get("type") == "String":
        return data.split(b"\0")[0].decode("utf-8")
    code = FORMATS[element.get("type")]
    return list(struct.unpack("<%d%s" % (len(data) // struct.calcsize(code), code), data))


def arrays_of(parent):
    return {} if parent is None else {e.get("Name"): array_values(e) for e in parent}


def read_vtp(path):
    root = ElementTree.parse(path).getroot()
    assert root.get("compressor") == "vtkZLibDataCompressor" and root.find("AppendedData") is None
    data = root.find("PolyData")
    piece = data.find("Piece")
    lines = arrays_of(piece.find("Lines"))
    starts = [0] + lines["offsets"][:-1] if lines["offsets"] else []
    return {
        "points": arrays_of(piece.find("Points"))["Points"],
        "lines": [lines["connectivity"][a:b] for a, b in zip(starts, lines["offsets"])],
        "point_data": arrays_of(piece.find("PointData")),
        "cell_data": arrays_of(piece.find("CellData")),
        "field_data": arrays_of(data.find("FieldData")),
    }


def read_arrays(words, count):
    """`count` arrays of a FIELD: name, components, tuples, type, values."""
    out = {}
    for _ in range(count):
        name, components, tuples, kind = (next(words) for _ in range(4))
        values = [next(words) for _ in range(int(components) * int(tuples))]
        if kind == "string":
            out[name] = urllib.parse.unquote(values[0])
        else:
            out[name] = [float(v) for v in values]
        peeked = words.peek()
        if peeked == "METADATA":
            raise ValueError("METADATA is not part of version 4.2")
    return out


class Words:
    """Words of a text, one ahead."""

    def __init__(self, text):
        self.words, self.at = text.split(), 0

    def __next__(self):
        self.at += 1
        return self.words[self.at - 1]

    def __iter__(self):
        return self

    def peek(self):
        return self.words[self.at] if self.at < len(self.words) else None


def read_legacy(path):
    text = open(path, encoding="ascii").read()
    first, _, kind, rest = text.split("\n", 3)
    assert first == "# vtk DataFile Version 4.2" and kind == "ASCII", (first, kind)
    words = Words(rest)
    out = {"lines": [], "points": [], "point_data": {}, "cell_data": {}, "field_data": {}}
    section = "field_data"
    assert [next(words), next(words)] == ["DATASET", "POLYDATA"]
    while words.peek() is not None:
        word = next(words)
        if word == "FIELD":
            next(words)
            out[section].update(read_arrays(words, int(next(words))))
        elif word == "POINTS":
            count, _ = int(next(words)), next(words)
            out["points"] = [float(next(words)) for _ in range(3 * count)]
        elif word == "LINES":
            count, _ = int(next(words)), next(words)
            for _ in range(count):
                out["lines"].append([int(next(words)) for _ in range(int(next(words)))])
        elif word in ("POINT_DATA", "CELL_DATA"):
            section = word.lower()
            next(words)
        else:
            raise ValueError("unexpected " + word)
    return out


if __name__ == "__main__":
    reader = read_vtp if sys.argv[1].endswith(".vtp") else read_legacy
    json.dump(reader(sys.argv[1]), sys.stdout, allow_nan=False)
