"""scene.proto as data: what the tests hold the Python classes against."""
import pathlib
import re
from typing import NamedTuple

SCHEMA = pathlib.Path(__file__).parents[2] / "proto/tessera/v1/scene.proto"
SCALARS = {"double", "float", "bool", "string", "uint32", "int32", "uint64", "bytes"}


class Field(NamedTuple):
    message: str  # "Texture.Image"
    name: str
    type: str     # a scalar, or the full name of a message or an enumeration
    repeated: bool
    oneof: str


def read():
    """(fields by message, values by enumeration), names relative to the package."""
    text = re.sub(r"//[^\n]*", "", SCHEMA.read_text())
    messages, enums, open_blocks = {}, {}, []
    for match in re.finditer(r"(message|enum|oneof)\s+(\w+)\s*\{|\}|([^;{}]+);", text):
        scope = ".".join(name for kind, name in open_blocks if kind != "oneof")
        if match[1]:
            open_blocks.append((match[1], match[2]))
            full = f"{scope}.{match[2]}".lstrip(".")
            if match[1] == "message":
                messages[full] = []
            elif match[1] == "enum":
                enums[full] = []
        elif match[0] == "}":
            open_blocks.pop()
        elif open_blocks and open_blocks[-1][0] == "enum":
            enums[scope].append(match[3].split("=")[0].strip())
        elif found := re.match(r"\s*(optional|repeated)?\s*(map<.*>|[\w.]+)\s+(\w+)\s*=", match[3]):
            oneof = open_blocks[-1][1] if open_blocks[-1][0] == "oneof" else ""
            messages[scope].append(Field(scope, found[3], found[2], found[1] == "repeated", oneof))
    known = set(messages) | set(enums)
    return {name: [f._replace(type=_resolve(f, known)) for f in fields]
            for name, fields in messages.items()}, enums


def _resolve(field, known):
    if field.type in SCALARS or field.type.startswith("map"):
        return field.type
    scope = field.message.split(".")
    candidates = (".".join(scope[:i] + [field.type]) for i in range(len(scope), -1, -1))
    return next(name for name in candidates if name in known)
